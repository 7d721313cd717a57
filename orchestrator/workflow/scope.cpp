#include "workflow/scope.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/unit.hpp"
#include "workflow/values.hpp"

namespace sandglass::workflow {
namespace {

std::string kind_text(Node::Kind kind) {
  if (kind == Node::Kind::list) return "a list";
  if (kind == Node::Kind::map) return "a map";
  return "a single value";
}

/// Why the parameter cannot stand at the key; empty when it can.
std::string misfit(const Parameter& parameter, const Key& key) {
  using Type = Parameter::Type;
  const auto no = [&](const std::string& wanted) {
    return fmt::format("parameter '{}' is a {}, not a {}", parameter.name, type_text(parameter),
                       wanted);
  };
  switch (key.kind) {
    case Kind::number:
      if (parameter.type == Type::count && fits_unit("1", key.unit)) return {};
      if (parameter.type != Type::number || !fits_unit(parameter.unit, key.unit)) {
        return no(description_of({.kind = Kind::number, .unit = key.unit}));
      }
      return {};
    case Kind::count:
      return parameter.type == Type::count ? "" : no("count (give it 'type: count')");
    case Kind::toggle:
      return parameter.type == Type::toggle ? "" : no("switch");
    case Kind::choice:
      if (parameter.type != Type::choice) return no("choice");
      for (const std::string& choice : parameter.choices) {
        if (std::find(key.names.begin(), key.names.end(), choice) == key.names.end()) {
          return fmt::format("choice '{}' of parameter '{}' is not valid for '{}'", choice,
                             parameter.name, key.name);
        }
      }
      return {};
    default:
      return {};
  }
}

}  // namespace

Scope Scope::silent() const {
  Scope copy = *this;
  copy.problems_ = nullptr;
  return copy;
}

Scope Scope::assuming(const std::string& parameter, const std::string& choice) const {
  Scope copy = *this;
  copy.assumed_[parameter] = choice;
  return copy;
}

void Scope::report(Place place, std::string what, std::string remedy) const {
  if (problems_) problems_->add(std::move(place), std::move(what), std::move(remedy));
}

void Scope::unknown(Place place, const std::string& what, const std::string& name,
                    const std::vector<std::string>& candidates) const {
  if (problems_) problems_->unknown(std::move(place), what, name, candidates);
}

const Parameter* Scope::parameter(const std::string& name) const {
  for (const Parameter& candidate : *parameters_) {
    if (candidate.name == name) return &candidate;
  }
  return nullptr;
}

std::vector<std::string> Scope::parameter_names() const {
  std::vector<std::string> names;
  for (const Parameter& each : *parameters_) names.push_back(each.name);
  return names;
}

Value Scope::value_of(const Parameter& parameter) const {
  const auto assumed = assumed_.find(parameter.name);
  if (assumed == assumed_.end()) return parameter.value;
  return Value::Choice{assumed->second, parameter.choices};
}

const Parameter* Scope::wanted(Place place, const std::string& name) const {
  const Parameter* found = parameter(name);
  if (!found) {
    if (parameters_->empty()) {
      report(std::move(place), fmt::format("there is no parameter {}", in_quotes(name)),
             "declare it under 'parameters'");
    } else {
      unknown(std::move(place), "there is no parameter", name, parameter_names());
    }
  }
  return found;
}

std::optional<Value> Scope::scalar(const Node& node, const Key& key) const {
  if (node.kind == Node::Kind::broken || node.kind == Node::Kind::nothing) return std::nullopt;
  if (node.kind != Node::Kind::scalar) {
    report(at(node), fmt::format("'{}' cannot be {}", key.name, kind_text(node.kind)),
           "expected: " + description_of(key));
    return std::nullopt;
  }
  std::optional<Value> value = is_reference(node) ? referred(node, key) : written(node, key);
  if (!value) return std::nullopt;
  const auto* count = value->as<std::int64_t>();
  const auto* number = value->as<double>();
  if (!count && !number) return value;
  const double size = count ? static_cast<double>(*count) : *number;
  if ((key.above && !(size > *key.above)) || (key.minimum && !(size >= *key.minimum))) {
    report(at(node), fmt::format("'{}' is {}", key.name, shortest(size)),
           key.above ? fmt::format("it must be above {}", shortest(*key.above))
                     : fmt::format("it must be at least {}", shortest(*key.minimum)));
    return std::nullopt;
  }
  return value;
}

std::optional<Value> Scope::referred(const Node& node, const Key& key) const {
  if (!key.reference) {
    report(at(node), fmt::format("'{}' cannot be a parameter", key.name),
           "write it out; in quotes '$' is an ordinary character");
    return std::nullopt;
  }
  const Parameter* found = wanted(at(node), node.text.substr(1));
  if (!found) return std::nullopt;
  if (const std::string why = misfit(*found, key); !why.empty()) {
    report(at(node), why, "expected: " + description_of(key));
    return std::nullopt;
  }
  const Value value = value_of(*found);
  if (key.kind == Kind::number) {
    if (const auto* count = value.as<std::int64_t>()) return Value(static_cast<double>(*count));
    return value;
  }
  if (key.kind == Kind::count || key.kind == Kind::toggle) return value;
  return Value(plain_text(value));
}

std::optional<Value> Scope::written(const Node& node, const Key& key) const {
  const auto refuse = [&](std::string what, std::string remedy) -> std::optional<Value> {
    report(at(node), std::move(what), std::move(remedy));
    return std::nullopt;
  };
  Reading reading;
  switch (key.kind) {
    case Kind::number:
      reading = read_number(node.text, key.unit);
      break;
    case Kind::count:
      reading = read_count(node.text);
      break;
    case Kind::toggle:
      reading = read_toggle(node.text);
      break;
    case Kind::choice:
      if (std::find(key.names.begin(), key.names.end(), node.text) == key.names.end()) {
        return refuse(fmt::format("{} is not valid for '{}'", in_quotes(node.text), key.name),
                      suggest(node.text, key.names));
      }
      return Value(node.text);
    case Kind::name:
      if (!is_name(node.text)) {
        return refuse(fmt::format("{} is not a name", in_quotes(node.text)),
                      "use letters, digits and underscores, no digit first, at most 100");
      }
      return Value(node.text);
    case Kind::unit:
      if (!Unit::valid(node.text)) {
        return refuse(fmt::format("unknown unit {}", in_quotes(node.text)),
                      "write it as udunits does, such as mm, kg/m3, Pa s; 1 for none");
      }
      return Value(node.text);
    case Kind::version:
      if (node.text != std::to_string(format_version)) {
        return refuse(fmt::format("format version {}", in_quotes(node.text)),
                      fmt::format("this program reads version {}", format_version));
      }
      return Value(format_version);
    case Kind::template_:
      if (!is_inner_path(node.text)) {
        return refuse(fmt::format("{} is not a path below templates/", in_quotes(node.text)),
                      "write it as FOLDER/FILE");
      }
      return Value(node.text);
    default:
      return Value(node.text);
  }
  if (!reading.value) return refuse(reading.what, reading.remedy);
  return reading.value;
}

std::optional<Measured> Scope::measured(const Node& node) const {
  static const Key any{.name = "number", .kind = Kind::number, .reference = true, .unit = "*"};
  const std::optional<Value> value = scalar(node, any);
  if (!value) return std::nullopt;
  Measured result{*value->as<double>(), {}, true};
  if (is_reference(node)) {
    result.unit = parameter(node.text.substr(1))->unit;
    result.bare = false;
  } else if (Quantity quantity; Quantity::parse(node.text, quantity) && !quantity.unit.empty()) {
    result.unit = quantity.unit;
    result.bare = false;
  }
  return result;
}

std::optional<Literal> Scope::literal(const Node& node) const {
  if (node.kind == Node::Kind::list) {
    Value::List list;
    for (const Node& item : node.items) {
      if (item.kind == Node::Kind::nothing) {
        report(at(item), "an item of the list is empty", "write it, or \"\" for an empty text");
        return std::nullopt;
      }
      const std::optional<Literal> value = literal(item);
      if (!value) return std::nullopt;
      if (value->file) {
        report(at(item), "a file cannot stand in a list", "give it a name of its own");
        return std::nullopt;
      }
      list.push_back(value->value);
    }
    return Literal{Value(std::move(list)), std::nullopt};
  }
  if (node.kind == Node::Kind::map) return file_literal(node);
  if (node.kind != Node::Kind::scalar) return std::nullopt;
  if (is_reference(node)) {
    const Parameter* found = wanted(at(node), node.text.substr(1));
    if (!found) return std::nullopt;
    return Literal{value_of(*found), std::nullopt};
  }
  if (node.quoted) return Literal{Value(node.text), std::nullopt};
  if (const Reading toggle = read_toggle(node.text); toggle.value)
    return Literal{*toggle.value, {}};
  if (const Reading count = read_count(node.text); count.value) return Literal{*count.value, {}};
  if (means_number(node.text)) {
    const Reading number = read_number(node.text, "*");
    if (number.value) return Literal{*number.value, {}};
    report(at(node), number.what, "in quotes it is a text");
    return std::nullopt;
  }
  return Literal{Value(node.text), std::nullopt};
}

std::optional<Literal> Scope::file_literal(const Node& node) const {
  const Node* file = node.find("file");
  const Node* data = node.find("data");
  const Node* path = file ? file : data;
  if (!path || node.items.size() != 1) {
    report(at(node), "a map must be {file: STAGE/FILE} or {data: FILE}",
           "other values are numbers, switches, texts, lists and $parameters");
    return std::nullopt;
  }
  if (path->kind != Node::Kind::scalar || !is_inner_path(path->text) ||
      (file && path->text.find('/') == std::string::npos)) {
    report(at(*path), fmt::format("{} is not a file's place", in_quotes(path->text)),
           file ? "write STAGE/FILE" : "write a path below data/");
    return std::nullopt;
  }
  if (data) return Literal{{}, FileReference{"", path->text}};
  const size_t slash = path->text.find('/');
  return Literal{{}, FileReference{path->text.substr(0, slash), path->text.substr(slash + 1)}};
}

std::optional<FieldShape> Scope::shape(const Node& node) const {
  static const Key length{.name = "shape", .kind = Kind::count, .reference = true, .minimum = 1};
  if (node.kind == Node::Kind::broken) return std::nullopt;
  if (node.kind != Node::Kind::list || node.items.empty() || node.items.size() > 8) {
    report(at(node), "'shape' must be a list of 1 to 8 lengths",
           "such as [3] or [{at_most: 100}, 3]");
    return std::nullopt;
  }
  FieldShape result;
  std::int64_t values = 1;
  bool good = true;
  for (const Node& item : node.items) {
    const Node* axis = &item;
    if (item.kind == Node::Kind::map) {
      axis = item.items.size() == 1 ? item.find("at_most") : nullptr;
      if (!axis || &item != &node.items.front()) {
        report(at(item), "an axis must be a length", "only the first may be {at_most: N}");
        good = false;
        continue;
      }
      result.variable = true;
    }
    if (axis->kind == Node::Kind::nothing) report(at(item), "an axis has no length");
    const std::optional<Value> value = scalar(*axis, length);
    if (!value) {
      good = false;
      continue;
    }
    const std::int64_t rows = *value->as<std::int64_t>();
    result.lengths.push_back(rows);
    values = rows > most_field_values / values ? most_field_values + 1 : values * rows;
    if (values > most_field_values) {
      report(at(node), fmt::format("the field has more than {} values", most_field_values),
             "make it smaller");
      return std::nullopt;
    }
  }
  if (!good) return std::nullopt;
  return result;
}

bool Scope::holds(const Node& condition) const {
  if (condition.kind == Node::Kind::broken) return true;
  if (condition.kind != Node::Kind::map) {
    report(at(condition), "a condition must be a map of parameters to values",
           "such as {fluid: box}");
    return true;
  }
  bool all = true;
  for (size_t i = 0; i < condition.keys.size(); ++i) {
    if (!one_holds(condition.keys[i], condition.items[i])) all = false;
  }
  return all;
}

bool Scope::one_holds(const Node::Key& name, const Node& wanted_values) const {
  const Parameter* found = wanted(at(name), name.text);
  if (!found) return true;
  const bool several = wanted_values.kind == Node::Kind::list;
  const std::vector<Node> single{several ? Node{} : wanted_values};
  bool any = false;
  for (const Node& node : several ? wanted_values.items : single) {
    if (node.kind == Node::Kind::broken) continue;
    if (node.kind != Node::Kind::scalar) {
      report(at(node), fmt::format("'{}' needs a value or a list of values", name.text));
      continue;
    }
    const Reading reading = read_as(node.text, *found);
    if (!reading.value) {
      report(at(node), reading.what, reading.remedy);
    } else if (same_value(*reading.value, value_of(*found))) {
      any = true;
    }
  }
  return any;
}

}  // namespace sandglass::workflow
