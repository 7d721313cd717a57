#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include "coupling/memory.hpp"

namespace sandglass::coupling {

/// When nothing is left to compute: every value of one field has been small for long.
struct RestLimits {
  std::string field;
  double at_most = 0;        ///< in size, in SI
  std::int64_t windows = 0;  ///< one after the other; 0: not looked at
};

/// Counts for how many windows a field has been at rest.
class RestWatch {
 public:
  explicit RestWatch(const RestLimits& limits) : most_(limits.at_most), windows_(limits.windows) {}

  /// Takes the values of the next window.
  void observe(std::span<const double> values) {
    const bool quiet = std::all_of(values.begin(), values.end(),
                                   [&](double value) { return std::abs(value) <= most_; });
    quiet_ = quiet ? quiet_ + 1 : 0;
  }
  [[nodiscard]] bool at_rest() const { return windows_ > 0 && quiet_ >= windows_; }
  void remember(Memory& memory, const std::string& name) {
    if (windows_ > 0) memory(name + ".quiet_windows", quiet_);
  }

 private:
  double most_;
  std::int64_t windows_;
  std::int64_t quiet_ = 0;  ///< windows, the last ones
};

}  // namespace sandglass::coupling
