#include "base/unit.hpp"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <stdexcept>
#include <string_view>

namespace sandglass {
namespace {

struct FreeSystem {
  void operator()(ut_system* system) const { ut_free_system(system); }
};
struct FreeUnit {
  void operator()(ut_unit* unit) const { ut_free(unit); }
};
struct FreeConverter {
  void operator()(cv_converter* converter) const { cv_free(converter); }
};
using UnitPointer = std::unique_ptr<ut_unit, FreeUnit>;
using ConverterPointer = std::unique_ptr<cv_converter, FreeConverter>;

// The unit database is read on first use only: most commands are done before they need it.
ut_system* unit_system() {
  static const std::unique_ptr<ut_system, FreeSystem> system = [] {
    ut_set_error_message_handler(ut_ignore);
    std::unique_ptr<ut_system, FreeSystem> loaded(ut_read_xml(nullptr));
    if (!loaded) throw std::runtime_error("the udunits-2 unit database could not be read");
    ut_unit* degree = ut_get_unit_by_name(loaded.get(), "degree");
    ut_map_name_to_unit("deg", UT_ASCII, degree);
    ut_free(degree);
    return loaded;
  }();
  return system.get();
}

bool is_foreign(char c) { return (c & 0x80) != 0; }
bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || is_foreign(c); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// False for text in which udunits would find numbers that nobody meant: "1.5.3" would be 0.45 and
/// "m^0.5" five; "3 m", "K @ 5", "s since 2000" carry values of their own. Digits are exponents
/// only, except for the 1 of "1/s".
bool plausible_unit(const std::string& text) {
  if (text.size() > 200) return false;
  // udunits takes other bytes than ASCII for letters of names, whatever they are.
  for (size_t i = 0; i < text.size(); ++i) {
    if (!is_foreign(text[i])) continue;
    constexpr std::string_view signs[] = {"°", "µ", "μ", "·", "²", "³", "Å", "Ω"};
    const auto* sign = std::find_if(std::begin(signs), std::end(signs), [&](std::string_view each) {
      return std::string_view(text).substr(i).starts_with(each);
    });
    if (sign == std::end(signs)) return false;
    i += sign->size() - 1;
  }
  const auto at = [&](size_t i) { return i < text.size() ? text[i] : '\0'; };
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (!is_letter(c) && !is_digit(c) &&
        std::string_view(" /*.^-+()%").find(c) == std::string_view::npos)
      return false;
    const bool starts_number = is_digit(c) && (i == 0 || !is_digit(text[i - 1]));
    if (!starts_number) continue;
    if (c == '1' && !is_digit(at(i + 1)) && (i == 0 || text[i - 1] == '(') &&
        (i + 1 == text.size() || at(i + 1) == '/' || at(i + 1) == ')')) {
      continue;
    }
    const size_t base = i > 0 && (text[i - 1] == '-' || text[i - 1] == '+') ? i - 1 : i;
    if (base == 0 || (!is_letter(text[base - 1]) && text[base - 1] != '^' && text[base - 1] != '*'))
      return false;
    if (text[base - 1] == '*' && (base < 2 || text[base - 2] != '*')) return false;
  }
  return true;
}

UnitPointer parse_unit(const std::string& text) {
  if (!plausible_unit(text)) return nullptr;
  return UnitPointer(ut_parse(unit_system(), text.empty() ? "1" : text.c_str(), UT_UTF8));
}

/// A unit, analysed once. With `scale` 0 the converters know more (an offset, or all digits).
struct Definition {
  bool valid = false;
  double scale = 0;       ///< SI value of one unit
  std::string dimension;  ///< in base units, angles left out: "m-3.kg"
  ConverterPointer to_si;
  ConverterPointer from_si;
};

/// The units that nearly every workflow uses. Reading the unit database takes longer than checking
/// a whole workflow; these do without it (a test compares them with it).
struct Common {
  const char* name;
  double scale;
  const char* dimension;
};
constexpr Common common_units[] = {{"", 1, ""},
                                   {"1", 1, ""},
                                   {"%", 0.01, ""},
                                   {"m", 1, "m"},
                                   {"cm", 0.01, "m"},
                                   {"mm", 0.001, "m"},
                                   {"um", 1e-6, "m"},
                                   {"s", 1, "s"},
                                   {"ms", 0.001, "s"},
                                   {"us", 1e-6, "s"},
                                   {"min", 60, "s"},
                                   {"m2", 1, "m2"},
                                   {"m3", 1, "m3"},
                                   {"m/s", 1, "m.s-1"},
                                   {"m/s2", 1, "m.s-2"},
                                   {"mm/s", 0.001, "m.s-1"},
                                   {"1/s", 1, "s-1"},
                                   {"kg", 1, "kg"},
                                   {"g", 0.001, "kg"},
                                   {"kg/m3", 1, "m-3.kg"},
                                   {"g/cm3", 1000, "m-3.kg"},
                                   {"kg/m^3", 1, "m-3.kg"},
                                   {"m/s^2", 1, "m.s-2"},
                                   {"N", 1, "m.kg.s-2"},
                                   {"N/m", 1, "kg.s-2"},
                                   {"Pa", 1, "m-1.kg.s-2"},
                                   {"kPa", 1000, "m-1.kg.s-2"},
                                   {"MPa", 1e6, "m-1.kg.s-2"},
                                   {"GPa", 1e9, "m-1.kg.s-2"},
                                   {"Pa s", 1, "m-1.kg.s-1"},
                                   {"J", 1, "m2.kg.s-2"},
                                   {"K", 1, "K"},
                                   {"rad", 1, ""},
                                   {"deg", std::numbers::pi / 180, ""}};

/// A definition reads like "0.001 m", "K @ 273.15" or "0.0174532925199433 rad": its base units.
std::string base_units(const ut_unit* unit) {
  char buffer[512];
  const int length = ut_format(unit, buffer, sizeof buffer, UT_ASCII | UT_DEFINITION);
  if (length < 0 || length >= static_cast<int>(sizeof buffer)) return "?";
  std::string text(buffer);
  if (const size_t at = text.find(" @ "); at != std::string::npos) text.erase(at);
  double scale = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), scale);
  if (error == std::errc()) text.erase(0, static_cast<size_t>(rest - text.data()));
  const size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "1" : text.substr(first);
}

/// "rad.s-1" and "s-1" are one dimension: an angle is a ratio.
std::string without_angles(const std::string& units) {
  std::string result;
  for (size_t begin = 0; begin <= units.size();) {
    const size_t end = std::min(units.find('.', begin), units.size());
    const std::string factor = units.substr(begin, end - begin);
    if (!factor.starts_with("rad") && factor != "1") {
      if (!result.empty()) result += '.';
      result += factor;
    }
    begin = end + 1;
  }
  return result;
}

Definition define(const std::string& text) {
  Definition result;
  for (const Common& common : common_units) {
    if (text != common.name) continue;
    result.valid = true;
    result.scale = common.scale;
    result.dimension = common.dimension;
    return result;
  }
  const UnitPointer unit = parse_unit(text);
  if (!unit) return result;
  const std::string units = base_units(unit.get());
  const UnitPointer si(ut_parse(unit_system(), units.c_str(), UT_ASCII));
  if (!si) return result;
  result.to_si.reset(ut_get_converter(unit.get(), si.get()));
  result.from_si.reset(ut_get_converter(si.get(), unit.get()));
  result.dimension = without_angles(units);
  result.valid = result.to_si && result.from_si;
  return result;
}

const Definition& definition_of(const std::string& text) {
  static std::mutex mutex;
  static std::map<std::string, Definition> known;
  const std::lock_guard lock(mutex);
  const auto found = known.find(text);
  if (found != known.end()) return found->second;
  return known.emplace(text, define(text)).first->second;
}

const Definition& valid_definition(const std::string& text) {
  const Definition& unit = definition_of(text);
  if (!unit.valid) throw std::invalid_argument(fmt::format("'{}' is not a unit", text));
  return unit;
}

}  // namespace

bool Unit::valid(const std::string& text) { return definition_of(text).valid; }

bool Unit::convertible(const std::string& from, const std::string& to) {
  // Not ut_are_convertible: to udunits, seconds and hertz are.
  const Definition& a = definition_of(from);
  const Definition& b = definition_of(to);
  return a.valid && b.valid && a.dimension == b.dimension;
}

bool Unit::has_offset(const std::string& text) { return valid(text) && to_si(0, text) != 0; }

double Unit::to_si(double number, const std::string& text) {
  const Definition& unit = valid_definition(text);
  if (unit.scale > 0) return number * unit.scale;
  return cv_convert_double(unit.to_si.get(), number);
}
double Unit::from_si(double number, const std::string& text) {
  const Definition& unit = valid_definition(text);
  if (unit.scale > 0) return number / unit.scale;
  return cv_convert_double(unit.from_si.get(), number);
}

bool Quantity::parse(const std::string& text, Quantity& out) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+' && ++begin != end && *begin == '-') return false;
  double number = 0;
  const auto [rest, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || !std::isfinite(number)) return false;
  std::string unit(rest, end);
  const size_t first = unit.find_first_not_of(" \t");
  unit = first == std::string::npos ? "" : unit.substr(first);
  if (const size_t last = unit.find_last_not_of(" \t"); last != std::string::npos)
    unit.erase(last + 1);
  // "1e", "1e5e3": an exponent gone wrong, not the charge of an electron.
  if (unit.find_first_not_of("eE+-0123456789") == unit.npos && unit != "1" && !unit.empty())
    return false;
  if (!unit.empty() && !Unit::valid(unit)) return false;
  out = {number, unit};
  return true;
}

std::string shortest(double number) { return fmt::format("{}", number); }

}  // namespace sandglass
