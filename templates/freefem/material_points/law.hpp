#pragma once

#include <array>

namespace sandglass::mpm {

/// A symmetric tensor as xx, yy, zz, xy, yz, xz. Strains are tensor components: xy is half the
/// change of the angle.
using Symmetric = std::array<double, 6>;

/// How stress follows strain in a material point. Another law, such as Mohr-Coulomb's, is another
/// class; history beyond the stress would join the arguments.
class Law {
 public:
  virtual ~Law() = default;
  /// Brings `stress` (Pa) from the begin of a strain increment to its end.
  virtual void advance(const Symmetric& strain_increment, Symmetric& stress) const = 0;
  /// Elastic energy per volume at this stress, J/m3.
  [[nodiscard]] virtual double energy(const Symmetric& stress) const = 0;
};

enum class State { plane_stress, plane_strain, solid };

/// Hooke's law for an isotropic material.
class LinearElastic : public Law {
 public:
  /// Young's modulus in Pa. Throws std::invalid_argument for a material that is not stable: modulus
  /// not above 0, or Poisson's ratio not between -1 and 0.5.
  LinearElastic(double young, double poisson, State state);
  void advance(const Symmetric& strain_increment, Symmetric& stress) const override;
  [[nodiscard]] double energy(const Symmetric& stress) const override;

 private:
  double young_;
  double poisson_;
  double shear_;  ///< Pa
  double lame_;   ///< Pa, that of the plane for plane stress
  State state_;
};

}  // namespace sandglass::mpm
