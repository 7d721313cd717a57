#include <memory>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"
#include "run/run.hpp"

namespace sandglass::cli {

void add_analyse(CLI::App& app, Session& session) {
  struct Given {
    std::string run;
    run::Options options;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = add_verb(app, "analyse",
                            "analyse and report what a run has recorded so far; it may be going on",
                            "  sandglass analyse runs/icy_erosion-0001 --out looks/icy_erosion");
  verb->add_option("run", given->run, "the run directory, which is only read")
      ->required()
      ->type_name("RUN");
  verb->add_option("--out", given->options.out,
                   "where to put it (default: runs/NAME-analysed-0001 and so on)")
      ->type_name("DIRECTORY");
  verb->callback([&session, given] {
    session.action = [&session, given] {
      given->options.command = session.command;
      run::Ended ended;
      {
        TerminalStatus status;
        ended = run::analyse(given->run, run::Home::find(), given->options, status);
      }
      return show_ended(ended);
    };
  });
}

}  // namespace sandglass::cli
