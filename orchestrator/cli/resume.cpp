#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"
#include "run/run.hpp"

namespace sandglass::cli {
namespace {

ExitCode execute(const std::string& directory, const std::vector<std::string>& command) {
  run::Options options;
  options.command = command;
  run::Ended ended;
  {
    TerminalStatus status;
    ended = run::resume(directory, run::Home::find(), options, status);
  }
  if (ended.complete_before) fmt::print("nothing to resume: this run came to its end\n");
  if (ended.went_on_behind > 0) fmt::print("went on behind window {}\n", ended.went_on_behind);
  return show_ended(ended);
}

}  // namespace

void add_resume(CLI::App& app, Session& session) {
  auto path = std::make_shared<std::string>();
  CLI::App* verb =
      add_verb(app, "resume", "go on with a run that was killed, interrupted, or failed",
               "  sandglass resume runs/icy_stokes_sphere-0001");
  verb->add_option("run", *path, "the run directory")->required()->type_name("RUN");
  verb->callback([&session, path] {
    session.action = [&session, path] { return execute(*path, session.command); };
  });
}

}  // namespace sandglass::cli
