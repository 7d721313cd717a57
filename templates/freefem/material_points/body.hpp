#pragma once

#include <memory>
#include <string>
#include <vector>

#include "grid.hpp"
#include "law.hpp"

namespace sandglass::mpm {

/// When the stress of a step is brought up to date.
enum class Update {
  last,           ///< USL: with the velocities of the grid after its step
  modified_last,  ///< MUSL: with those mapped once more from the points (Sulsky et al., 1995)
};

/// A system of equations K du = r for the increments of a step, without the nodes that have no
/// mass.
struct System {
  std::vector<int> row, column;  ///< of `value`; entries of the same place add up
  std::vector<double> value;     ///< N/m
  std::vector<double> right;     ///< N
  std::vector<int> unknown;      ///< node * D + component of every row
};

/// Material points that carry a body through a background grid, and boundary points on its surface
/// that take forces and tell displacement and velocity. Whatever goes wrong is an
/// std::runtime_error that names the point.
template <int D>
class Body {
 public:
  /// `thickness` in m is that of a plane body (1 in three dimensions).
  Body(std::unique_ptr<Grid<D>> grid, std::unique_ptr<Law> law, double density,
       double thickness = 1);

  /// Material points by their positions (m) and areas or volumes (m2, m3). Throws for one outside
  /// the grid and for one without volume.
  void add_points(const std::vector<Vector<D>>& positions, const std::vector<double>& volumes);
  /// Points of the surface. Throws for one outside the grid or next to a node without mass, which
  /// could not take its whole force.
  void add_boundary_points(const std::vector<Vector<D>>& positions);
  /// Holds a component of these nodes at zero.
  void hold(int component, const std::vector<int>& nodes);

  /// Forces (N) on the boundary points during the next steps.
  void set_forces(const std::vector<Vector<D>>& forces);
  /// One explicit step of `dt` seconds.
  void step(double dt, Update update = Update::modified_last);
  /// The implicit step by Newmark's method (1/4, 1/2): its linear system, and its end, given the
  /// solution. Mass is lumped.
  [[nodiscard]] System system(double dt);
  void finish(double dt, const System& system, const std::vector<double>& increments);

  [[nodiscard]] const Grid<D>& grid() const { return *grid_; }
  [[nodiscard]] std::size_t points() const { return state_.position.size(); }
  [[nodiscard]] std::size_t boundary_points() const { return state_.boundary_position.size(); }
  [[nodiscard]] double kinetic_energy() const;  ///< J
  [[nodiscard]] double elastic_energy() const;  ///< J
  [[nodiscard]] Vector<D> momentum() const;     ///< kg m/s
  /// Mass of a boundary point as a force sees it: 1 / sum of N^2 / m over its nodes, kg.
  [[nodiscard]] double interface_mass(std::size_t boundary_point);

  /// All that changes: a copy of it is a state to come back to.
  struct Moving {
    std::vector<Vector<D>> position, velocity, acceleration;  ///< of material points
    std::vector<Symmetric> stress;                            ///< Pa
    std::vector<double> stretch;                              ///< volume over the initial one
    std::vector<Vector<D>> boundary_position, boundary_displacement, boundary_velocity;
  };
  [[nodiscard]] const Moving& state() const { return state_; }
  /// Also sets velocities, for a body that moves at the start.
  void set_state(Moving state);

 private:
  using Matrix = std::array<Vector<D>, D>;

  void locate();
  void to_grid(bool with_forces);
  void momentum_to_grid();  ///< anew, onto masses that are there
  void apply_boundary_forces();
  void hold_at_zero(std::vector<Vector<D>>& values) const;
  void strain(double dt, const std::vector<Vector<D>>& grid_velocity);
  void stress_from(std::size_t p, const Matrix& increment);
  void move_boundary(double dt, const std::vector<Vector<D>>& grid_velocity);
  void require_supported(std::size_t boundary_point, const Shape<D>& shape) const;

  std::unique_ptr<Grid<D>> grid_;
  std::unique_ptr<Law> law_;
  double density_;
  double thickness_;
  std::vector<double> mass_, volume_;  ///< of material points; m3, initial
  Moving state_;
  std::vector<Vector<D>> forces_;
  std::vector<int> cell_, boundary_cell_;
  std::vector<Shape<D>> shape_, boundary_shape_;
  std::vector<double> node_mass_;
  std::vector<Vector<D>> node_momentum_, node_force_, node_velocity_;
  std::vector<std::pair<int, int>> held_;  ///< node and component
};

extern template class Body<2>;
extern template class Body<3>;

}  // namespace sandglass::mpm
