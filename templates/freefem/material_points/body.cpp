#include "body.hpp"

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace sandglass::mpm {
namespace {

template <int D>
std::string text(const Vector<D>& at) {
  char buffer[100];
  if constexpr (D == 2) {
    std::snprintf(buffer, sizeof buffer, "(%.6g, %.6g) m", at[0], at[1]);
  } else {
    std::snprintf(buffer, sizeof buffer, "(%.6g, %.6g, %.6g) m", at[0], at[1], at[2]);
  }
  return buffer;
}

double determinant(const std::array<Vector<2>, 2>& m) {
  return m[0][0] * m[1][1] - m[0][1] * m[1][0];
}

double determinant(const std::array<Vector<3>, 3>& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Places of the components of a Symmetric in a D x D tensor.
constexpr int kPlace[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

}  // namespace

template <int D>
Body<D>::Body(std::unique_ptr<Grid<D>> grid, std::unique_ptr<Law> law, double density,
              double thickness)
    : grid_(std::move(grid)), law_(std::move(law)), density_(density), thickness_(thickness) {
  if (!(density > 0 && thickness > 0))
    throw std::runtime_error("density and thickness must be above 0");
  const std::size_t nodes = grid_->nodes().size();
  node_mass_.resize(nodes);
  node_momentum_.resize(nodes);
  node_force_.resize(nodes);
  node_velocity_.resize(nodes);
}

template <int D>
void Body<D>::add_points(const std::vector<Vector<D>>& positions,
                         const std::vector<double>& volumes) {
  if (positions.size() != volumes.size())
    throw std::runtime_error("positions and volumes differ in number");
  for (std::size_t p = 0; p < positions.size(); ++p) {
    if (!(volumes[p] > 0)) {
      throw std::runtime_error("material point " + std::to_string(p) + " has no volume");
    }
    state_.position.push_back(positions[p]);
    volume_.push_back(volumes[p] * thickness_);
    mass_.push_back(volume_.back() * density_);
  }
  state_.velocity.resize(points());
  state_.acceleration.resize(points());
  state_.stress.resize(points());
  state_.stretch.resize(points(), 1);
  cell_.resize(points(), -1);
  shape_.resize(points());
  locate();
  to_grid(false);
}

template <int D>
void Body<D>::add_boundary_points(const std::vector<Vector<D>>& positions) {
  const std::size_t first = boundary_points();
  state_.boundary_position.insert(state_.boundary_position.end(), positions.begin(),
                                  positions.end());
  state_.boundary_displacement.resize(boundary_points());
  state_.boundary_velocity.resize(boundary_points());
  forces_.resize(boundary_points());
  boundary_cell_.resize(boundary_points(), -1);
  boundary_shape_.resize(boundary_points());
  locate();
  to_grid(false);
  for (std::size_t b = first; b < boundary_points(); ++b) require_supported(b, boundary_shape_[b]);
}

template <int D>
void Body<D>::hold(int component, const std::vector<int>& nodes) {
  for (const int node : nodes) {
    if (node < 0 || static_cast<std::size_t>(node) >= grid_->nodes().size() || component < 0 ||
        component >= D) {
      throw std::runtime_error("there is no node " + std::to_string(node) + " with component " +
                               std::to_string(component) + " to hold");
    }
    held_.emplace_back(node, component);
  }
}

template <int D>
void Body<D>::set_forces(const std::vector<Vector<D>>& forces) {
  if (forces.size() != boundary_points()) {
    throw std::runtime_error(std::to_string(forces.size()) + " forces for " +
                             std::to_string(boundary_points()) + " boundary points");
  }
  forces_ = forces;
}

template <int D>
void Body<D>::locate() {
  for (std::size_t p = 0; p < points(); ++p) {
    if (!grid_->shape(state_.position[p], cell_[p], shape_[p])) {
      throw std::runtime_error("material point " + std::to_string(p) + " at " +
                               text<D>(state_.position[p]) + " is outside the grid");
    }
  }
  for (std::size_t b = 0; b < boundary_points(); ++b) {
    if (!grid_->shape(state_.boundary_position[b], boundary_cell_[b], boundary_shape_[b])) {
      throw std::runtime_error("boundary point " + std::to_string(b) + " at " +
                               text<D>(state_.boundary_position[b]) + " is outside the grid");
    }
  }
}

template <int D>
void Body<D>::to_grid(bool with_forces) {
  std::fill(node_mass_.begin(), node_mass_.end(), 0.0);
  std::fill(node_momentum_.begin(), node_momentum_.end(), Vector<D>{});
  if (with_forces) std::fill(node_force_.begin(), node_force_.end(), Vector<D>{});
  for (std::size_t p = 0; p < points(); ++p) {
    const Shape<D>& shape = shape_[p];
    const Vector<D>& velocity = state_.velocity[p];
    const Symmetric& stress = state_.stress[p];
    const double volume = volume_[p] * state_.stretch[p];
    for (int i = 0; i < shape.count; ++i) {
      const int node = shape.node[i];
      const double part = shape.value[i] * mass_[p];
      node_mass_[node] += part;
      for (int k = 0; k < D; ++k) node_momentum_[node][k] += part * velocity[k];
      if (!with_forces) continue;
      for (int k = 0; k < D; ++k) {
        double pull = 0;
        for (int j = 0; j < D; ++j) pull += stress[kPlace[k][j]] * shape.gradient[i][j];
        node_force_[node][k] -= volume * pull;
      }
    }
  }
  if (with_forces) apply_boundary_forces();
}

template <int D>
void Body<D>::momentum_to_grid() {
  std::fill(node_momentum_.begin(), node_momentum_.end(), Vector<D>{});
  for (std::size_t p = 0; p < points(); ++p) {
    const Shape<D>& shape = shape_[p];
    const Vector<D>& velocity = state_.velocity[p];
    for (int i = 0; i < shape.count; ++i) {
      const double part = shape.value[i] * mass_[p];
      for (int k = 0; k < D; ++k) node_momentum_[shape.node[i]][k] += part * velocity[k];
    }
  }
}

template <int D>
void Body<D>::require_supported(std::size_t b, const Shape<D>& shape) const {
  for (int i = 0; i < shape.count; ++i) {
    // Rounding may put a point on a cell's edge a little beyond it.
    if (std::abs(shape.value[i]) > 1e-9 && !(node_mass_[shape.node[i]] > 0)) {
      throw std::runtime_error("boundary point " + std::to_string(b) + " at " +
                               text<D>(state_.boundary_position[b]) +
                               " has a node without mass next to it: its force would not arrive");
    }
  }
}

template <int D>
void Body<D>::apply_boundary_forces() {
  for (std::size_t b = 0; b < boundary_points(); ++b) {
    const Shape<D>& shape = boundary_shape_[b];
    bool any = false;
    for (int k = 0; k < D; ++k) any = any || forces_[b][k] != 0;
    if (!any) continue;
    require_supported(b, shape);
    for (int i = 0; i < shape.count; ++i) {
      if (!(node_mass_[shape.node[i]] > 0)) continue;
      for (int k = 0; k < D; ++k) node_force_[shape.node[i]][k] += shape.value[i] * forces_[b][k];
    }
  }
}

template <int D>
void Body<D>::hold_at_zero(std::vector<Vector<D>>& values) const {
  for (const auto& [node, component] : held_) values[node][component] = 0;
}

template <int D>
void Body<D>::stress_from(std::size_t p, const Matrix& increment) {
  Symmetric strain{};
  for (int k = 0; k < D; ++k)
    for (int j = k; j < D; ++j) strain[kPlace[k][j]] = 0.5 * (increment[k][j] + increment[j][k]);
  law_->advance(strain, state_.stress[p]);
  Matrix deformation = increment;
  for (int k = 0; k < D; ++k) deformation[k][k] += 1;
  state_.stretch[p] *= determinant(deformation);
  if (!(state_.stretch[p] > 0)) {
    throw std::runtime_error("material point " + std::to_string(p) + " at " +
                             text<D>(state_.position[p]) +
                             " is turned inside out: its volume would be " +
                             std::to_string(state_.stretch[p]) + " of the initial one");
  }
}

template <int D>
void Body<D>::strain(double dt, const std::vector<Vector<D>>& grid_velocity) {
  for (std::size_t p = 0; p < points(); ++p) {
    Matrix increment{};
    const Shape<D>& shape = shape_[p];
    for (int i = 0; i < shape.count; ++i)
      for (int k = 0; k < D; ++k)
        for (int j = 0; j < D; ++j)
          increment[k][j] += dt * grid_velocity[shape.node[i]][k] * shape.gradient[i][j];
    stress_from(p, increment);
  }
}

template <int D>
void Body<D>::move_boundary(double dt, const std::vector<Vector<D>>& grid_velocity) {
  for (std::size_t b = 0; b < boundary_points(); ++b) {
    const Shape<D>& shape = boundary_shape_[b];
    Vector<D> velocity{};
    for (int i = 0; i < shape.count; ++i)
      for (int k = 0; k < D; ++k) velocity[k] += shape.value[i] * grid_velocity[shape.node[i]][k];
    for (int k = 0; k < D; ++k) {
      state_.boundary_displacement[b][k] += dt * velocity[k];
      state_.boundary_position[b][k] += dt * velocity[k];
    }
    state_.boundary_velocity[b] = velocity;
  }
}

template <int D>
void Body<D>::step(double dt, Update update) {
  locate();
  to_grid(true);
  hold_at_zero(node_momentum_);
  hold_at_zero(node_force_);
  const std::size_t nodes = node_mass_.size();
  std::vector<Vector<D>>& acceleration = node_force_;  // in place
  for (std::size_t n = 0; n < nodes; ++n) {
    const double mass = node_mass_[n];
    for (int k = 0; k < D; ++k) {
      acceleration[n][k] = mass > 0 ? node_force_[n][k] / mass : 0;
      node_velocity_[n][k] = mass > 0 ? node_momentum_[n][k] / mass + dt * acceleration[n][k] : 0;
    }
  }
  for (std::size_t p = 0; p < points(); ++p) {
    const Shape<D>& shape = shape_[p];
    Vector<D> speed{};
    Vector<D> change{};
    for (int i = 0; i < shape.count; ++i) {
      const int node = shape.node[i];
      for (int k = 0; k < D; ++k) {
        change[k] += shape.value[i] * acceleration[node][k];
        speed[k] += shape.value[i] * node_velocity_[node][k];
      }
    }
    for (int k = 0; k < D; ++k) {
      state_.velocity[p][k] += dt * change[k];
      state_.position[p][k] += dt * speed[k];
    }
  }
  move_boundary(dt, node_velocity_);
  if (update == Update::modified_last) {
    momentum_to_grid();
    hold_at_zero(node_momentum_);
    for (std::size_t n = 0; n < nodes; ++n)
      for (int k = 0; k < D; ++k)
        node_velocity_[n][k] = node_mass_[n] > 0 ? node_momentum_[n][k] / node_mass_[n] : 0;
  }
  strain(dt, node_velocity_);
}

template <int D>
System Body<D>::system(double dt) {
  locate();
  to_grid(true);
  const std::size_t nodes = node_mass_.size();
  std::vector<bool> is_held(nodes * D, false);
  for (const auto& [node, component] : held_)
    is_held[static_cast<std::size_t>(node) * D + component] = true;
  std::vector<int> row_of(nodes * D, -1);
  System result;
  for (std::size_t u = 0; u < nodes * D; ++u) {
    if (!(node_mass_[u / D] > 0) || is_held[u]) continue;
    row_of[u] = static_cast<int>(result.unknown.size());
    result.unknown.push_back(static_cast<int>(u));
  }
  // M a1 + f_int(u) = f_ext with a1 = 4/dt^2 du - 4/dt v - a:
  //   (4/dt^2 M + K) du = f_ext - f_int + M (4/dt v + a)
  std::vector<Vector<D>> inertia(nodes);
  for (std::size_t p = 0; p < points(); ++p) {
    const Shape<D>& shape = shape_[p];
    for (int i = 0; i < shape.count; ++i)
      for (int k = 0; k < D; ++k)
        inertia[shape.node[i]][k] += shape.value[i] * mass_[p] *
                                     (4 / dt * state_.velocity[p][k] + state_.acceleration[p][k]);
  }
  for (const int u : result.unknown) {
    result.right.push_back(node_force_[u / D][u % D] + inertia[u / D][u % D]);
    result.row.push_back(row_of[u]);
    result.column.push_back(row_of[u]);
    result.value.push_back(4 / (dt * dt) * node_mass_[u / D]);
  }
  for (std::size_t p = 0; p < points(); ++p) {
    const Shape<D>& shape = shape_[p];
    const double volume = volume_[p] * state_.stretch[p];
    for (int j = 0; j < shape.count; ++j) {
      for (int m = 0; m < D; ++m) {
        const int column = row_of[static_cast<std::size_t>(shape.node[j]) * D + m];
        if (column < 0) continue;
        // Stress by a unit displacement of this unknown.
        Symmetric unit{};
        for (int k = 0; k < D; ++k) unit[kPlace[k][m]] += (k == m ? 1 : 0.5) * shape.gradient[j][k];
        Symmetric stress = state_.stress[p];
        law_->advance(unit, stress);
        for (int k = 0; k < 6; ++k) stress[k] -= state_.stress[p][k];
        for (int i = 0; i < shape.count; ++i) {
          for (int k = 0; k < D; ++k) {
            const int row = row_of[static_cast<std::size_t>(shape.node[i]) * D + k];
            if (row < 0) continue;
            double pull = 0;
            for (int l = 0; l < D; ++l) pull += stress[kPlace[k][l]] * shape.gradient[i][l];
            result.row.push_back(row);
            result.column.push_back(column);
            result.value.push_back(volume * pull);
          }
        }
      }
    }
  }
  return result;
}

template <int D>
void Body<D>::finish(double dt, const System& system, const std::vector<double>& increments) {
  if (increments.size() != system.unknown.size())
    throw std::runtime_error("increments of another size");
  const std::size_t nodes = node_mass_.size();
  std::vector<Vector<D>> moved(nodes);
  std::vector<Vector<D>> acceleration(nodes);
  for (std::size_t i = 0; i < increments.size(); ++i) {
    const int u = system.unknown[i];
    moved[u / D][u % D] = increments[i];
    node_velocity_[u / D][u % D] = 0;
  }
  // Velocity and acceleration of the nodes at the begin, from the points.
  std::vector<Vector<D>> old_acceleration(nodes);
  for (std::size_t p = 0; p < points(); ++p) {
    const Shape<D>& shape = shape_[p];
    for (int i = 0; i < shape.count; ++i)
      for (int k = 0; k < D; ++k)
        old_acceleration[shape.node[i]][k] += shape.value[i] * mass_[p] * state_.acceleration[p][k];
  }
  std::vector<Vector<D>> new_velocity(nodes);
  for (const int u : system.unknown) {
    const double mass = node_mass_[u / D];
    const double velocity = node_momentum_[u / D][u % D] / mass;
    const double before = old_acceleration[u / D][u % D] / mass;
    double& after = acceleration[u / D][u % D];
    after = 4 / (dt * dt) * moved[u / D][u % D] - 4 / dt * velocity - before;
    new_velocity[u / D][u % D] = velocity + dt / 2 * (before + after);
  }
  for (std::size_t p = 0; p < points(); ++p) {
    const Shape<D>& shape = shape_[p];
    Vector<D> step{};
    Vector<D> after{};
    Matrix increment{};
    for (int i = 0; i < shape.count; ++i) {
      const int node = shape.node[i];
      for (int k = 0; k < D; ++k) {
        step[k] += shape.value[i] * moved[node][k];
        after[k] += shape.value[i] * acceleration[node][k];
        for (int j = 0; j < D; ++j) increment[k][j] += moved[node][k] * shape.gradient[i][j];
      }
    }
    for (int k = 0; k < D; ++k) {
      state_.velocity[p][k] += dt / 2 * (state_.acceleration[p][k] + after[k]);
      state_.position[p][k] += step[k];
    }
    state_.acceleration[p] = after;
    stress_from(p, increment);
  }
  for (std::size_t b = 0; b < boundary_points(); ++b) {
    const Shape<D>& shape = boundary_shape_[b];
    Vector<D> velocity{};
    for (int i = 0; i < shape.count; ++i) {
      for (int k = 0; k < D; ++k) {
        const double share = shape.value[i] * moved[shape.node[i]][k];
        state_.boundary_displacement[b][k] += share;
        state_.boundary_position[b][k] += share;
        velocity[k] += shape.value[i] * new_velocity[shape.node[i]][k];
      }
    }
    state_.boundary_velocity[b] = velocity;
  }
}

template <int D>
double Body<D>::kinetic_energy() const {
  double sum = 0;
  for (std::size_t p = 0; p < points(); ++p)
    for (int k = 0; k < D; ++k)
      sum += 0.5 * mass_[p] * state_.velocity[p][k] * state_.velocity[p][k];
  return sum;
}

template <int D>
double Body<D>::elastic_energy() const {
  double sum = 0;
  for (std::size_t p = 0; p < points(); ++p)
    sum += law_->energy(state_.stress[p]) * volume_[p] * state_.stretch[p];
  return sum;
}

template <int D>
Vector<D> Body<D>::momentum() const {
  Vector<D> sum{};
  for (std::size_t p = 0; p < points(); ++p)
    for (int k = 0; k < D; ++k) sum[k] += mass_[p] * state_.velocity[p][k];
  return sum;
}

template <int D>
double Body<D>::interface_mass(std::size_t b) {
  locate();
  to_grid(false);
  double compliance = 0;
  const Shape<D>& shape = boundary_shape_.at(b);
  for (int i = 0; i < shape.count; ++i) {
    if (node_mass_[shape.node[i]] > 0)
      compliance += shape.value[i] * shape.value[i] / node_mass_[shape.node[i]];
  }
  return 1 / compliance;
}

template <int D>
void Body<D>::set_state(Moving state) {
  if (state.position.size() != points() || state.boundary_position.size() != boundary_points()) {
    throw std::runtime_error("a state of another number of points");
  }
  state_ = std::move(state);
  locate();
}

template class Body<2>;
template class Body<3>;

}  // namespace sandglass::mpm
