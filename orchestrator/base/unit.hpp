#pragma once

#include <string>

namespace sandglass {

/// Physical units by udunits-2, plus `deg` (which udunits calls `degree`). All numbers inside the
/// program are SI; units exist only where text comes in and where numbers go out.
class Unit {
 public:
  /// True when `text` names a unit. The empty text and "1" are the dimensionless unit.
  static bool valid(const std::string& text);
  /// True when both are units and a quantity in one can be expressed in the other.
  static bool convertible(const std::string& from, const std::string& to);
  /// True when 0 of it is not 0 in SI, such as degC: a difference in it is none in SI.
  static bool has_offset(const std::string& text);
  /// The number in SI base units. Throws std::invalid_argument for an invalid unit.
  static double to_si(double number, const std::string& unit);
  /// The number in `unit`, given it in SI base units. Throws std::invalid_argument.
  static double from_si(double number, const std::string& unit);
};

/// A number as people write it: "0.1 mm", "17.19 deg", "-3e5 Pa", "42".
struct Quantity {
  double number = 0;
  std::string unit;  ///< empty when none was written

  /// Splits the text into number and unit. False when it does not start with a number, when the
  /// number overflows or is not finite, or when the rest is not a unit.
  static bool parse(const std::string& text, Quantity& out);
};

/// The shortest text that reads back as the same double ("0.1", "1e-06").
std::string shortest(double number);

}  // namespace sandglass
