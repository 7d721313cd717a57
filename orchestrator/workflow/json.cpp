#include "workflow/json.hpp"

#include <nlohmann/json.hpp>

namespace sandglass::workflow {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Value& value) {
  if (const auto* number = value.as<double>()) return *number;
  if (const auto* count = value.as<std::int64_t>()) return *count;
  if (const auto* flag = value.as<bool>()) return *flag;
  if (const auto* text = value.as<std::string>()) return *text;
  if (const auto* choice = value.as<Value::Choice>()) return choice->name;
  if (const auto* list = value.as<Value::List>()) {
    Json result = Json::array();
    for (const Value& item : *list) result.push_back(to_json(item));
    return result;
  }
  return nullptr;
}

Json to_json(const GivenMap& given) {
  Json result = Json::object();
  for (const auto& [name, each] : given) {
    if (each.file) {
      result[name] = {{"stage", each.file->stage}, {"file", each.file->file}};
    } else {
      result[name] = to_json(each.value);
    }
  }
  return result;
}

Json to_json(const Parameter& parameter) {
  return {{"type", type_name(parameter.type)},
          {"value", to_json(parameter.value)},
          {"unit", parameter.unit},
          {"shown", shown(parameter)},
          {"meaning", parameter.meaning},
          {"source", parameter.source},
          {"choices", parameter.choices},
          {"overridden", parameter.overridden}};
}

Json to_json(const Stage& stage) {
  return {{"name", stage.name},
          {"run", name_of(stage.program)},
          {"template", stage.template_path},
          {"command", stage.command},
          {"given", to_json(stage.given)},
          {"makes", stage.makes},
          {"after", stage.after},
          {"reuse", stage.reuse},
          {"analysis", stage.analysis},
          {"deadline_s", stage.deadline}};
}

Json to_json(const Participant& participant) {
  return {{"name", participant.name},
          {"solver", name_of(participant.solver)},
          {"template", participant.template_path},
          {"window_template", participant.window_template_path},
          {"command", participant.command},
          {"given", to_json(participant.given)},
          {"process", participant.lifetime == Lifetime::fresh ? "fresh" : "resident"},
          {"threads", participant.threads},
          {"ranks", participant.ranks},
          {"deadline_s", participant.deadline}};
}

Json to_json(const std::optional<FieldMapping>& mapping) {
  if (!mapping) return nullptr;
  return {{"method", mapping->method == exchange::MappingMethod::nearest ? "nearest" : "linear"},
          {"kind", mapping->conservative ? "conservative" : "consistent"},
          {"from_points", mapping->from_points},
          {"to_points", mapping->to_points},
          {"cells", mapping->cells},
          {"limit_m", mapping->limit}};
}

Json to_json(const Field& field) {
  return {{"name", field.name},
          {"unit", field.unit},
          {"shape", field.shape},
          {"variable", field.variable},
          {"from", field.from},
          {"to", field.to.empty() ? Json(nullptr) : Json(field.to)},
          {"transform", name_of(field.transform)},
          {"mapping", to_json(field.mapping)},
          {"samples", field.samples},
          {"received_shape", field.received_shape},
          {"initial", field.initial},
          {"recorded", field.recorded},
          {"relaxed", field.relaxed},
          {"watched", field.watched}};
}

Json to_json(const Coupling& coupling) {
  Json fields = Json::array();
  for (const Field& field : coupling.fields) fields.push_back(to_json(field));
  return {{"scheme", name_of(coupling.scheme)},
          {"window_s", coupling.window},
          {"end_s", coupling.end},
          {"windows", coupling.windows},
          {"order", coupling.order},
          {"exchange", coupling.transport == Transport::file ? "file" : "mapped"},
          {"acceleration", name_of(coupling.acceleration)},
          {"reused_windows", coupling.reused_windows},
          {"filter", coupling.filter},
          {"relaxation", coupling.relaxation},
          {"tolerance", coupling.tolerance},
          {"iterations", coupling.iterations},
          {"stability",
           {{"watch", coupling.stability.active},
            {"growth", coupling.stability.growth},
            {"monotone_growth", coupling.stability.monotone_growth},
            {"energy", coupling.energy.fields},
            {"energy_growth", coupling.energy.growth}}},
          {"rest",
           {{"field", coupling.rest.field},
            {"at_most", coupling.rest.at_most},
            {"windows", coupling.rest.windows}}},
          {"checkpoint_every", coupling.checkpoint_every},
          {"checkpoints_kept", coupling.checkpoints_kept},
          {"fields", fields},
          {"fields_left_out", coupling.fields_left_out}};
}

Json reference_of(const Comparison& comparison) {
  Json result = Json::object();
  if (comparison.reference_value) result["value"] = *comparison.reference_value;
  if (!comparison.reference_quantity.empty()) result["quantity"] = comparison.reference_quantity;
  if (!comparison.reference_curve.empty()) result["curve"] = comparison.reference_curve;
  if (!comparison.reference_file.empty()) result["data"] = comparison.reference_file;
  if (!comparison.source.empty()) result["source"] = comparison.source;
  return result;
}

Json to_json(const Comparison& comparison) {
  Json holds_for = Json::array();
  for (const HoldsFor& condition : comparison.holds_for) {
    holds_for.push_back(
        {{"parameter", condition.parameter}, {"value", condition.text}, {"met", condition.met}});
  }
  const bool curve = !comparison.curve.empty();
  return {{"name", comparison.name},
          {curve ? "curve" : "quantity", curve ? comparison.curve : comparison.quantity},
          {"reference", reference_of(comparison)},
          {"metric", name_of(comparison.metric)},
          {"tolerance", comparison.tolerance},
          {"unit", comparison.unit},
          {"because", comparison.because},
          {"holds_for", holds_for}};
}

Json to_json(const LeftOut& item) {
  return {{"name", item.name},
          {"of", item.of},
          {"also", item.also},
          {"what", item.what},
          {"why", item.why},
          {"active", item.active},
          {"by", item.unchanged_inputs ? "unchanged_inputs" : "switch"}};
}

template <typename List>
Json list_of(const List& items) {
  Json result = Json::array();
  for (const auto& item : items) result.push_back(to_json(item));
  return result;
}

}  // namespace

nlohmann::ordered_json to_json(const Workflow& workflow) {
  Json parameters = Json::object();
  for (const Parameter& each : workflow.parameters) parameters[each.name] = to_json(each);
  return {{"format", 1},
          {"path", workflow.path},
          {"name", workflow.name},
          {"title", workflow.title},
          {"description", workflow.description},
          {"parameters", parameters},
          {"stages", list_of(workflow.stages)},
          {"stages_left_out", workflow.stages_left_out},
          {"participants", list_of(workflow.participants)},
          {"coupling", workflow.coupling ? to_json(*workflow.coupling) : Json(nullptr)},
          {"comparisons", list_of(workflow.comparisons)},
          {"left_out", list_of(workflow.left_out)}};
}

std::string type_name(Parameter::Type type) {
  switch (type) {
    case Parameter::Type::number:
      return "number";
    case Parameter::Type::count:
      return "count";
    case Parameter::Type::toggle:
      return "switch";
    case Parameter::Type::choice:
      return "choice";
    case Parameter::Type::text:
      return "text";
  }
  return {};
}

std::string name_of(Program program) {
  switch (program) {
    case Program::gmsh:
      return "gmsh";
    case Program::python:
      return "python";
    case Program::freefem:
      return "freefem";
    case Program::yade:
      return "yade";
    case Program::lammps:
      return "lammps";
    case Program::command:
      return "command";
    case Program::coupling:
      return "coupling";
  }
  return {};
}

std::string name_of(Solver solver) {
  switch (solver) {
    case Solver::yade:
      return "yade";
    case Solver::freefem:
      return "freefem";
    case Solver::lammps:
      return "lammps";
    case Solver::command:
      return "command";
  }
  return {};
}

std::string name_of(Acceleration acceleration) {
  if (acceleration == Acceleration::constant) return "constant";
  if (acceleration == Acceleration::iqn_ils) return "iqn-ils";
  return acceleration == Acceleration::aitken ? "aitken" : "none";
}

std::string name_of(Scheme scheme) {
  if (scheme == Scheme::parallel_explicit) return "parallel-explicit";
  return scheme == Scheme::serial_implicit ? "serial-implicit" : "serial-explicit";
}

std::string name_of(Transform transform) {
  switch (transform) {
    case Transform::identity:
      return "identity";
    case Transform::mean:
      return "mean";
    case Transform::median:
      return "median";
    case Transform::minimum:
      return "min";
    case Transform::maximum:
      return "max";
    case Transform::sum:
      return "sum";
    case Transform::linear:
      return "linear";
  }
  return {};
}

std::string name_of(Metric metric) {
  switch (metric) {
    case Metric::value:
      return "value";
    case Metric::absolute_difference:
      return "absolute difference";
    case Metric::relative_difference:
      return "relative difference";
    case Metric::maximum_difference:
      return "maximum difference";
    case Metric::root_mean_square:
      return "root mean square difference";
  }
  return {};
}

}  // namespace sandglass::workflow
