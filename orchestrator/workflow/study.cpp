#include "workflow/study.hpp"

#include <algorithm>
#include <filesystem>

#include "workflow/values.hpp"

namespace sandglass::workflow {
namespace {

std::vector<Setting> read_settings(const Node* node, const Scope& scope) {
  std::vector<Setting> settings;
  if (!node || node->kind != Node::Kind::map) return settings;
  for (size_t i = 0; i < node->keys.size(); ++i) {
    if (node->items[i].kind != Node::Kind::scalar) continue;
    settings.push_back({node->keys[i].text, node->items[i].text, scope.at(node->items[i])});
  }
  return settings;
}

std::vector<std::vector<Setting>> read_sweep(const Node* node, const Scope& scope) {
  std::vector<std::vector<Setting>> axes;
  if (!node || node->kind != Node::Kind::map) return axes;
  for (size_t i = 0; i < node->keys.size(); ++i) {
    std::vector<Setting> axis;
    for (const Node& item : node->items[i].items) {
      axis.push_back({node->keys[i].text, item.text, scope.at(item)});
    }
    if (!axis.empty()) axes.push_back(std::move(axis));
  }
  return axes;
}

/// A parameter has one value in a point: the same name in `set`, `list`, `grid` or `seeds` is an
/// error.
void check_names(const Context& context, const StudyPoints& points) {
  std::vector<std::string> seen;
  const auto once = [&](const Setting& setting) {
    if (std::find(seen.begin(), seen.end(), setting.name) == seen.end()) {
      seen.push_back(setting.name);
      return;
    }
    context.problems.add(setting.place, "parameter '" + setting.name + "' is set twice here",
                         "name it in one of 'set', 'list', 'grid' and 'seeds'");
  };
  for (const Setting& setting : points.set) once(setting);
  for (const auto& axis : points.grid) once(axis.front());
  for (const auto& axis : points.seeds) once(axis.front());
  const std::vector<std::string> before = seen;
  for (const auto& item : points.list) {
    seen = before;
    for (const Setting& setting : item) once(setting);
  }
}

StudyPoints read_points(const Context& context, const Node& node) {
  const Section section(node, object("points"), context.scope);
  StudyPoints points;
  points.name = section.text("name");
  points.place = context.scope.at(node);
  points.set = read_settings(node.find("set"), context.scope);
  points.grid = read_sweep(node.find("grid"), context.scope);
  points.seeds = read_sweep(node.find("seeds"), context.scope);
  if (const Node* list = node.find("list"); list && list->kind == Node::Kind::list) {
    for (const Node& item : list->items) {
      points.list.push_back(read_settings(&item, context.scope));
    }
  }
  points.repeat = std::max<std::int64_t>(1, section.count("repeat", 1));
  points.unstable = section.text("expect") == "unstable";
  check_names(context, points);
  return points;
}

WorkPrecision read_work_precision(const Context& context, const Node& node) {
  const Section section(node, object("work_precision"), context.scope);
  WorkPrecision result;
  result.error = section.text("error");
  result.points = section.texts("points");
  result.method = section.texts("method");
  result.seconds = section.texts("seconds");
  const Node* reference = section.find("reference");
  if (!reference || reference->kind != Node::Kind::map) return result;
  const Section part(*reference, object("reference"), context.scope);
  const Node* value = part.find("value");
  result.reference_quantity = part.text("quantity");
  if (value && result.reference_quantity.empty()) {
    if (const auto number = context.scope.silent().measured(*value)) {
      result.reference_value = number->si;
    }
  }
  if (part.find("curve") || part.find("data") || (value && part.find("quantity")) ||
      (!value && !part.find("quantity"))) {
    context.problems.add(context.scope.at(*reference), "a reference of an error that is a number",
                         "exactly one of value, quantity");
  }
  return result;
}

/// The newest diagram: another error than the others', and sets of points that there are.
void check_diagram(const Context& context, const Node& node, const Study& study) {
  const WorkPrecision& newest = study.work_precision.back();
  const auto same = [&](const WorkPrecision& other) {
    return &other != &newest && other.error == newest.error;
  };
  if (std::any_of(study.work_precision.begin(), study.work_precision.end(), same)) {
    context.problems.add(context.scope.at(node), "a second diagram of '" + newest.error + "'",
                         "the error names a diagram: define another quantity");
  }
  std::vector<std::string> names;
  for (const StudyPoints& points : study.points) names.push_back(points.name);
  const Node* wanted = node.find("points");
  for (size_t i = 0; wanted && i < wanted->items.size(); ++i) {
    const Node& name = wanted->items[i];
    if (name.kind != Node::Kind::scalar) continue;
    if (std::find(names.begin(), names.end(), name.text) != names.end()) continue;
    context.problems.unknown(context.scope.at(name), "there is no set of points", name.text, names);
  }
}

/// The swept workflow, looked for beside this one.
std::string beside(const std::string& file, const std::string& other) {
  return (std::filesystem::path(file).parent_path() / other).lexically_normal().string();
}

}  // namespace

void read_study(const Context& context, Workflow& workflow) {
  const Node* node = context.root.find("study");
  const bool is_study = node && node->kind == Node::Kind::map;
  const bool of_another = is_study && node->find("of");
  if (!of_another && !context.root.find("stages")) {
    context.problems.add({context.file, 1, 1}, "a workflow needs 'stages'",
                         "add it, such as stages: {couple: {run: coupling}}");
  }
  if (!is_study) return;
  const Section section(*node, object("study"), context.scope);
  Study study;
  study.place = context.scope.at(*node);
  if (of_another) study.of = beside(context.file, section.text("of"));
  study.set = read_settings(node->find("set"), context.scope);
  study.judge = !section.find("judge") || section.toggle("judge");
  if (const Node* points = node->find("points"); points && points->kind == Node::Kind::list) {
    for (const Node& item : points->items) {
      if (item.kind == Node::Kind::map) study.points.push_back(read_points(context, item));
    }
  }
  if (of_another && context.root.find("coupling")) {
    context.problems.add(context.scope.at(*context.root.find("coupling")),
                         "a study of another workflow has no coupling of its own",
                         "its stages look at the results of the points; remove 'coupling' or 'of'");
  }
  if (const Node* diagrams = node->find("work_precision");
      diagrams && diagrams->kind == Node::Kind::list) {
    for (const Node& item : diagrams->items) {
      if (item.kind != Node::Kind::map) continue;
      study.work_precision.push_back(read_work_precision(context, item));
      check_diagram(context, item, study);
    }
  }
  workflow.study = std::move(study);
}

}  // namespace sandglass::workflow
