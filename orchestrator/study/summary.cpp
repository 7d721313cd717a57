#include "study/summary.hpp"

#include <fmt/format.h>

#include <utility>

namespace sandglass::study {
namespace {

Value::List texts(const std::vector<std::string>& all) { return {all.begin(), all.end()}; }

workflow::Stage diagram(const workflow::WorkPrecision& wanted) {
  workflow::Stage stage;
  stage.name = "precision_of_" + wanted.error;
  stage.program = workflow::Program::python;
  stage.template_path = "analysis/work_precision.py";
  stage.analysis = true;
  constexpr double deadline = 600;  // s, as of any stage
  stage.deadline = deadline;
  const auto give = [&](const char* name, Value value) {
    stage.given[name].value = std::move(value);
  };
  give("error", wanted.error);
  give("reference_values",
       wanted.reference_value ? Value::List{*wanted.reference_value} : Value::List{});
  give("reference_quantity", wanted.reference_quantity);
  give("sets", texts(wanted.points));
  give("method", texts(wanted.method));
  give("seconds", texts(wanted.seconds));
  return stage;
}

}  // namespace

workflow::Workflow summary_of(const workflow::Workflow& study) {
  workflow::Workflow summary = study;
  if (study.study->of.empty()) {
    summary.stages.clear();
    summary.stages_left_out.clear();
    summary.participants.clear();
    summary.coupling.reset();
    summary.comparisons.clear();
    summary.left_out.clear();
  }
  for (const workflow::WorkPrecision& wanted : study.study->work_precision) {
    summary.stages.push_back(diagram(wanted));
  }
  return summary;
}

}  // namespace sandglass::study
