#include "bench/bench.hpp"

#include <fmt/format.h>
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): getloadavg, mkdtemp

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <utility>

#include "base/file.hpp"
#include "cli/cli.hpp"
#include "process/interrupt.hpp"
#include "record/provenance.hpp"

namespace sandglass::cli {
namespace {

struct Options {
  std::string folder;
  bool short_one = false;
  std::vector<std::string> parts;  ///< none: all

  [[nodiscard]] bool wants(const std::string& part) const {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  }
};

/// A folder of its own below another, gone at the end.
class Scratch {
 public:
  explicit Scratch(const std::string& below) : path_(below + "/sandglass-bench-XXXXXX") {
    if (::mkdtemp(path_.data()) == nullptr) throw_system_error("make a folder in", below, errno);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// What issue and README promise of the coupling overhead, in s per window.
struct Promise {
  std::int64_t values;
  std::int64_t windows;
  double without_record;
  double record_adds;  ///< 0: nothing promised
};
constexpr std::array<Promise, 3> kPromises = {
    {{10, 5000, 30e-6, 10e-6}, {1000, 5000, 45e-6, 20e-6}, {100'000, 400, 800e-6, 0}}};
constexpr double kRecordRate = 1e9;              // bytes/s
constexpr double kAgainstIcy = 5000;             // times
constexpr double kIdleStudy = 0.2;               // s
constexpr std::int64_t kImpactWindows = 20'000;  // of 50 ns
struct ImpactPromise {
  const char* continuum;
  const char* name;
  double seconds;
};
constexpr std::array<ImpactPromise, 2> kImpacts = {
    {{"fem", "finite elements", 20}, {"mpm", "material points", 90}}};
constexpr double kImpactOverhead = 50e-6;  // s per window
constexpr double kMapped = 1;              // s
constexpr double kInterval = 0.1;          // s between two looks of the stand-in for ICY

std::string microseconds(const bench::Spread& spread) {
  return fmt::format("{:9.1f} [{:.1f} to {:.1f}]", 1e6 * spread.median, 1e6 * spread.low,
                     1e6 * spread.high);
}

const char* verdict(bool kept) { return kept ? "kept" : "MISSED"; }

std::string load() {
  std::array<double, 3> average{};
  return ::getloadavg(average.data(), 3) == 3 ? fmt::format("{:.2f}", average[0]) : "unknown";
}

void show_machine(const std::string& folder) {
  const nlohmann::json machine = record::describe_machine();
  fmt::print("{}, {} cores, {:.0f} GB, {}\n", machine.at("processor").get<std::string>(),
             machine.at("cores").get<int>(), machine.at("memory_bytes").get<double>() / 1e9,
             machine.at("system").get<std::string>());
  fmt::print("load {} at the begin; files below {}\n", load(), folder);
  fmt::print("Medians, and in brackets where eight tenths of the windows lie.\n");
}

void show_exchange(const run::Home& home, const std::string& folder, std::int64_t divisor) {
  fmt::print("\nTwo resident Python programs, one field each way: us per window\n");
  for (const Promise& promise : kPromises) {
    const std::int64_t windows = promise.windows / divisor;
    bench::PairOptions pair{promise.values, windows, false, true};
    const bench::Spread bare = bench::pair_window(home, folder, pair);
    pair.watched = false;
    const bench::Spread unwatched = bench::pair_window(home, folder, pair);
    pair.watched = true;
    pair.recorded = true;
    const bench::Spread recorded = bench::pair_window(home, folder, pair);
    const bench::Spread pipe = bench::pipe_window(home, folder, promise.values, windows);
    pair.recorded = false;
    const auto [together, pipe_together] = [&] {
      const bench::OneProcessor shared;
      return std::pair(bench::pair_window(home, folder, pair),
                       bench::pipe_window(home, folder, promise.values, windows));
    }();
    const double adds = recorded.median - bare.median;
    fmt::print("{} doubles, {} windows\n", promise.values, windows);
    fmt::print("  without record    {}, at most {:.0f}: {}\n", microseconds(bare),
               1e6 * promise.without_record, verdict(bare.median <= promise.without_record));
    fmt::print("  with record       {}, adds {:.1f}", microseconds(recorded), 1e6 * adds);
    if (promise.record_adds > 0) {
      fmt::print(", at most {:.0f}: {}", 1e6 * promise.record_adds,
                 verdict(adds <= promise.record_adds));
    }
    fmt::print("\n  no stability watch{}\n", microseconds(unwatched));
    fmt::print("  bare pipe         {}, the window is {:.2f} times as long\n", microseconds(pipe),
               bare.median / pipe.median);
    fmt::print("  all on one of the processors, where nobody has to be woken on another:\n");
    fmt::print("  without record    {}, at most {:.0f}: {}\n", microseconds(together),
               1e6 * promise.without_record, verdict(together.median <= promise.without_record));
    fmt::print("  bare pipe         {}, the window is {:.2f} times as long\n",
               microseconds(pipe_together), together.median / pipe_together.median);
    std::fflush(stdout);
  }
}

void show_record(const std::string& folder, std::int64_t divisor) {
  constexpr std::int64_t values = 100'000;
  const bench::WriteRates rates = bench::write_rates(folder, values, 400 / divisor);
  fmt::print(
      "\nRecord, rows of two fields of {} doubles, best of three: {:.2f} GB/s, at least {:.0f}: "
      "{}\n  plain writing of the same bytes: {:.2f} GB/s\n",
      values, 1e-9 * rates.record, 1e-9 * kRecordRate, verdict(rates.record >= kRecordRate),
      1e-9 * rates.plain);
}

void show_sphere(const run::Home& home, const std::string& folder, std::int64_t divisor) {
  fmt::print("\nThe settling sphere, YADE and FreeFEM: per window\n");
  const bench::SphereTimes resident = bench::sphere(home, folder, false, 4000 / divisor);
  fmt::print("  resident      {:12.1f} us [{:.1f} to {:.1f}]\n", 1e6 * resident.window.median,
             1e6 * resident.window.low, 1e6 * resident.window.high);
  std::fflush(stdout);
  const auto slower = [&](const char* name, const bench::Spread& spread) {
    const double times = spread.median / resident.window.median;
    fmt::print("  {:14}{:12.0f} us [{:.0f} to {:.0f}], {:.0f} times resident", name,
               1e6 * spread.median, 1e6 * spread.low, 1e6 * spread.high, times);
    return times;
  };
  slower("fresh", bench::sphere(home, folder, true, 6 / divisor + 2).window);
  fmt::print("\n");
  std::fflush(stdout);
  const double times =
      slower("ICY's scheme", bench::polled_sphere(home, folder, 6 / divisor + 2, kInterval));
  fmt::print(", at least {:.0f}: {}\n", kAgainstIcy, verdict(times >= kAgainstIcy));
  fmt::print("  start to the end of the first window: {:.2f} s\n", resident.start);
}

void show_pruning(const run::Home& home, const std::string& folder, std::int64_t divisor) {
  const std::int64_t windows = 1000 / divisor;
  fmt::print("\nLeaving out what the settling sphere does not need: us per window\n");
  const auto all = bench::sphere_with_put_back(home, folder, windows);
  fmt::print("  all left out  {}\n", microseconds(all[0].window));
  for (std::size_t i = 1; i < all.size(); ++i) {
    fmt::print("  put back      {}, {:.2f} times as long ({} windows): {}\n",
               microseconds(all[i].window), all[i].window.median / all[0].window.median,
               all[i].window.samples, all[i].name);
  }
}

void show_commands(const run::Home& home, const std::string& folder) {
  fmt::print("\nresume of the sphere, from the command to the first new window: {:.2f} s\n",
             bench::resume_seconds(home, folder));
  const double idle = bench::idle_study_seconds(home, folder);
  fmt::print("study with nothing left to do: {:.3f} s, at most {}: {}\n", idle, kIdleStudy,
             verdict(idle <= kIdleStudy));
}

void show_impact(const run::Home& home, const std::string& folder, std::int64_t divisor) {
  const std::int64_t windows = kImpactWindows / divisor;
  fmt::print("\nThe impact on a beam, YADE and FreeFEM, {} windows of 50 ns{}\n", windows,
             divisor > 1 ? fmt::format(", times as for {}", kImpactWindows) : "");
  double fem_window = 0;
  for (const auto& [continuum, name, most] : kImpacts) {
    const bench::ImpactTimes one = bench::impact(home, folder, continuum, windows);
    // The start is not repeated.
    const double all = one.all + static_cast<double>(divisor - 1) * one.windows;
    fmt::print("  {:16}{:8.1f} s, at most {:.0f}: {}\n", name, all, most, verdict(all <= most));
    fmt::print(
        "    orchestrator  {:8.1f} us of processor time per window, at most {:.0f}: {}\n"
        "    no solver at work {:4.1f} us per window: this, and the system waking up programs\n",
        1e6 * one.processor, 1e6 * kImpactOverhead, verdict(one.processor <= kImpactOverhead),
        1e6 * one.overhead);
    if (fem_window == 0) fem_window = one.windows / static_cast<double>(windows - 1);
    std::fflush(stdout);
  }
  const double alone = bench::impact_alone(home, folder, windows) / static_cast<double>(windows);
  fmt::print(
      "  sphere and finite elements in one FreeFEM {:.0f} us per window, coupled {:.0f}: "
      "{:.2f} times as long\n",
      1e6 * alone, 1e6 * fem_window, fem_window / alone);
}

void show_mapping() {
  constexpr std::int64_t points = 1'000'000;
  fmt::print("\nMapping from 180 000 triangles to {} points\n", points);
  for (const bool linear : {false, true}) {
    const bench::MappingTimes times = bench::mapping(points, linear);
    fmt::print("  {:8} made in {:.2f} s, applied to vectors in {:.3f} s, together at most {}: {}\n",
               linear ? "linear" : "nearest", times.made, times.applied, kMapped,
               verdict(times.made + times.applied <= kMapped));
  }
}

ExitCode execute(const Options& options) {
  Interrupt::install();
  const run::Home home = run::Home::find();
  const Scratch scratch(options.folder.empty()
                            ? std::filesystem::temp_directory_path().string()
                            : std::filesystem::absolute(options.folder).string());
  const std::int64_t divisor = options.short_one ? 10 : 1;
  show_machine(std::filesystem::path(scratch.path()).parent_path().string());
  if (options.wants("exchange")) show_exchange(home, scratch.path(), divisor);
  if (options.wants("record")) show_record(scratch.path(), divisor);
  if (options.wants("sphere")) show_sphere(home, scratch.path(), divisor);
  if (options.wants("impacts")) show_impact(home, scratch.path(), divisor);
  if (options.wants("mapping")) show_mapping();
  if (options.wants("pruning")) show_pruning(home, scratch.path(), divisor);
  if (options.wants("commands")) show_commands(home, scratch.path());
  fmt::print("\nload {} at the end\n", load());
  return ExitCode::done;
}

}  // namespace

void add_bench(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = add_verb(app, "bench", "measure what the orchestrator itself costs",
                            "  sandglass bench\n"
                            "  sandglass bench exchange record\n"
                            "  sandglass bench --short --folder /dev/shm");
  verb->add_option("part", options->parts,
                   "exchange, record, sphere, impacts, mapping, pruning, commands (default: all)")
      ->type_name("PART")
      ->check(CLI::IsMember(
          {"exchange", "record", "sphere", "impacts", "mapping", "pruning", "commands"}));
  verb->add_option("--folder", options->folder,
                   "the disk to measure with (default: the folder of temporary files)")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  verb->add_flag("--short", options->short_one, "a tenth of the windows: to see that it works");
  verb->callback([&session, options] { session.action = [options] { return execute(*options); }; });
}

}  // namespace sandglass::cli
