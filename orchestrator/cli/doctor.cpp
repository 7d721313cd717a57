#include "run/doctor.hpp"

#include <fmt/format.h>

#include "cli/cli.hpp"

namespace sandglass::cli {

void add_doctor(CLI::App& app, Session& session) {
  CLI::App* verb = add_verb(app, "doctor", "find every solver, run each once, say what is missing",
                            "  sandglass doctor");
  verb->callback([&session] {
    session.action = [] {
      bool all_good = true;
      run::examine(run::Home::find(), [&](const run::Finding& finding) {
        fmt::print("{}  {:9} {:18} {} ({:.1f} s)\n", finding.good ? "good   " : "MISSING",
                   finding.name, finding.version, finding.text, finding.seconds);
        if (finding.good) return;
        fmt::print("         {} needs it; try: {}\n", finding.role, finding.remedy);
        all_good = all_good && finding.optional;
      });
      if (all_good) fmt::print("all is there\n");
      return all_good ? ExitCode::done : ExitCode::environment;
    };
  });
}

}  // namespace sandglass::cli
