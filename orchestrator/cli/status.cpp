#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"
#include "record/run_directory.hpp"
#include "report/result.hpp"
#include "run/status_file.hpp"
#include "study/directory.hpp"

namespace sandglass::cli {
namespace {

namespace fs = std::filesystem;

std::string status_text(const std::string& run) {
  if (record::in_use(run)) {
    const run::Progress progress = run::read_status(run + "/status.json");
    if (progress.windows == 0) return fmt::format("running, {}", progress.stage);
    return fmt::format("running, {}", progress_text(progress));
  }
  if (fs::exists(run + "/result.json")) {
    const report::Result result = report::read_result(run);
    return fmt::format(
        "{}, {} windows, {}{}", result.status, result.windows,
        duration_text(result.wall_time_s.value_or(0)),
        result.error.empty() ? "" : ": " + result.error.substr(0, result.error.find('\n')));
  }
  const run::Progress progress = run::read_status(run + "/status.json");
  return fmt::format("ended without a result (killed?) in {}, window {} of {}", progress.stage,
                     progress.window, progress.windows);
}

/// How many points are in which state, and the names of those that run or have failed.
void show_study(const std::string& path) {
  const study::StudyDirectory directory(path);
  std::map<std::string, std::size_t> counts;
  std::string lines;
  for (const study::StudyDirectory::Entry& entry : directory.read()) {
    const std::string& run = entry.twin_of.empty() ? entry.point : entry.twin_of;
    const study::Outcome outcome = directory.outcome(run);
    study::Point point;
    point.unstable = entry.unstable;
    std::string state = "done";
    if (outcome.state == study::Outcome::State::running) {
      state = "running";
    } else if (outcome.state == study::Outcome::State::left) {
      state = "left";
    } else if (!outcome.good(point)) {
      state = "failed";
    }
    ++counts[state];
    const bool own = entry.twin_of.empty();
    if (own && (state == "running" || state == "failed")) {
      lines += fmt::format("  {}  {}\n", directory.run_of(run), status_text(directory.run_of(run)));
    }
  }
  std::string text;
  for (const auto& [state, count] : counts) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, state);
  }
  fmt::print("{}  study of points: {}\n{}", path, text.empty() ? "none" : text, lines);
}

ExitCode show(std::vector<std::string> runs) {
  if (runs.empty() && fs::is_directory("runs")) {
    for (const auto& entry : fs::directory_iterator("runs")) {
      const std::string path = entry.path().string();
      if (fs::exists(path + "/status.json") || study::is_study(path)) runs.push_back(path);
    }
    std::sort(runs.begin(), runs.end());
  }
  if (runs.empty()) fmt::print("no runs here\n");
  ExitCode code = ExitCode::done;
  for (const std::string& run : runs) {
    if (study::is_study(run)) {
      show_study(run);
      continue;
    }
    if (!fs::exists(run + "/status.json")) {
      throw Error::environment(fmt::format("'{}' is no run directory and no study", run));
    }
    try {
      fmt::print("{}  {}\n", run, status_text(run));
    } catch (const Error& error) {
      fmt::print("{}  cannot be told: {}\n", run, error.what());
      code = error.code();
    }
  }
  return code;
}

}  // namespace

void add_status(CLI::App& app, Session& session) {
  auto runs = std::make_shared<std::vector<std::string>>();
  CLI::App* verb = add_verb(app, "status", "show how runs and studies stand, and what is left",
                            "  sandglass status\n"
                            "  sandglass status runs/icy_stokes_sphere-0001");
  verb->add_option("run", *runs, "run directories and studies (default: all below runs/)")
      ->type_name("RUN");
  verb->callback([&session, runs] { session.action = [runs] { return show(*runs); }; });
}

}  // namespace sandglass::cli
