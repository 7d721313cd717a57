#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"
#include "record/run_directory.hpp"
#include "report/result.hpp"
#include "run/status_file.hpp"

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

ExitCode show(std::vector<std::string> runs) {
  if (runs.empty() && fs::is_directory("runs")) {
    for (const auto& entry : fs::directory_iterator("runs")) {
      if (fs::exists(entry.path() / "status.json")) runs.push_back(entry.path().string());
    }
    std::sort(runs.begin(), runs.end());
  }
  if (runs.empty()) fmt::print("no runs here\n");
  for (const std::string& run : runs) {
    if (!fs::exists(run + "/status.json")) {
      throw Error::environment(fmt::format("'{}' is not a run directory", run));
    }
    fmt::print("{}  {}\n", run, status_text(run));
  }
  return ExitCode::done;
}

}  // namespace

void add_status(CLI::App& app, Session& session) {
  auto runs = std::make_shared<std::vector<std::string>>();
  CLI::App* verb = add_verb(app, "status", "show how runs stand, running or ended",
                            "  sandglass status\n"
                            "  sandglass status runs/icy_stokes_sphere-0001");
  verb->add_option("run", *runs, "run directories (default: all below runs/)")->type_name("RUN");
  verb->callback([&session, runs] { session.action = [runs] { return show(*runs); }; });
}

}  // namespace sandglass::cli
