#include "bench/loaded.hpp"

#include <time.h>  // NOLINT(modernize-deprecated-headers): clock_gettime

#include "base/clock.hpp"
#include "run/coupled_stage.hpp"

namespace sandglass::bench {
namespace {

/// Seconds that all threads of this program have spent on a processor, in it or in the system.
double processor_time() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

workflow::Workflow loaded(const run::Home& home, const std::string& path,
                          const std::vector<workflow::Setting>& settings,
                          const std::vector<std::string>& put_back) {
  workflow::LoadOptions options;
  options.templates_root = home.templates();
  options.data_root = home.data();
  options.settings = settings;
  options.keep = put_back;
  return workflow::load(path, options);
}

WindowEnds window_ends(const run::Home& home, const workflow::Workflow& workflow,
                       const std::string& folder) {
  const auto directory = record::RunDirectory::create({}, folder, workflow.name);
  run::Scripts scripts(home.templates(), directory.folder("scripts"));
  run::CoupledOutcome outcome;
  const SystemClock clock;
  WindowEnds result;
  result.ends.reserve(static_cast<std::size_t>(workflow.coupling->windows));
  result.begin = clock.now();
  double first = 0;
  double last = 0;
  run::run_coupling(workflow, home, directory, scripts, run::Span{}, outcome,
                    [&](std::int64_t, double) {
                      result.ends.push_back(clock.now());
                      last = processor_time();
                      if (result.ends.size() == 1) first = last;
                    });
  result.overhead = outcome.overhead_per_window();
  if (result.ends.size() > 1) {
    result.processor = (last - first) / static_cast<double>(result.ends.size() - 1);
  }
  return result;
}

std::vector<double> differences(std::span<const double> times) {
  std::vector<double> result;
  for (std::size_t i = 1; i < times.size(); ++i) result.push_back(times[i] - times[i - 1]);
  return result;
}

}  // namespace sandglass::bench
