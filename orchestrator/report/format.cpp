#include "report/format.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>

#include "base/unit.hpp"

namespace sandglass::report {
namespace {

std::string superscript(const std::string& digits) {
  static const std::array<const char*, 10> raised = {"⁰", "¹", "²", "³", "⁴",
                                                     "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : digits) {
    if (c == '-')
      text += "⁻";
    else if (c >= '0' && c <= '9')
      text += raised.at(static_cast<size_t>(c - '0'));
  }
  return text;
}

void replace_word(std::string& text, const std::string& word, const std::string& by) {
  if (text == word) text = by;
}

}  // namespace

std::string pretty_number(double value, int digits) {
  if (!std::isfinite(value)) return "not finite";
  if (value == 0) return "0";
  const double size = std::abs(value);
  if (size >= 1e-4 && size < 1e6) {
    const int whole = static_cast<int>(std::floor(std::log10(size))) + 1;
    std::string text = fmt::format("{:.{}f}", value, std::max(0, digits - whole));
    if (text.find('.') != std::string::npos) {
      text.erase(text.find_last_not_of('0') + 1);
      if (text.back() == '.') text.pop_back();
    }
    if (text.front() == '-') text.replace(0, 1, "−");
    return text;
  }
  std::string text = fmt::format("{:.{}e}", value, digits - 1);
  const size_t e = text.find('e');
  std::string factor = text.substr(0, e);
  if (factor.find('.') != std::string::npos) {
    factor.erase(factor.find_last_not_of('0') + 1);
    if (factor.back() == '.') factor.pop_back();
  }
  if (factor.front() == '-') factor.replace(0, 1, "−");
  const std::string power = "10" + superscript(std::to_string(std::stoi(text.substr(e + 1))));
  if (factor == "1") return power;
  return factor + "×" + power;
}

std::string pretty_unit(const std::string& unit) {
  if (unit == "1") return {};
  std::string text;
  for (size_t i = 0; i < unit.size();) {
    size_t end = i;
    if (i > 0 &&
        (std::isalpha(static_cast<unsigned char>(unit[i - 1])) != 0 || unit[i - 1] == '^')) {
      if (unit[end] == '-') ++end;
      while (end < unit.size() && unit[end] >= '0' && unit[end] <= '9') ++end;
      if (end > i && unit[end - 1] == '-') end = i;
    }
    if (end > i) {
      if (!text.empty() && text.back() == '^') text.pop_back();
      text += superscript(unit.substr(i, end - i));
      i = end;
    } else {
      text += unit[i++];
    }
  }
  replace_word(text, "deg", "°");
  replace_word(text, "degree", "°");
  replace_word(text, "um", "µm");
  replace_word(text, "us", "µs");
  return text;
}

std::string pretty_quantity(double si, const std::string& unit, int digits) {
  const bool known = !unit.empty() && unit != "1" && Unit::valid(unit);
  const std::string number = pretty_number(known ? Unit::from_si(si, unit) : si, digits);
  const std::string shown = pretty_unit(unit);
  if (shown.empty() || !std::isfinite(si)) return number;
  return number + (shown == "°" ? "" : "\u00a0") + shown;
}

std::string pretty_percent(double ratio, int digits) {
  if (!std::isfinite(ratio)) return "not finite";
  return pretty_number(100 * ratio, digits) + "\u00a0%";
}

std::string pretty_seconds(double seconds) {
  if (!std::isfinite(seconds)) return "unknown";
  if (seconds < 0 || seconds == 0) return "0\u00a0s";
  if (seconds < 1e-3) return pretty_number(1e6 * seconds, 3) + "\u00a0µs";
  if (seconds < 0.1) return pretty_number(1e3 * seconds, 3) + "\u00a0ms";
  if (seconds < 100) return pretty_number(seconds, 3) + "\u00a0s";
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{}\u00a0min\u00a0{:02}\u00a0s", whole / 60, whole % 60);
  return fmt::format("{}\u00a0h\u00a0{:02}\u00a0min", whole / 3600, whole / 60 % 60);
}

std::string pretty_bytes(double bytes) {
  static const std::array<const char*, 5> names = {"B", "kB", "MB", "GB", "TB"};
  size_t k = 0;
  while (bytes >= 1000 && k + 1 < names.size()) {
    bytes /= 1000;
    ++k;
  }
  return pretty_number(bytes, 3) + "\u00a0" + names.at(k);
}

}  // namespace sandglass::report
