#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "report/compare.hpp"
#include "run/home.hpp"
#include "study/study.hpp"

namespace sandglass::cli {
namespace {

/// Throws Error::refused when a point of the study cannot be run as it is set.
void check_points(const WorkflowOptions& options) {
  study::Options study;
  study.file = options.file;
  study.load = options.load_options();
  fmt::print("{}: all {} points are well\n", options.file,
             study::plan(study, run::Home::find()).points);
}

}  // namespace

void add_check(CLI::App& app, Session& session) {
  auto options = std::make_shared<WorkflowOptions>();
  CLI::App* verb = add_verb(app, "check", "check a workflow and its templates; start nothing",
                            "  sandglass check workflows/icy_stokes_sphere.yaml\n"
                            "  sandglass check my_study.yaml --set viscosity='2 mPa s'");
  options->add_to(*verb);
  verb->callback([&session, options] {
    session.action = [options] {
      workflow::Workflow workflow = options->load_as_written();
      if (!workflow.study || workflow.study->of.empty()) workflow = options->load();
      report::check_references(workflow, run::Home::find().data());
      if (workflow.study) check_points(*options);
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
