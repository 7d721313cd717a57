#include "coupling/relaxation.hpp"

#include <algorithm>
#include <cmath>

namespace sandglass::coupling {

void Relaxation::step(std::vector<double>& x, std::span<const double> next) {
  if (acceleration_ == Acceleration::none || x.size() != next.size()) {
    x.assign(next.begin(), next.end());
    last_residual_.clear();
    return;
  }
  std::vector<double> residual(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) residual[i] = next[i] - x[i];
  if (acceleration_ == Acceleration::aitken && last_residual_.size() == residual.size()) {
    double product = 0;
    double square = 0;
    for (std::size_t i = 0; i < residual.size(); ++i) {
      const double change = residual[i] - last_residual_[i];
      product += last_residual_[i] * change;
      square += change * change;
    }
    if (square > 0) factor_ *= -product / square;
  }
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += factor_ * residual[i];
  if (acceleration_ == Acceleration::aitken) last_residual_ = std::move(residual);
}

void Relaxation::new_window() {
  last_residual_.clear();
  if (acceleration_ == Acceleration::aitken) {
    factor_ = std::copysign(std::min(std::abs(factor_), first_factor_), factor_);
    // A factor that happened to vanish would never recover.
    if (std::abs(factor_) < 1e-3 * first_factor_) factor_ = first_factor_;
  }
}

}  // namespace sandglass::coupling
