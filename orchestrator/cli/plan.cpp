#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "cli/cli.hpp"
#include "cli/terminal.hpp"
#include "run/savings.hpp"
#include "run/solvers.hpp"
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
    fmt::print("  stage {}: where it was made of the same before, that is taken\n", stage.name);
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

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  auto options = std::make_shared<WorkflowOptions>();
  CLI::App* verb =
      add_verb(app, "plan", "show what would be run, sent and written, and what is left out",
               "  sandglass plan workflows/icy_stokes_sphere.yaml --set fluid=box");
  options->add_to(*verb);
  verb->callback([&session, options] {
    session.action = [options] {
      const workflow::Workflow workflow = options->load();
      show_stages(workflow);
      if (workflow.coupling) show_coupling(workflow);
      show_left_out(workflow);
      return ExitCode::done;
    };
  });
}

}  // namespace sandglass::cli
