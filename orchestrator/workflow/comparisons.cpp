#include "workflow/comparisons.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/unit.hpp"

namespace sandglass::workflow {
namespace {

Metric metric_of(const std::string& name) {
  static const std::map<std::string, Metric> metrics = {
      {"absolute difference", Metric::absolute_difference},
      {"relative difference", Metric::relative_difference},
      {"maximum difference", Metric::maximum_difference},
      {"root mean square difference", Metric::root_mean_square}};
  const auto found = metrics.find(name);
  return found == metrics.end() ? Metric::value : found->second;
}

/// One comparison while it is read: where it stands, and what is said about it.
class Reader {
 public:
  Reader(const Context& context, const Node& node)
      : context_(context), section_(node, object("comparison"), context.scope), node_(node) {}

  Comparison read() {
    result_.name = section_.text("name");
    result_.quantity = section_.text("quantity");
    result_.curve = section_.text("curve");
    result_.because = section_.text("because");
    result_.metric = metric_of(section_.text("metric"));
    result_.place = context_.scope.at(node_);
    read_subject();
    read_reference();
    read_units();
    read_holds_for();
    return result_;
  }

 private:
  void report(const Place& place, std::string what, std::string remedy) const {
    context_.problems.add(place, std::move(what), std::move(remedy));
  }

  void read_subject() {
    if (section_.find("quantity") && section_.find("curve")) {
      report(section_.place("curve"), "both 'quantity' and 'curve'", "compare one of them");
    } else if (!section_.find("quantity") && !section_.find("curve")) {
      report(result_.place, "neither 'quantity' nor 'curve'", "say what is compared");
    }
    if (!section_.find("metric")) return;
    const bool of_curve =
        result_.metric == Metric::maximum_difference || result_.metric == Metric::root_mean_square;
    const bool is_curve = section_.find("curve") && !section_.find("quantity");
    if (of_curve != is_curve && (section_.find("curve") || section_.find("quantity"))) {
      report(section_.place("metric"),
             is_curve ? "this metric does not fit a curve" : "this metric needs a curve",
             is_curve ? "valid: maximum difference, root mean square difference"
                      : "valid: value, absolute difference, relative difference");
    }
  }

  void read_reference() {
    const Node* node = section_.find("reference");
    if (!node || node->kind != Node::Kind::map) {
      if (!section_.find("reference") && section_.find("metric") &&
          result_.metric != Metric::value) {
        report(result_.place, "this metric needs a 'reference'",
               "such as reference: {quantity: stokes_velocity}");
      }
      return;
    }
    if (result_.metric == Metric::value && section_.find("metric")) {
      report(context_.scope.at(*node), "the metric 'value' has no reference",
             "remove it, or compare the difference");
    }
    const Section reference(*node, object("reference"), context_.scope);
    std::vector<std::string> kinds;
    for (const char* key : {"value", "quantity", "curve", "data"}) {
      if (reference.find(key)) kinds.emplace_back(key);
    }
    if (kinds.size() != 1) {
      report(context_.scope.at(*node),
             kinds.empty() ? "a reference without a value"
                           : fmt::format("a reference with {}", fmt::join(kinds, " and ")),
             "exactly one of value, quantity, curve, data");
      return;
    }
    result_.reference_quantity = reference.text("quantity");
    result_.reference_curve = reference.text("curve");
    result_.reference_file = reference.text("data");
    result_.source = reference.text("source");
    const std::string& kind = kinds.front();
    const bool published = kind == "value" || kind == "data";
    if (published && !reference.find("source")) {
      report(context_.scope.at(*node), "a published reference needs its 'source'",
             "say where it was published, such as source: Pirnia et al. (2019), section 3.4");
    }
    const bool single = kind == "value" || kind == "quantity";
    if (single ? !result_.curve.empty() : !result_.quantity.empty()) {
      report(reference.place(kind),
             fmt::format("a {} cannot be compared with '{}'", single ? "curve" : "quantity", kind),
             single ? "valid: curve, data" : "valid: value, quantity");
    }
    if (kind == "value") read_value(*reference.find("value"));
    if (kind == "data") check_data(reference);
  }

  void read_value(const Node& node) {
    const auto value = context_.scope.silent().measured(node);
    if (!value) return;
    result_.reference_value = value->si;
    if (!value->bare) reference_unit_ = value->unit;
    reference_place_ = context_.scope.at(node);
  }

  void check_data(const Section& reference) {
    const std::string& file = result_.reference_file;
    const std::string& root = context_.options.data_root;
    if (is_inner_path(file) && is_file_below(root, file)) return;
    const std::string near = nearest(file, files_below(root));
    report(reference.place("data"), fmt::format("there is no data file {}", in_quotes(file)),
           near.empty() ? "data files are files below data/"
                        : fmt::format("did you mean '{}'?", near));
  }

  void fit(const std::string& unit, const std::string& wanted, const Place& place) const {
    if (unit.empty() || !Unit::valid(unit) || !Unit::valid(wanted)) return;
    if (Unit::convertible(unit, wanted)) return;
    report(place,
           fmt::format("unit '{}' does not fit {}", unit, wanted == "1" ? "a ratio" : wanted),
           wanted == "1" ? "write a bare number, or one in %" : "use one unit throughout");
  }

  void require_no_offset(const std::string& unit, const Place& place) const {
    if (!Unit::has_offset(unit)) return;
    report(place, fmt::format("a comparison in {}, whose 0 is not 0 in SI", unit),
           "differences and limits need a unit that begins at 0, such as K");
  }

  void read_units() {
    std::string tolerance_unit;
    if (const Node* tolerance = section_.find("tolerance")) {
      if (const auto value = context_.scope.silent().measured(*tolerance)) {
        result_.tolerance = value->si;
        tolerance_unit = value->unit;
      }
    }
    const bool relative = result_.metric == Metric::relative_difference;
    result_.unit = section_.text("unit");
    if (result_.unit.empty() && !Unit::has_offset(reference_unit_)) result_.unit = reference_unit_;
    if (result_.unit.empty() && !relative) result_.unit = tolerance_unit;
    if (result_.unit.empty()) result_.unit = "1";
    fit(reference_unit_, result_.unit, reference_place_);
    fit(tolerance_unit, relative ? "1" : result_.unit, section_.place("tolerance"));
    require_no_offset(tolerance_unit, section_.place("tolerance"));
    require_no_offset(section_.text("unit"), section_.place("unit"));
  }

  void read_holds_for() {
    const Node* node = section_.find("holds_for");
    if (!node || node->kind != Node::Kind::map) return;
    const Scope silent = context_.scope.silent();
    for (size_t i = 0; i < node->keys.size(); ++i) {
      const Parameter* parameter = silent.parameter(node->keys[i].text);
      if (!parameter) continue;
      const Node& wanted = node->items[i];
      HoldsFor condition{parameter->name, {}, {}, true};
      Node single;
      single.kind = Node::Kind::map;
      single.keys = {node->keys[i]};
      single.items = {wanted};
      condition.met = silent.holds(single);
      std::vector<std::string> texts;
      Value::List values;
      const std::vector<Node> one{wanted.kind == Node::Kind::list ? Node{} : wanted};
      for (const Node& item : wanted.kind == Node::Kind::list ? wanted.items : one) {
        const Reading reading = read_as(item.text, *parameter);
        if (!reading.value) continue;
        values.push_back(*reading.value);
        texts.push_back(item.text);
      }
      if (values.empty()) continue;
      condition.value = values.size() == 1 ? values.front() : Value(values);
      condition.text = fmt::format("{}", fmt::join(texts, " or "));
      result_.holds_for.push_back(std::move(condition));
    }
  }

  const Context& context_;
  Section section_;
  const Node& node_;
  Comparison result_;
  std::string reference_unit_;
  Place reference_place_;
};

}  // namespace

void read_comparisons(const Context& context, Workflow& workflow) {
  const Node* list = context.root.find("compare");
  if (!list || list->kind != Node::Kind::list) return;
  std::set<std::string> names;
  for (const Node& item : list->items) {
    if (item.kind != Node::Kind::map) continue;
    Comparison comparison = Reader(context, item).read();
    if (!comparison.name.empty() && !names.insert(comparison.name).second) {
      context.problems.add(context.scope.at(*item.find("name")),
                           fmt::format("a second comparison called {}", in_quotes(comparison.name)),
                           "give it another name");
    }
    if (applies(item, context.scope)) workflow.comparisons.push_back(std::move(comparison));
  }
  const bool analysed = std::any_of(workflow.stages.begin(), workflow.stages.end(),
                                    [](const Stage& stage) { return stage.analysis; });
  const Node* stages = context.root.find("stages");
  if (!analysed && !workflow.comparisons.empty() && stages && context.problems.empty()) {
    context.problems.add(context.scope.at(*list), "no analysis stage computes what is compared",
                         "add a python stage with 'analysis: true'");
  }
}

}  // namespace sandglass::workflow
