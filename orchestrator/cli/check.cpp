#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "report/compare.hpp"
#include "run/home.hpp"

namespace sandglass::cli {

void add_check(CLI::App& app, Session& session) {
  auto options = std::make_shared<WorkflowOptions>();
  CLI::App* verb = add_verb(app, "check", "check a workflow and its templates; start nothing",
                            "  sandglass check workflows/icy_stokes_sphere.yaml\n"
                            "  sandglass check my_study.yaml --set viscosity='2 mPa s'");
  options->add_to(*verb);
  verb->callback([&session, options] {
    session.action = [options] {
      const workflow::Workflow workflow = options->load();
      report::check_references(workflow, run::Home::find().data());
      fmt::print(
          "{}: all is well; checked {} parameters, {} stages, {} participants and their "
          "templates\n",
          workflow.path, workflow.parameters.size(), workflow.stages.size(),
          workflow.participants.size());
      return ExitCode::done;
    };
  });
}

}  // namespace sandglass::cli
