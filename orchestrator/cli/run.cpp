#include "run/run.hpp"

#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"
#include "report/result.hpp"

namespace sandglass::cli {
namespace {

struct Options {
  WorkflowOptions workflow;
  std::string out;
  bool dry = false;
};

ExitCode show_dry_run(const workflow::Workflow& workflow, const run::Home& home) {
  for (const run::RenderedScript& one : run::dry_run(workflow, home)) {
    fmt::print("{:12}  {:48}  {} bytes\n", one.whose, one.template_path, one.bytes);
  }
  fmt::print("{}: all is well; nothing was started\n", workflow.path);
  return ExitCode::done;
}

void show_result(const run::Ended& ended) {
  const report::Result result = report::read_result(ended.directory);
  for (const report::ComparisonResult& one : result.comparisons) {
    if (!one.passed) {
      fmt::print("  skipped  {}: {}\n", one.name, one.skipped);
    } else {
      fmt::print("  {}  {}: {} {:.3g}, tolerance {:.3g}\n", *one.passed ? "within " : "OUTSIDE",
                 one.name, one.metric, one.value.value_or(0.0), one.tolerance);
    }
  }
  fmt::print("{} windows, {} in all\n", result.windows,
             duration_text(result.wall_time_s.value_or(0)));
}

ExitCode execute(const Options& options, const std::vector<std::string>& command) {
  const workflow::Workflow workflow = options.workflow.load();
  if (workflow.study && !workflow.study->of.empty()) {
    throw Error::usage(fmt::format("'{}' is a study of '{}'", workflow.path, workflow.study->of),
                       fmt::format("sandglass study {}", workflow.path));
  }
  const run::Home home = run::Home::find();
  if (options.dry) return show_dry_run(workflow, home);
  run::Options run_options;
  run_options.out = options.out;
  run_options.command = command;
  run::Ended ended;
  {
    TerminalStatus status;
    ended = run::execute(workflow, home, run_options, status);
  }
  return show_ended(ended);
}

}  // namespace

ExitCode show_ended(const run::Ended& ended) {
  if (!ended.error.empty()) tell("sandglass: {}\n", ended.error);
  if (ended.code == ExitCode::done || ended.code == ExitCode::mismatch) show_result(ended);
  fmt::print("result  {}/result.json\n", ended.directory);
  if (!ended.report.empty()) fmt::print("report  {}\n", ended.report);
  return ended.code;
}

void add_run(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = add_verb(
      app, "run", "run a workflow: stages, coupling, comparisons, report",
      "  sandglass run workflows/icy_stokes_sphere.yaml\n"
      "  sandglass run workflows/icy_stokes_sphere.yaml --set density='2500 kg/m3' --out lighter\n"
      "  sandglass run workflows/icy_stokes_sphere.yaml --dry-run");
  options->workflow.add_to(*verb);
  verb->add_option("--out", options->out, "the run directory (default: a new one below runs/)")
      ->type_name("DIR");
  verb->add_flag("--dry-run", options->dry, "check, plan and render without starting a solver");
  verb->callback([&session, options] {
    session.action = [&session, options] { return execute(*options, session.command); };
  });
}

}  // namespace sandglass::cli
