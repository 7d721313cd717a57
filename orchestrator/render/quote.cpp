#include "render/quote.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string_view>

#include "base/unit.hpp"

namespace sandglass {
namespace render {
namespace {

constexpr int deepest_list = 100;

/// What a language writes around and between the items of a list; `nested`: items may be lists.
struct ListStyle {
  std::string_view open, between, close;
  bool nested, empty, text;
};

std::optional<ListStyle> list_style(Language language) {
  switch (language) {
    case Language::python:
    case Language::json:
      return ListStyle{"[", ", ", "]", true, true, true};
    case Language::freefem:
      return ListStyle{"[", ", ", "]", true, false, true};
    case Language::gmsh:
      return ListStyle{"{", ", ", "}", false, true, false};
    case Language::lammps:
      return ListStyle{"", " ", "", false, false, true};
    case Language::shell:
      return ListStyle{"", " ", "", false, true, true};
    case Language::html:
    case Language::text:
      break;
  }
  return std::nullopt;
}

std::string_view language_name(Language language) {
  switch (language) {
    case Language::python:
      return "Python";
    case Language::freefem:
      return "FreeFEM";
    case Language::gmsh:
      return "gmsh";
    case Language::lammps:
      return "LAMMPS";
    case Language::shell:
      return "a shell script";
    case Language::json:
      return "JSON";
    case Language::html:
      return "HTML";
    case Language::text:
      return "plain text";
  }
  return {};
}

[[noreturn]] void refuse(std::string what, std::string remedy = {}) {
  throw Error::refused(Place{}, std::move(what), std::move(remedy));
}

/// In an expression a negative number needs its brackets: 3-{{x}}, {{x}}**2.
bool has_operators(Language language) {
  return language == Language::python || language == Language::freefem ||
         language == Language::gmsh;
}

void append_number(std::string& out, double number, Language language, bool bracket) {
  if (!std::isfinite(number)) refuse(fmt::format("{} is not a finite number", number));
  bracket = bracket && std::signbit(number) && has_operators(language);
  if (bracket) out += '(';
  const std::size_t begin = out.size();
  out += shortest(number);
  // Without a point it would be a whole number there, with its own division. People and JSON do
  // not need it.
  const bool real = language == Language::python || language == Language::freefem ||
                    language == Language::gmsh || language == Language::lammps;
  if (real && out.find_first_of(".e", begin) == out.npos) out += ".0";
  if (bracket) out += ')';
}

void append_count(std::string& out, std::int64_t count, Language language, bool bracket) {
  if (language == Language::freefem && (count > INT32_MAX || count < -INT32_MAX)) {
    refuse(fmt::format("FreeFEM reads whole numbers with 32 bits, which cannot hold {}", count),
           "give it as a number instead of a count");
  }
  constexpr std::int64_t exact = std::int64_t{1} << 53;
  if (language == Language::gmsh && (count > exact || count < -exact))
    refuse(fmt::format("gmsh has floating-point numbers only, which cannot hold {}", count));
  bracket = bracket && count < 0 && has_operators(language);
  fmt::format_to(std::back_inserter(out), fmt::runtime(bracket ? "({})" : "{}"), count);
}

std::string_view switch_name(bool flag, Language language) {
  switch (language) {
    case Language::python:
      return flag ? "True" : "False";
    case Language::gmsh:
      return flag ? "1" : "0";
    case Language::lammps:
      return flag ? "yes" : "no";
    default:
      return flag ? "true" : "false";
  }
}

void append(std::string& out, const Value& value, Language language, int depth);

void append_list(std::string& out, const Value::List& list, Language language, int depth) {
  const std::optional<ListStyle> style = list_style(language);
  if (!style) {
    refuse(fmt::format("a list has no form in {}", language_name(language)),
           "write a section over its items: {{#name}} {{.}} {{/name}}");
  }
  if (depth >= deepest_list) refuse(fmt::format("a list is nested deeper than {}", deepest_list));
  if (depth > 0 && !style->nested)
    refuse(fmt::format("{} has no list of lists", language_name(language)));
  if (list.empty() && !style->empty)
    refuse(fmt::format("{} has no empty list", language_name(language)));
  out += style->open;
  bool first = true;
  for (const Value& item : list) {
    if (!first) out += style->between;
    first = false;
    if (!style->text && (item.as<std::string>() || item.as<Value::Choice>()))
      refuse(fmt::format("{} has no list of texts", language_name(language)));
    append(out, item, language, depth + 1);
  }
  out += style->close;
}

void append(std::string& out, const Value& value, Language language, int depth) {
  if (const auto* number = value.as<double>()) {
    append_number(out, *number, language, depth == 0);
  } else if (const auto* count = value.as<std::int64_t>()) {
    append_count(out, *count, language, depth == 0);
  } else if (const auto* flag = value.as<bool>()) {
    out += switch_name(*flag, language);
  } else if (const auto* text = value.as<std::string>()) {
    append_text(out, *text, language);
  } else if (const auto* choice = value.as<Value::Choice>()) {
    append_text(out, choice->name, language);
  } else if (const auto* markup = value.as<Value::Markup>()) {
    if (language != Language::html)
      refuse(fmt::format("markup has no form in {}", language_name(language)));
    out += markup->text;
  } else if (const auto* list = value.as<Value::List>()) {
    append_list(out, *list, language, depth);
  } else if (value.as<Value::Map>()) {
    refuse("a map has no text of its own", "name one of its members: {{name.member}}");
  } else {
    refuse("there is no value here, where text is wanted");
  }
}

}  // namespace

void append_quoted(std::string& out, const Value& value, Language language) {
  append(out, value, language, 0);
}

}  // namespace render

std::string quote(const Value& value, Language language) {
  std::string out;
  render::append_quoted(out, value, language);
  return out;
}

}  // namespace sandglass
