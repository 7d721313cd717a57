#pragma once

#include <optional>
#include <string>

#include "workflow/model.hpp"
#include "workflow/yaml.hpp"

namespace sandglass::workflow {

/// A value, or why the text is not one.
struct Reading {
  std::optional<Value> value;
  std::string what;
  std::string remedy;
};

/// A number in SI. A bare number is SI already; a unit must be convertible to `unit` ("*": any).
Reading read_number(const std::string& text, const std::string& unit);
/// Whether an untyped word is meant as a number: it begins with one, and then ends or has a blank.
/// "3 furlings" is (and is wrong), "2D" is not: it would be two days.
bool means_number(const std::string& text);
/// A whole number, 0 or more.
Reading read_count(const std::string& text);
/// true or false.
Reading read_toggle(const std::string& text);
/// The text as a value of this parameter's type (its unit, its choices); limits are not checked.
Reading read_as(const std::string& text, const Parameter& type);

/// A plain scalar that begins with `$`: a reference to a parameter.
bool is_reference(const Node& node);
/// Letters, digits and underscores, no digit first, at most 100 characters.
bool is_name(const std::string& text);
/// What a choice may be called: as a name, but a digit may come first and hyphens are allowed.
bool is_choice_name(const std::string& text);
/// A relative path that stays below where it starts.
bool is_inner_path(const std::string& path);
/// Equal as values: numbers within 1e-9 of the larger one, everything else exactly.
bool same_value(const Value& a, const Value& b);
/// Whether a quantity in `unit` can stand where `wanted` is; "*": everything can.
bool fits_unit(const std::string& unit, const std::string& wanted);
/// "number in mm", "choice of a, b", for messages.
std::string type_text(const Parameter& parameter);
/// The value as one plain word, numbers in SI: for argument vectors and messages.
std::string plain_text(const Value& value);

}  // namespace sandglass::workflow
