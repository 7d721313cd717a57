#include "report/profile.hpp"

#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"

namespace sandglass::cli {
namespace {

struct Options {
  std::string run;
  std::string trace;
};

ExitCode execute(const Options& options) {
  const report::Profile profile = report::read_profile(options.run);
  const std::string trace = options.trace.empty() ? "trace.json" : options.trace;
  report::write_trace(options.run, trace);
  const double all = profile.loop_seconds;
  fmt::print("{} windows, {} in all, {} per window\n", profile.windows, time_text(all),
             time_text(profile.windows > 0 ? all / static_cast<double>(profile.windows) : 0));
  for (const report::Profile::Row& row : profile.rows) {
    if (!row.aside) {
      fmt::print("  {:16} {:>12}  {:5.1f} %\n", row.name, time_text(row.seconds),
                 all > 0 ? 100 * row.seconds / all : 0);
    }
  }
  fmt::print("beside the windows\n");
  for (const report::Profile::Row& row : profile.rows) {
    if (row.aside) fmt::print("  {:16} {:>12}\n", row.name, time_text(row.seconds));
  }
  fmt::print("trace  {} (open it in ui.perfetto.dev or chrome://tracing)\n", trace);
  return ExitCode::done;
}

}  // namespace

void add_profile(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = add_verb(app, "profile", "show where the time of a run went",
                            "  sandglass profile runs/icy_stokes_sphere-0001\n"
                            "  sandglass profile runs/icy_stokes_sphere-0001 --trace sphere.json");
  verb->add_option("run", options->run, "the run directory")->required()->type_name("RUN");
  verb->add_option("--trace", options->trace, "the trace to write (default: trace.json here)")
      ->type_name("FILE");
  verb->callback([&session, options] { session.action = [options] { return execute(*options); }; });
}

}  // namespace sandglass::cli
