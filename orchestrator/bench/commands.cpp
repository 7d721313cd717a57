// Measured from outside, as the user has it: the running program called again.
#include <fmt/format.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "bench/bench.hpp"
#include "hdf5/hdf5.hpp"
#include "process/child.hpp"
#include "process/process.hpp"

namespace sandglass::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kDeadline = 600;     // s
constexpr std::int64_t kEvery = 100;  // windows between two checkpoints

Command this_program(const run::Home& home, const std::string& log,
                     const std::vector<std::string>& arguments) {
  Command command;
  command.arguments = {fs::read_symlink("/proc/self/exe").string()};
  command.arguments.insert(command.arguments.end(), arguments.begin(), arguments.end());
  command.environment["SANDGLASS_HOME"] = home.root;
  command.log = log;
  return command;
}

/// Looks until `done`, while the program runs.
template <typename Done>
void wait_until(Child& child, Done done) {
  const SystemClock clock;
  const double end = clock.now() + kDeadline;
  while (!done()) {
    if (child.poll_exit() || clock.now() > end) {
      throw Error::participant(fmt::format("{} did not come as far as it should", child.name()), {},
                               end_of_log(child.log()));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

/// Another one when the file was replaced.
ino_t number_of_file(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

std::int64_t windows_in(const std::string& record) {
  try {
    return hdf5::File(record, hdf5::File::Mode::read).read_counts("/windows").at(0);
  } catch (const Error&) {
    return 0;  // not there yet
  }
}

}  // namespace

double resume_seconds(const run::Home& home, const std::string& folder) {
  const std::string run = folder + "/resumed";
  const std::string record = run + "/record.h5";
  {
    Child child("the run",
                this_program(home, folder + "/run.log",
                             {"run", home.root + "/workflows/icy_stokes_sphere.yaml", "--set",
                              "end_time=1000 s", "--set",
                              fmt::format("checkpoint_every={}", kEvery), "--out", run}),
                false);
    wait_until(child, [&] { return windows_in(record) > 5 * kEvery / 2; });
    child.kill();
  }
  // The windows until the newest checkpoint are taken over into a new file, which then grows.
  const std::int64_t kept = windows_in(record) / kEvery * kEvery;
  const auto before = number_of_file(record);
  const SystemClock clock;
  const double start = clock.now();
  Child child("resume", this_program(home, folder + "/resume.log", {"resume", run}), false);
  wait_until(child, [&] { return number_of_file(record) != before && windows_in(record) > kept; });
  const double seconds = clock.now() - start;
  child.kill();
  return seconds;
}

double idle_study_seconds(const run::Home& home, const std::string& folder) {
  const Command study = this_program(home, folder + "/study.log",
                                     {"study", home.templates() + "/bench/pair_study.yaml", "--out",
                                      folder + "/study", "--jobs", "1"});
  run_to_end("the study", study, kDeadline);
  const SystemClock clock;
  const double start = clock.now();
  run_to_end("the study again", study, kDeadline);
  return clock.now() - start;
}

}  // namespace sandglass::bench
