#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"
#include "run/savings.hpp"
#include "run/solvers.hpp"
#include "study/study.hpp"
#include "workflow/json.hpp"

namespace sandglass::cli {
namespace {

std::string shape_text(const std::vector<std::int64_t>& shape) {
  return fmt::format("[{}]", fmt::join(shape, ", "));
}

void show_stages(const workflow::Workflow& workflow) {
  fmt::print("Stages, in this order\n");
  for (const workflow::Stage& stage : workflow.stages) {
    fmt::print("  {:12} {}{}{}\n", stage.name, run::solver_name(stage.program),
               stage.template_path.empty() ? "" : " " + stage.template_path,
               stage.makes.empty() ? "" : fmt::format(", makes {}", fmt::join(stage.makes, ", ")));
  }
}

void show_coupling(const workflow::Workflow& workflow) {
  const workflow::Coupling& coupling = *workflow.coupling;
  fmt::print("\nCoupling: {}, {} windows of {}, order {}\n", workflow::name_of(coupling.scheme),
             coupling.windows, time_text(coupling.window), fmt::join(coupling.order, ", "));
  if (coupling.rest.windows > 0) {
    fmt::print("  fewer windows when '{}' is at most {} in {} of them, one after the other\n",
               coupling.rest.field, coupling.rest.at_most, coupling.rest.windows);
  }
  for (const workflow::Participant& one : workflow.participants) {
    fmt::print("  {:12} {}, {}, {} thread{}, {}\n", one.name, run::solver_name(one.solver),
               one.lifetime == workflow::Lifetime::fresh ? "fresh in every window" : "resident",
               one.threads, one.threads == 1 ? "" : "s", one.template_path);
  }
  fmt::print("\nFields, per window\n");
  for (const workflow::Field& field : coupling.fields) {
    fmt::print("  {:12} {} {}: {} -> {}{}\n", field.name, shape_text(field.shape), field.unit,
               field.from, field.to.empty() ? "record only" : field.to,
               field.recorded ? ", recorded" : "");
  }
}

void show_left_out(const workflow::Workflow& workflow) {
  fmt::print("\nLeft out\n");
  bool any = false;
  const auto savings = run::measured_savings(workflow, "runs");
  for (const workflow::LeftOut& one : workflow.left_out) {
    const auto measured = savings.find(one.name);
    const std::string saving =
        measured == savings.end() ? run::MeasuredSaving().text() : measured->second.text();
    fmt::print("  {}: {} ({}); {}\n", one.name, one.what, one.why,
               one.active ? saving : "put back by --no-prune");
    any = true;
  }
  for (const workflow::Stage& stage : workflow.stages) {
    if (!stage.reuse) continue;
    const auto measured = savings.find(stage.name);
    fmt::print("  stage {}: where it was made of the same before, that is taken; {}\n", stage.name,
               measured == savings.end() ? run::MeasuredSaving().text() : measured->second.text());
    any = true;
  }
  if (workflow.coupling) {
    for (const std::string& field : workflow.coupling->fields_left_out) {
      fmt::print("  field {}: nobody receives or records it, so it is not sent\n", field);
      any = true;
    }
  }
  for (const std::string& stage : workflow.stages_left_out) {
    fmt::print("  stage {}: its condition is not met\n", stage);
    any = true;
  }
  if (!any) fmt::print("  nothing\n");
}

std::string points(std::size_t count) {
  return fmt::format("{} point{}", count, count == 1 ? "" : "s");
}

/// What a call of `study` would do.
void show_study(const study::Plan& plan) {
  std::size_t good = 0;
  for (const study::Reason& reason : plan.reasons) good += reason.lines.empty() ? 1 : 0;
  fmt::print("Study of {}: {} would be run, {} there already and good", points(plan.points),
             plan.reasons.size() - good, good);
  if (plan.twins > 0) fmt::print(", {} the same as another", plan.twins);
  fmt::print("\n");
  for (const study::Reason& reason : plan.reasons) {
    fmt::print("  {:6} {}{}\n", reason.lines.empty() ? "there" : "run", reason.point,
               reason.lines.empty() ? "" : ": " + reason.lines.front());
  }
  fmt::print("\nLeft out in the points\n");
  for (const study::LeftOut& one : plan.left_out) {
    fmt::print("  {}: {} ({}); in {}, ", one.name, one.what, one.why, points(one.points));
    if (one.measured > 0) {
      fmt::print("saved {:.3g} s in the {} that measured it\n", one.saved, one.measured);
    } else {
      fmt::print("saving unknown: no run of them has measured it\n");
    }
  }
  if (plan.left_out.empty()) fmt::print("  nothing\n");
}

void show_run(const workflow::Workflow& workflow) {
  show_stages(workflow);
  if (workflow.coupling) show_coupling(workflow);
  show_left_out(workflow);
}

ExitCode execute(const WorkflowOptions& options, const std::string& out) {
  const workflow::Workflow file = options.load_as_written();
  // A file may be a study of itself: then `run` and `study` both mean something.
  if (!file.study || file.study->of.empty()) show_run(options.load());
  if (!file.study) return ExitCode::done;
  if (file.study->of.empty()) fmt::print("\n");
  study::Options asked;
  asked.file = options.file;
  asked.load = options.load_options();
  asked.out = out;
  show_study(study::plan(asked, run::Home::find()));
  return ExitCode::done;
}

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  auto options = std::make_shared<WorkflowOptions>();
  CLI::App* verb =
      add_verb(app, "plan", "show what would be run, sent and written, and what is left out",
               "  sandglass plan workflows/icy_stokes_sphere.yaml --set fluid=box\n"
               "  sandglass plan workflows/icy_stokes_stability.yaml");
  options->add_to(*verb);
  auto out = std::make_shared<std::string>();
  verb->add_option("--out", *out, "the folder of a study (default: runs/NAME)")->type_name("DIR");
  verb->callback([&session, options, out] {
    session.action = [options, out] { return execute(*options, *out); };
  });
}

}  // namespace sandglass::cli
