#include "run/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/file.hpp"
#include "hdf5/hdf5.hpp"
#include "process/interrupt.hpp"
#include "record/checkpoint.hpp"
#include "record/record.hpp"
#include "run/beginning.hpp"
#include "run/coupled_stage.hpp"

namespace sandglass::run {
namespace {

namespace fs = std::filesystem;

/// A folder beside nothing else in the run directory, gone when this object is.
class Scratch {
 public:
  explicit Scratch(const record::RunDirectory& run) : path_(run.file("replay")) {
    fs::remove_all(path_);
    make_directories(path_);
    fs::create_directory_symlink("../stages", path_ + "/stages");
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// The datasets that must agree: everything but timings.
std::vector<std::string> compared(const hdf5::File& record) {
  std::vector<std::string> names{"/time", "/iterations"};
  for (const char* group : {"/fields", "/counts"}) {
    if (!record.exists(group)) continue;
    for (const std::string& name : record.list(group)) {
      names.push_back(std::string(group) + "/" + name);
    }
  }
  return names;
}

/// All of a dataset as numbers: counts are exact as doubles.
std::vector<double> read(const hdf5::File& file, const std::string& name, std::int64_t rows) {
  if (name != "/iterations" && name.rfind("/counts/", 0) != 0) return file.read_numbers(name, rows);
  const auto counts = file.read_counts(name, rows);
  return {counts.begin(), counts.end()};
}

bool same_bytes(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Compares rows `first` to `last` of the record with the repeated ones, which begin behind
/// window `behind`.
void compare(const std::string& recorded_path, const std::string& repeated_path,
             Replayed& replayed) {
  const hdf5::File recorded(recorded_path, hdf5::File::Mode::read);
  const hdf5::File repeated(repeated_path, hdf5::File::Mode::read);
  replayed.datasets = compared(recorded);
  for (const std::string& name : replayed.datasets) {
    const auto ours = read(recorded, name, replayed.last);
    const auto theirs = read(repeated, name, replayed.last - replayed.behind);
    const auto row = static_cast<std::int64_t>(ours.size()) / replayed.last;
    const std::int64_t shift = replayed.behind * row;
    for (std::int64_t i = (replayed.first - 1) * row; i < replayed.last * row; ++i) {
      const double a = ours.at(static_cast<std::size_t>(i));
      const double b = theirs.at(static_cast<std::size_t>(i - shift));
      if (same_bytes(a, b)) continue;
      replayed.differences.push_back({name, i / row + 1, i % row, a, b});
      break;
    }
  }
}

}  // namespace

Replayed replay(const std::string& run_directory, std::int64_t window, const Home& home,
                Status& status) {
  Interrupt::install();
  const record::RunDirectory run = record::RunDirectory::open(run_directory);
  const Beginning beginning = read_beginning(run.path());
  const workflow::Workflow workflow = load_again(beginning, home, run.path());
  require_unchanged(beginning, workflow, home);
  const std::int64_t windows = workflow.coupling ? record::windows_of(run.file("record.h5")) : 0;
  if (windows == 0)
    throw Error::environment(fmt::format("'{}' has no recorded window", run.path()));
  if (window < 0 || window > windows) {
    throw Error::usage(fmt::format("there is no window {} in the record", window),
                       fmt::format("it holds windows 1 to {}", windows));
  }

  Replayed replayed;
  Span span;
  span.checkpoints = &run;
  span.keeps_record = false;
  span.began = SystemClock().now();
  if (window > 0) span.behind = record::Checkpoints(run).newest(window - 1).value_or(0);
  span.until = window > 0 ? window : windows;
  replayed.behind = span.behind;
  replayed.first = window > 0 ? window : 1;
  replayed.last = span.until;

  const Scratch scratch(run);
  const record::RunDirectory directory = record::RunDirectory::open(scratch.path());
  Scripts scripts(home.templates(), directory.folder("scripts"));
  Progress progress;
  progress.name = fs::path(run.path()).filename().string();
  progress.stage = "replay";
  progress.windows = span.until;
  progress.end = static_cast<double>(span.until) * workflow.coupling->window;
  CoupledOutcome outcome;
  run_coupling(workflow, home, directory, scripts, span, outcome,
               [&](std::int64_t done, double time) {
                 progress.window = done;
                 progress.time = time;
                 status.window(progress);
               });
  compare(run.file("record.h5"), directory.file("record.h5"), replayed);
  return replayed;
}

}  // namespace sandglass::run
