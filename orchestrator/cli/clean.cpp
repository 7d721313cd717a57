#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "cli/cli.hpp"
#include "record/run_directory.hpp"
#include "run/home.hpp"
#include "study/directory.hpp"

namespace sandglass::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> runs;
  bool all_runs = false;
  bool build = false;
};

/// Removes a folder only when it is what a run has left, and no process works in it.
void remove_run(const fs::path& run) {
  const bool is_run = fs::exists(run / "status.json") || study::is_study(run.string());
  if (!is_run || !fs::exists(run / "lock")) {
    throw Error::usage(fmt::format("'{}' is no run directory and no study", run.string()));
  }
  if (record::in_use(run.string())) {
    fmt::print("kept     {}: in use\n", run.string());
    return;
  }
  fs::remove_all(run);
  fmt::print("removed  {}\n", run.string());
}

ExitCode execute(const Options& options) {
  if (options.runs.empty() && !options.all_runs && !options.build) {
    throw Error::usage("nothing was named to be removed",
                       "name run directories, or use --runs or --build");
  }
  for (const std::string& run : options.runs) remove_run(run);
  if (options.all_runs && fs::is_directory("runs")) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator("runs")) {
      const bool study = study::is_study(entry.path().string());
      if (study || fs::exists(entry.path() / "status.json")) found.push_back(entry.path());
    }
    for (const fs::path& run : found) remove_run(run);
  }
  if (options.build) {
    const std::string build = run::Home::find().root + "/.build";
    fs::remove_all(build);
    fmt::print("removed  {}\n", build);
  }
  return ExitCode::done;
}

}  // namespace

void add_clean(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      add_verb(app, "clean", "remove run directories, or what was built",
               "  sandglass clean runs/icy_stokes_sphere-0001 runs/icy_stokes_stability\n"
               "  sandglass clean --runs\n"
               "  sandglass clean --build");
  verb->add_option("run", options->runs, "run directories and studies to remove")->type_name("RUN");
  verb->add_flag("--runs", options->all_runs, "all run directories and studies below runs/");
  verb->add_flag("--build", options->build, "everything that was built");
  verb->callback([&session, options] { session.action = [options] { return execute(*options); }; });
}

}  // namespace sandglass::cli
