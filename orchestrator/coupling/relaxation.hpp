#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coupling/memory.hpp"

namespace sandglass::coupling {

enum class Acceleration {
  none,      ///< the newest value as it is
  constant,  ///< x + w r
  aitken,    ///< x + w r, w from the last two residuals (Irons and Tuck, 1969)
  iqn_ils    ///< quasi-Newton over all relaxed fields together, see quasi_newton.hpp
};

/// Relaxation of a fixed-point iteration x -> f(x): the next x from x and the residual r = f(x) -
/// x. With `constant` and one call per window it also relaxes explicit schemes, carried from window
/// to window.
class Relaxation {
 public:
  /// `factor` is w, or the first w for `aitken`.
  Relaxation(Acceleration acceleration, double factor)
      : acceleration_(acceleration), factor_(factor), first_factor_(factor) {}

  /// Replaces `x` by its successor, given f(x).
  void step(std::vector<double>& x, std::span<const double> next);
  /// A new window: Aitken's first step uses the last factor, at most the first one (Küttler and
  /// Wall, 2008).
  void new_window();
  [[nodiscard]] double factor() const { return factor_; }
  /// Keeps or recalls what the next window depends on.
  void remember(Memory& memory, const std::string& name) {
    memory(name + ".factor", factor_);
    memory(name + ".residual", last_residual_);
  }

 private:
  Acceleration acceleration_;
  double factor_;
  double first_factor_;
  std::vector<double> last_residual_;
};

}  // namespace sandglass::coupling
