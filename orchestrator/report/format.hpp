#pragma once

#include <string>

namespace sandglass::report {

/// Numbers and units as people read them, in plain text (UTF-8).

/// "0.0089885", "6.1×10⁻⁵", "not finite": up to `digits` significant digits, no trailing zeros.
std::string pretty_number(double value, int digits = 6);
/// "m/s²", "°", "µm"; empty for the dimensionless unit.
std::string pretty_unit(const std::string& unit);
/// An SI value in the unit asked for: "8.989 mm/s".
std::string pretty_quantity(double si, const std::string& unit, int digits = 6);
/// "0.006 %"
std::string pretty_percent(double ratio, int digits = 3);
/// "21 µs", "4.21 s", "1 h 12 min"
std::string pretty_seconds(double seconds);
/// "1.2 MB"
std::string pretty_bytes(double bytes);

}  // namespace sandglass::report
