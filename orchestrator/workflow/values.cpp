#include "workflow/values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "base/unit.hpp"
#include "workflow/problems.hpp"

namespace sandglass::workflow {
namespace {

Reading wrong(std::string what, std::string remedy) {
  return {std::nullopt, std::move(what), std::move(remedy)};
}

std::string number_remedy(const std::string& unit) {
  if (unit == "*") return "write a number with its unit, such as 0.1 mm; a bare number is SI";
  if (unit.empty() || unit == "1") return "write a number without a unit";
  return fmt::format("write a number with a unit, such as 0.1 {}; a bare number is SI", unit);
}

/// Why Quantity::parse refused the text.
std::string number_fault(const std::string& text) {
  double number = 0;
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [rest, error] = std::from_chars(begin, text.data() + text.size(), number);
  if (error == std::errc::result_out_of_range)
    return fmt::format("{} is out of range", in_quotes(text));
  if (error != std::errc() || !std::isfinite(number)) {
    return fmt::format("{} is not a number", in_quotes(text));
  }
  const std::string unit(rest, text.data() + text.size());
  const size_t first = unit.find_first_not_of(" \t");
  return fmt::format("unknown unit {}",
                     in_quotes(first == std::string::npos ? unit : unit.substr(first)));
}

bool plain_word(const std::string& text, bool hyphens) {
  return !text.empty() && text.size() <= 100 && std::all_of(text.begin(), text.end(), [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           (hyphens && c == '-');
  });
}

}  // namespace

bool fits_unit(const std::string& unit, const std::string& wanted) {
  return wanted == "*" || Unit::convertible(unit, wanted);
}

bool means_number(const std::string& text) {
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  double number = 0;
  const auto [rest, error] = std::from_chars(begin, end, number);
  if (error == std::errc::invalid_argument || std::isnan(number) || std::isinf(number))
    return false;
  return rest == end || *rest == ' ';
}

Reading read_count(const std::string& text) {
  std::int64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || rest != end || number < 0) {
    return wrong(fmt::format("{} is not a count", in_quotes(text)),
                 "write a whole number, 0 or more");
  }
  return {Value(number), {}, {}};
}

Reading read_toggle(const std::string& text) {
  if (text == "true") return {Value(true), {}, {}};
  if (text == "false") return {Value(false), {}, {}};
  return wrong(fmt::format("{} is not a switch", in_quotes(text)), "write true or false");
}

Reading read_number(const std::string& text, const std::string& unit) {
  Quantity quantity;
  if (!Quantity::parse(text, quantity)) return wrong(number_fault(text), number_remedy(unit));
  if (quantity.unit.empty()) return {Value(quantity.number), {}, {}};
  if (!fits_unit(quantity.unit, unit)) {
    const std::string wanted = unit.empty() || unit == "1" ? "a number without a unit" : unit;
    return wrong(fmt::format("unit '{}' does not fit {}", quantity.unit, wanted),
                 number_remedy(unit));
  }
  const double si = Unit::to_si(quantity.number, quantity.unit);
  if (!std::isfinite(si)) return wrong(fmt::format("{} is out of range", in_quotes(text)), "");
  return {Value(si), {}, {}};
}

Reading read_as(const std::string& text, const Parameter& type) {
  switch (type.type) {
    case Parameter::Type::number:
      return read_number(text, type.unit);
    case Parameter::Type::count:
      return read_count(text);
    case Parameter::Type::toggle:
      return read_toggle(text);
    case Parameter::Type::choice:
      if (std::find(type.choices.begin(), type.choices.end(), text) == type.choices.end()) {
        return wrong(fmt::format("{} is not a choice of '{}'", in_quotes(text), type.name),
                     suggest(text, type.choices));
      }
      return {Value(Value::Choice{text, type.choices}), {}, {}};
    case Parameter::Type::text:
      return {Value(text), {}, {}};
  }
  throw std::logic_error("parameter without a type");
}

bool is_reference(const Node& node) {
  return node.kind == Node::Kind::scalar && !node.quoted && node.text.starts_with('$');
}

bool is_name(const std::string& text) {
  return plain_word(text, false) && !(text[0] >= '0' && text[0] <= '9');
}

bool is_choice_name(const std::string& text) { return plain_word(text, true); }

bool is_inner_path(const std::string& path) {
  if (path.empty() || path.size() > 500 || path.front() == '/' || path.back() == '/') return false;
  if (path.find('\\') != std::string::npos || path.find('\n') != std::string::npos) return false;
  const std::string framed = fmt::format("/{}/", path);
  return framed.find("//") == std::string::npos && framed.find("/./") == std::string::npos &&
         framed.find("/../") == std::string::npos;
}

bool same_value(const Value& a, const Value& b) {
  if (const auto* left = a.as<double>()) {
    const auto* right = b.as<double>();
    return right && std::abs(*left - *right) <= 1e-9 * std::max(std::abs(*left), std::abs(*right));
  }
  return a.type_name() == b.type_name() && plain_text(a) == plain_text(b);
}

std::string type_text(const Parameter& parameter) {
  switch (parameter.type) {
    case Parameter::Type::number:
      return parameter.unit.empty() || parameter.unit == "1" ? "number without a unit"
                                                             : "number in " + parameter.unit;
    case Parameter::Type::count:
      return "count";
    case Parameter::Type::toggle:
      return "switch";
    case Parameter::Type::choice:
      return fmt::format("choice of {}", fmt::join(parameter.choices, ", "));
    case Parameter::Type::text:
      return "text";
  }
  return {};
}

std::string plain_text(const Value& value) {
  if (const auto* number = value.as<double>()) return shortest(*number);
  if (const auto* count = value.as<std::int64_t>()) return std::to_string(*count);
  if (const auto* flag = value.as<bool>()) return *flag ? "true" : "false";
  if (const auto* text = value.as<std::string>()) return *text;
  if (const auto* choice = value.as<Value::Choice>()) return choice->name;
  return {};
}

}  // namespace sandglass::workflow
