#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "coupling/memory.hpp"

namespace sandglass::coupling {

/// Interface quasi-Newton with an inverse Jacobian from least squares, IQN-ILS (J. Degroote, K.-J.
/// Bathe, J. Vierendeels, Comput. Struct. 87, 2009, 793), for a fixed-point iteration x -> f(x):
/// from the changes V of the residual r = f(x) - x and W of f(x) in earlier iterations, the next x
/// is f(x) + W a with the a that makes |V a + r| least.
///
/// Columns of earlier windows are reused. Filtering as by the QR2 filter of preCICE: from the
/// newest column on, one that adds less than `filter` of its own length to those before it is
/// forgotten (R. Haelterman et al., Comput. Struct. 171, 2016, 9).
class QuasiNewton {
 public:
  /// `factor` relaxes the iterations of which nothing is known yet; `reused_windows` is how many
  /// earlier windows are used besides the present one.
  QuasiNewton(double factor, std::int64_t reused_windows, double filter)
      : factor_(factor), reused_windows_(reused_windows), filter_(filter) {}

  /// Replaces `x` by its successor, given f(x). `weights` make the entries of fields of different
  /// units comparable. A change of length begins anew.
  void step(std::vector<double>& x, std::span<const double> next, std::span<const double> weights);
  /// A new window.
  void new_window();
  [[nodiscard]] std::size_t columns() const { return columns_.size(); }
  /// Keeps or recalls what the next window depends on.
  void remember(Memory& memory, const std::string& name);

 private:
  struct Column {
    std::vector<double> residual;  ///< its change
    std::vector<double> value;     ///< change of f(x)
    std::int64_t window = 0;
  };
  /// Least squares over the columns, newest first; forgets those that add nothing.
  std::vector<double> combination(const std::vector<double>& residual,
                                  std::span<const double> weights);

  double factor_;
  std::int64_t reused_windows_;
  double filter_;
  std::int64_t window_ = 0;
  std::vector<Column> columns_;  ///< newest first
  std::vector<double> last_residual_;
  std::vector<double> last_value_;
};

}  // namespace sandglass::coupling
