#pragma once

#include <sched.h>

#include <cstdint>
#include <string>
#include <vector>

#include "run/home.hpp"

/// Measurements of the orchestrator itself, with real participants and the real engine. Every
/// figure is a median over many windows behind a warm-up; the machine need not be quiet, but the
/// spread tells when it was not.
namespace sandglass::bench {

/// Seconds: the median, and between what a tenth and nine tenths of the samples lie.
struct Spread {
  double median = 0;
  double low = 0;
  double high = 0;
  std::size_t samples = 0;
};
Spread spread_of(std::vector<double> seconds);

/// Keeps this process, and whatever it starts meanwhile, on the processor where it is now: what
/// `taskset -c 0` does for a whole run. Nothing happens where the system does not allow it.
class OneProcessor {
 public:
  OneProcessor();
  ~OneProcessor();
  OneProcessor(const OneProcessor&) = delete;
  OneProcessor& operator=(const OneProcessor&) = delete;

 private:
  cpu_set_t before_{};
  bool held_ = false;
};

/// One window of two resident Python programs that send back what they receive
/// (templates/bench/pair.yaml): two round trips, one field each way.
struct PairOptions {
  std::int64_t values = 10;    ///< doubles in each field
  std::int64_t windows = 200;  ///< measured, after a warm-up
  bool recorded = false;       ///< both fields go into the record
  bool watched = true;         ///< by the stability watch
};
Spread pair_window(const run::Home& home, const std::string& folder, const PairOptions& options);

/// The same two round trips of so many doubles through bare pipes to one Python program: the
/// cheapest thing possible, to compare with.
Spread pipe_window(const run::Home& home, const std::string& folder, std::int64_t values,
                   std::int64_t windows);

/// Bytes per second, in rows of two fields of `values` doubles.
struct WriteRates {
  double record = 0;  ///< from the first row handed over until the last is in the file
  double plain = 0;   ///< the same bytes appended to a file, and nothing else
};
/// The best of several of each, in turn: what the machine can do when others leave it alone.
WriteRates write_rates(const std::string& folder, std::int64_t values, std::int64_t windows);

/// Windows of the settling sphere (workflows/icy_stokes_sphere.yaml).
struct SphereTimes {
  double start = 0;  ///< s, from nothing to the end of the first window
  Spread window;     ///< the ones behind it
};
SphereTimes sphere(const run::Home& home, const std::string& folder, bool fresh,
                   std::int64_t windows);

/// What the windows of the sphere take with everything left out that it does not need (the first
/// one, without a name), and with each of these things put back.
struct PutBack {
  std::string name;
  Spread window;
};
std::vector<PutBack> sphere_with_put_back(const run::Home& home, const std::string& folder,
                                          std::int64_t windows);

/// The same sphere coupled as ICY does (templates/bench/polling.py), which looks for its result
/// every `interval` seconds.
Spread polled_sphere(const run::Home& home, const std::string& folder, std::int64_t windows,
                     double interval);

/// The impact on a beam (workflows/beam_single_impact.yaml) at the paper's step, exchanged in every
/// step.
struct ImpactTimes {
  double all = 0;        ///< s, from nothing to the end of the last window
  double windows = 0;    ///< s, behind the first one
  double overhead = 0;   ///< s per window in which no participant worked
  double processor = 0;  ///< s per window of the orchestrator's own processor time
};
ImpactTimes impact(const run::Home& home, const std::string& folder, const std::string& continuum,
                   std::int64_t windows);

/// The same with finite elements in one FreeFEM that exchanges nothing: s of so many steps.
double impact_alone(const run::Home& home, const std::string& folder, std::int64_t windows);

/// A mapping between 180 000 triangles and so many other points.
struct MappingTimes {
  double made = 0;     ///< s, for points that are new
  double applied = 0;  ///< s, to a field of vectors
};
MappingTimes mapping(std::int64_t points, bool linear);

/// Seconds from `sandglass resume` to the first new window, of the sphere killed at some moment.
double resume_seconds(const run::Home& home, const std::string& folder);

/// Seconds that `sandglass study` takes when everything is there already.
double idle_study_seconds(const run::Home& home, const std::string& folder);

}  // namespace sandglass::bench
