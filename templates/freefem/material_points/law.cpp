#include "law.hpp"

#include <stdexcept>

namespace sandglass::mpm {

LinearElastic::LinearElastic(double young, double poisson, State state)
    : young_(young),
      poisson_(poisson),
      shear_(young / (2 * (1 + poisson))),
      lame_(0),
      state_(state) {
  if (!(young > 0)) throw std::invalid_argument("Young's modulus must be above 0");
  if (!(poisson > -1 && poisson < 0.5)) {
    throw std::invalid_argument("Poisson's ratio must be above -1 and below 0.5");
  }
  lame_ = state == State::plane_stress ? young * poisson / (1 - poisson * poisson)
                                       : young * poisson / ((1 + poisson) * (1 - 2 * poisson));
}

void LinearElastic::advance(const Symmetric& strain_increment, Symmetric& stress) const {
  const auto& [xx, yy, zz, xy, yz, xz] = strain_increment;
  const bool plane_stress = state_ == State::plane_stress;
  const double volume = lame_ * (plane_stress ? xx + yy : xx + yy + zz);
  stress[0] += volume + 2 * shear_ * xx;
  stress[1] += volume + 2 * shear_ * yy;
  if (!plane_stress) stress[2] += volume + 2 * shear_ * zz;
  stress[3] += 2 * shear_ * xy;
  stress[4] += 2 * shear_ * yz;
  stress[5] += 2 * shear_ * xz;
}

double LinearElastic::energy(const Symmetric& stress) const {
  const auto& [xx, yy, zz, xy, yz, xz] = stress;
  const double trace = xx + yy + zz;
  const double squares = xx * xx + yy * yy + zz * zz + 2 * (xy * xy + yz * yz + xz * xz);
  return ((1 + poisson_) * squares - poisson_ * trace * trace) / (2 * young_);
}

}  // namespace sandglass::mpm
