#include "workflow/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "base/unit.hpp"
#include "workflow/context.hpp"
#include "workflow/structure.hpp"
#include "workflow/values.hpp"

namespace sandglass::workflow {
namespace {

using Type = Parameter::Type;

const std::vector<Parameter> no_parameters;

Place place_of(const Setting& setting, const std::string& name) {
  if (!setting.place.file.empty()) return setting.place;
  return {fmt::format("command line (--set {})", name), 0, 0};
}

bool allows(const std::string& limit, double value, double bound) {
  if (limit == "minimum") return value >= bound;
  if (limit == "maximum") return value <= bound;
  return limit == "above" ? value > bound : value < bound;
}

/// One parameter while it is read: its declaration, and where to report.
class Declaration {
 public:
  Declaration(const Node& node, const Scope& scope, Parameter& parameter)
      : node_(node),
        section_(node, object("parameter"), scope),
        scope_(scope),
        result_(parameter) {}

  void read(const Setting* setting) {
    result_.meaning = section_.text("meaning");
    result_.source = section_.text("source");
    result_.type = type();
    read_unit();
    read_choices();
    read_limits();
    if (const Node* value = section_.find("value"); value && value->kind == Node::Kind::scalar) {
      if (is_reference(*value)) {
        scope_.report(scope_.at(*value), "the value of a parameter cannot be another parameter",
                      "write it out; in quotes '$' is an ordinary character");
      } else {
        take(value->text, scope_.at(*value));
      }
    }
    if (!setting) return;
    result_.overridden = true;
    take(setting->text, place_of(*setting, setting->name));
  }

 private:
  struct Limit {
    std::string key;
    double si = 0;
  };

  [[nodiscard]] Type type() const {
    static const std::map<std::string, Type> named = {{"number", Type::number},
                                                      {"count", Type::count},
                                                      {"switch", Type::toggle},
                                                      {"choice", Type::choice},
                                                      {"text", Type::text}};
    if (const auto found = named.find(section_.text("type")); found != named.end()) {
      return found->second;
    }
    const Node* value = section_.find("value");
    if (section_.find("choices")) return Type::choice;
    if (section_.find("unit") || !value || value->kind != Node::Kind::scalar) return Type::number;
    if (value->quoted) return Type::text;
    if (value->text == "true" || value->text == "false") return Type::toggle;
    return means_number(value->text) ? Type::number : Type::text;
  }

  void read_unit() {
    if (result_.type != Type::number) {
      if (result_.type != Type::count) result_.unit.clear();
      if (section_.find("unit")) {
        scope_.report(section_.place("unit"), "only a number has a unit",
                      fmt::format("'{}' is a {}", result_.name, type_text(result_)));
      }
      return;
    }
    result_.unit = section_.text("unit");
    const Node* value = section_.find("value");
    Quantity quantity;
    if (result_.unit.empty() && value && Quantity::parse(value->text, quantity)) {
      result_.unit = quantity.unit;
    }
    if (result_.unit.empty()) result_.unit = "1";
  }

  void read_choices() {
    const Node* choices = section_.find("choices");
    if (result_.type != Type::choice) {
      if (choices) {
        scope_.report(section_.place("choices"), "only a choice has choices",
                      "remove 'type' or 'choices'");
      }
      return;
    }
    if (!choices || (choices->kind == Node::Kind::list && choices->items.empty())) {
      scope_.report(scope_.at(choices ? *choices : node_), "a choice needs 'choices'",
                    "list the names to choose from");
      return;
    }
    constexpr size_t most = 50;
    if (choices->items.size() > most) {
      scope_.report(scope_.at(*choices), fmt::format("more than {} choices", most),
                    "a number, count or text has no such limit");
      return;
    }
    for (const Node& item : choices->items) {
      if (item.kind != Node::Kind::scalar) continue;
      auto& names = result_.choices;
      if (!is_choice_name(item.text)) {
        scope_.report(scope_.at(item), fmt::format("{} cannot be a choice", in_quotes(item.text)),
                      "use letters, digits, underscores and hyphens, at most 100");
      } else if (std::find(names.begin(), names.end(), item.text) != names.end()) {
        scope_.report(scope_.at(item),
                      fmt::format("choice {} is listed twice", in_quotes(item.text)));
      } else {
        names.push_back(item.text);
      }
    }
  }

  void read_limits() {
    for (const char* key : {"minimum", "maximum", "above", "below"}) {
      const Node* limit = section_.find(key);
      if (!limit || limit->kind != Node::Kind::scalar) continue;
      if (result_.type != Type::number && result_.type != Type::count) {
        scope_.report(scope_.at(*limit), fmt::format("'{}' fits numbers and counts only", key),
                      fmt::format("'{}' is a {}", result_.name, type_text(result_)));
        continue;
      }
      if (is_reference(*limit)) continue;  // see check_relations
      const std::string& unit = result_.type == Type::number ? result_.unit : "1";
      const Reading reading = read_number(limit->text, Unit::valid(unit) ? unit : "*");
      if (reading.value) {
        limits_.push_back({key, *reading.value->as<double>()});
      } else {
        scope_.report(scope_.at(*limit), reading.what, reading.remedy);
      }
    }
  }

  void take(const std::string& text, const Place& place) {
    if (result_.type == Type::number && !Unit::valid(result_.unit)) return;
    if (result_.type == Type::choice && result_.choices.empty()) return;
    Reading reading = read_as(text, result_);
    if (!reading.value) {
      scope_.report(place, fmt::format("'{}': {}", result_.name, reading.what), reading.remedy);
      return;
    }
    if (within_limits(*reading.value, place)) result_.value = *reading.value;
  }

  /// A value beyond a limit is reported here and not used, so that nothing else stumbles over it.
  [[nodiscard]] bool within_limits(const Value& value, const Place& place) const {
    const auto* number = value.as<double>();
    const auto* count = value.as<std::int64_t>();
    if (!number && !count) return true;
    const double size = number ? *number : static_cast<double>(*count);
    bool good = true;
    for (const Limit& limit : limits_) {
      if (allows(limit.key, size, limit.si)) continue;
      good = false;
      Parameter mine = result_;
      Parameter bound = result_;
      mine.value = value;
      bound.value = number ? Value(limit.si) : Value(static_cast<std::int64_t>(limit.si));
      scope_.report(place, fmt::format("'{}' is {}", result_.name, shown(mine)),
                    fmt::format("{}: {}", limit.key, shown(bound)));
    }
    return good;
  }

  const Node& node_;
  Section section_;
  const Scope& scope_;
  Parameter& result_;
  std::vector<Limit> limits_;
};

/// A value of the right type for a parameter whose own could not be read, so that the pass goes on.
Value placeholder(const Parameter& parameter) {
  switch (parameter.type) {
    case Type::number:
      return 1.0;
    case Type::count:
      return std::int64_t{1};
    case Type::toggle:
      return false;
    case Type::choice:
      return Value::Choice{parameter.choices.empty() ? "" : parameter.choices[0],
                           parameter.choices};
    case Type::text:
      return "";
  }
  return {};
}

/// Limits that are other parameters, once all have their values.
void check_relations(const Node& map, const std::string& file,
                     const std::vector<Parameter>& parameters,
                     const std::map<std::string, const Setting*>& set, Problems& problems) {
  const auto number_of = [](const Parameter& one) -> std::optional<double> {
    if (const auto* number = one.value.as<double>()) return *number;
    if (const auto* count = one.value.as<std::int64_t>()) return static_cast<double>(*count);
    return std::nullopt;
  };
  const Scope scope(file, no_parameters, &problems);
  const Scope all = Scope(file, parameters, &problems).silent();
  for (size_t i = 0; i < map.keys.size(); ++i) {
    if (map.items[i].kind != Node::Kind::map) continue;
    const Parameter& mine = parameters[i];
    const Node chosen = effective(map.items[i], all);
    for (const char* limit : {"minimum", "maximum", "above", "below"}) {
      const Node* bound = chosen.find(limit);
      if (!bound || !is_reference(*bound)) continue;
      const auto other =
          std::find_if(parameters.begin(), parameters.end(),
                       [&](const Parameter& one) { return one.name == bound->text.substr(1); });
      if (other == parameters.end()) continue;  // reported with the file's structure
      const auto value = number_of(mine);
      const auto size = number_of(*other);
      if (!value) continue;  // reported above
      if (!size || mine.type != other->type ||
          (mine.type == Type::number && !Unit::convertible(mine.unit, other->unit))) {
        problems.add(scope.at(*bound),
                     fmt::format("'{}' is no limit for '{}'", other->name, mine.name),
                     fmt::format("it is a {}, not a {}", type_text(*other), type_text(mine)));
      } else if (!allows(limit, *value, *size)) {
        const bool here = set.contains(mine.name), there = set.contains(other->name);
        const Place place =
            here || there
                ? Place{fmt::format("command line (--set {})", here ? mine.name : other->name), 0,
                        0}
                : mine.place;
        problems.add(place, fmt::format("'{}' is {}", mine.name, shown(mine)),
                     fmt::format("{}: '{}', which is {}", limit, other->name, shown(*other)));
      }
    }
  }
}

std::map<std::string, const Setting*> by_name(const std::vector<Setting>& settings,
                                              const Node* parameters) {
  std::vector<std::string> names;
  if (parameters) {
    for (const Node::Key& key : parameters->keys) names.push_back(key.text);
  }
  std::map<std::string, const Setting*> result;
  std::vector<Problem> wrong;
  bool in_study = false;
  for (const Setting& setting : settings) {
    const Place place = place_of(setting, in_quotes(setting.name));
    in_study = in_study || !setting.place.file.empty();
    if (std::find(names.begin(), names.end(), setting.name) == names.end()) {
      wrong.push_back({place,
                       fmt::format("the workflow has no parameter {}", in_quotes(setting.name)),
                       names.empty() ? "it has none at all" : suggest(setting.name, names)});
    } else if (!is_clean_text(setting.text)) {
      // It would end up in scripts, file names and terminals.
      wrong.push_back({place, "the value is not UTF-8 or has control characters", "remove them"});
    } else if (!result.emplace(setting.name, &setting).second) {
      wrong.push_back({place, fmt::format("'{}' is set twice", setting.name), "keep one"});
    }
  }
  if (!wrong.empty()) throw Error(in_study ? ExitCode::refused : ExitCode::usage, std::move(wrong));
  return result;
}

}  // namespace

std::vector<Parameter> read_parameters(const Node& root, const std::string& file,
                                       const std::vector<Setting>& settings, Problems& problems) {
  const Node* map = root.find("parameters");
  if (map && map->kind != Node::Kind::map) map = nullptr;
  const std::map<std::string, const Setting*> set = by_name(settings, map);
  const Scope scope(file, no_parameters, &problems);
  std::vector<Parameter> result;
  const Scope earlier(file, result, &problems);  // what a parameter may choose by
  for (size_t i = 0; map && i < map->keys.size(); ++i) {
    Parameter parameter;
    parameter.name = map->keys[i].text;
    parameter.place = scope.at(map->keys[i]);
    parameter.unit = "1";
    if (is_name(parameter.name) && map->items[i].kind == Node::Kind::map) {
      const auto found = set.find(parameter.name);
      const Setting* setting = found == set.end() ? nullptr : found->second;
      const Parameter blank = parameter;
      bool selected = true;
      for (const Variant& variant :
           variants_of(earlier, {parameter.name, parameter.place, &map->items[i]})) {
        Parameter unused = blank;  // every case is checked, one is used
        if (selected) {
          Declaration(variant.node, scope, parameter).read(setting);
        } else {
          Declaration(variant.node, scope, unused).read(nullptr);
        }
        selected = false;
      }
    }
    if (parameter.value.absent()) parameter.value = placeholder(parameter);
    result.push_back(std::move(parameter));
  }
  if (map) check_relations(*map, file, result, set, problems);
  return result;
}

}  // namespace sandglass::workflow
