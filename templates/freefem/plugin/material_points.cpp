// The material point method as FreeFEM functions: one body a script. The work is done in
// ../material_points, which does not know FreeFEM. Positions and forces are rows of three numbers,
// of which a plane body uses two.

#include "material_points.hpp"

#include <stdexcept>
#include <variant>
#include <vector>

#include "../material_points/body.hpp"
#include "function.hpp"

namespace sandglass::freefem {
namespace {

using mpm::Body;

template <int D>
struct Kept {
  std::unique_ptr<mpm::Grid<D>> grid;  // until the body takes it
  std::unique_ptr<Body<D>> body;
  std::vector<double> share{1};  // of the boundary points of a group in its force and motion
  typename Body<D>::Moving saved;
  mpm::System system;
};
std::variant<Kept<2>, Kept<3>> kept;  // NOLINT: one body a script

/// What `action(kept)` returns, with the body's dimension known. Errors end the script.
template <class Action>
auto with(const Action& action) {
  return telling_anybody([&] { return std::visit(action, kept); });
}

template <int D>
void require_grid(const Kept<D>& one) {
  if (!one.grid)
    throw std::runtime_error("there is no grid yet: call mpmBoxGrid or mpmTriangleGrid first");
}

template <int D>
Body<D>& body_of(Kept<D>& one) {
  if (!one.body)
    throw std::runtime_error("there is no body of material points yet: call mpmBody first");
  return *one.body;
}

template <int D>
std::vector<mpm::Vector<D>> rows(const KNM<double>& matrix) {
  if (matrix.M() < D)
    throw std::runtime_error("rows of " + std::to_string(D) + " numbers are needed");
  std::vector<mpm::Vector<D>> result(static_cast<std::size_t>(matrix.N()));
  for (long i = 0; i < matrix.N(); ++i)
    for (long k = 0; k < D; ++k) result[static_cast<std::size_t>(i)][k] = matrix(i, k);
  return result;
}

/// The weighted means of consecutive groups.
template <int D>
std::vector<mpm::Vector<D>> means(const std::vector<mpm::Vector<D>>& values,
                                  const std::vector<double>& share) {
  std::vector<mpm::Vector<D>> result(values.size() / share.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    for (int k = 0; k < D; ++k)
      result[i / share.size()][k] += share[i % share.size()] * values[i][k];
  return result;
}

template <int D>
void fill(KNM<double>& matrix, const std::vector<mpm::Vector<D>>& values) {
  matrix.resize(static_cast<long>(values.size()), 3);
  for (long i = 0; i < matrix.N(); ++i)
    for (long k = 0; k < 3; ++k)
      matrix(i, k) = k < D ? values[static_cast<std::size_t>(i)][k % D] : 0;
}

void fill(KN<double>& vector, const std::vector<double>& values) {
  vector.resize(static_cast<long>(values.size()));
  for (long i = 0; i < vector.N(); ++i) vector[i] = values[static_cast<std::size_t>(i)];
}

// Grids: each begins anew.

long box(Stack, KN<double>* origin, KN<double>* size, KN<long>* cells) {
  return telling_anybody([&]() -> long {
    const auto make = [&]<int D>(std::integral_constant<int, D>) {
      mpm::Vector<D> from{}, extent{};
      std::array<int, D> number{};
      for (int k = 0; k < D; ++k) {
        from[k] = (*origin)[k];
        extent[k] = (*size)[k];
        number[k] = static_cast<int>((*cells)[k]);
      }
      Kept<D> one;
      one.grid = std::make_unique<mpm::BoxGrid<D>>(from, extent, number);
      const long nodes = static_cast<long>(one.grid->nodes().size());
      kept = std::move(one);
      return nodes;
    };
    const long dimension = cells->N();
    if (origin->N() != dimension || size->N() != dimension || dimension < 2 || dimension > 3) {
      throw std::runtime_error("mpmBoxGrid needs 2 or 3 numbers each of origin, size and cells");
    }
    return dimension == 2 ? make(std::integral_constant<int, 2>())
                          : make(std::integral_constant<int, 3>());
  });
}

long triangles(Stack, KNM<double>* nodes, KNM<double>* corners) {
  return telling_anybody([&]() -> long {
    if (corners->M() < 3) throw std::runtime_error("rows of 3 corners are needed");
    std::vector<std::array<int, 3>> numbers(static_cast<std::size_t>(corners->N()));
    for (long t = 0; t < corners->N(); ++t)
      for (long k = 0; k < 3; ++k)
        numbers[static_cast<std::size_t>(t)][k] = static_cast<int>((*corners)(t, k));
    Kept<2> one;
    one.grid = std::make_unique<mpm::TriangleGrid>(rows<2>(*nodes), std::move(numbers));
    kept = std::move(one);
    return nodes->N();
  });
}

long grid_nodes(Stack, KNM<double>* positions) {
  return with([&]<int D>(Kept<D>& one) -> long {
    if (!one.body) require_grid(one);
    fill<D>(*positions, one.body ? one.body->grid().nodes() : one.grid->nodes());
    return positions->N();
  });
}

// The body.

long body(Stack, string* state, double young, double poisson, KN<double>* density_thickness) {
  return with([&]<int D>(Kept<D>& one) -> long {
    require_grid(one);
    mpm::State which = mpm::State::solid;
    if (*state == "plane stress") {
      which = mpm::State::plane_stress;
    } else if (*state == "plane strain") {
      which = mpm::State::plane_strain;
    } else if (*state != "solid") {
      throw std::runtime_error("'" + *state + "' is not one of plane stress, plane strain, solid");
    }
    if ((which == mpm::State::solid) != (D == 3)) {
      throw std::runtime_error("'" + *state + "' does not fit a grid of " + std::to_string(D) +
                               " dimensions");
    }
    if (density_thickness->N() < 4 - D)
      throw std::runtime_error(D == 2 ? "a plane body needs density and thickness"
                                      : "a body needs its density");
    one.body = std::make_unique<Body<D>>(
        std::move(one.grid), std::make_unique<mpm::LinearElastic>(young, poisson, which),
        (*density_thickness)[0], D == 2 ? (*density_thickness)[1] : 1);
    return 0;
  });
}

long points(Stack, KNM<double>* positions, KN<double>* volumes) {
  return with([&]<int D>(Kept<D>& one) -> long {
    std::vector<double> sizes(static_cast<std::size_t>(volumes->N()));
    for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = (*volumes)[static_cast<long>(i)];
    body_of(one).add_points(rows<D>(*positions), sizes);
    return static_cast<long>(body_of(one).points());
  });
}

// A script's loops over boundary points would cost more than the motion of the body: FreeFEM asks
// the kernel for the time at every statement.
long boundary(Stack, KNM<double>* positions, KN<double>* share) {
  return with([&]<int D>(Kept<D>& one) -> long {
    if (share->N() < 1 || positions->N() % share->N() != 0)
      throw std::runtime_error(std::to_string(positions->N()) +
                               " boundary points are no groups of " + std::to_string(share->N()));
    body_of(one).add_boundary_points(rows<D>(*positions));
    one.share.clear();
    for (long i = 0; i < share->N(); ++i) one.share.push_back((*share)[i]);
    one.saved = body_of(one).state();
    return positions->N() / share->N();
  });
}

long hold(Stack, long component, KN<long>* nodes) {
  return with([&]<int D>(Kept<D>& one) -> long {
    std::vector<int> numbers;
    for (long i = 0; i < nodes->N(); ++i) numbers.push_back(static_cast<int>((*nodes)[i]));
    body_of(one).hold(static_cast<int>(component), numbers);
    return nodes->N();
  });
}

// Motion.

long forces(Stack, KNM<double>* values) {
  return with([&]<int D>(Kept<D>& one) -> long {
    Body<D>& body = body_of(one);
    const std::vector<mpm::Vector<D>> given = rows<D>(*values);
    const std::size_t groups = body.boundary_points() / one.share.size();
    if (given.size() > groups)
      throw std::runtime_error(std::to_string(given.size()) + " forces for " +
                               std::to_string(groups) + " groups of boundary points");
    std::vector<mpm::Vector<D>> shared(body.boundary_points());
    for (std::size_t i = 0; i < given.size() * one.share.size(); ++i)
      for (int k = 0; k < D; ++k)
        shared[i][k] = one.share[i % one.share.size()] * given[i / one.share.size()][k];
    body.set_forces(shared);
    return values->N();
  });
}

long step(Stack, double dt, string* update) {
  return with([&]<int D>(Kept<D>& one) -> long {
    if (*update != "musl" && *update != "usl")
      throw std::runtime_error("'" + *update + "' is not musl or usl");
    body_of(one).step(dt, *update == "musl" ? mpm::Update::modified_last : mpm::Update::last);
    return 0;
  });
}

long system(Stack, double dt, KN<long>* row, KN<long>* column, KN<double>* value,
            KN<double>* right) {
  return with([&]<int D>(Kept<D>& one) -> long {
    one.system = body_of(one).system(dt);
    const long entries = static_cast<long>(one.system.value.size());
    row->resize(entries);
    column->resize(entries);
    for (long i = 0; i < entries; ++i) {
      (*row)[i] = one.system.row[static_cast<std::size_t>(i)];
      (*column)[i] = one.system.column[static_cast<std::size_t>(i)];
    }
    fill(*value, one.system.value);
    fill(*right, one.system.right);
    return right->N();
  });
}

long finish(Stack, double dt, KN<double>* increments) {
  return with([&]<int D>(Kept<D>& one) -> long {
    std::vector<double> values(static_cast<std::size_t>(increments->N()));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = (*increments)[static_cast<long>(i)];
    body_of(one).finish(dt, one.system, values);
    return 0;
  });
}

long interface(Stack, KNM<double>* displacement, KNM<double>* velocity) {
  return with([&]<int D>(Kept<D>& one) -> long {
    const auto& state = body_of(one).state();
    fill<D>(*displacement, means<D>(state.boundary_displacement, one.share));
    fill<D>(*velocity, means<D>(state.boundary_velocity, one.share));
    return displacement->N();
  });
}

double kinetic(Stack) {
  return with([]<int D>(Kept<D>& one) { return body_of(one).kinetic_energy(); });
}

double elastic(Stack) {
  return with([]<int D>(Kept<D>& one) { return body_of(one).elastic_energy(); });
}

double interface_mass(Stack, long point) {
  return with([&]<int D>(Kept<D>& one) {
    return body_of(one).interface_mass(static_cast<std::size_t>(point));
  });
}

// State.

long save(Stack) {
  return with([]<int D>(Kept<D>& one) -> long {
    one.saved = body_of(one).state();
    return 0;
  });
}

long restore(Stack) {
  return with([]<int D>(Kept<D>& one) -> long {
    body_of(one).set_state(one.saved);
    return 0;
  });
}

/// All that changes as one vector, and back: for files.
template <int D, class Each>
void each_number(typename Body<D>::Moving& state, const Each& take) {
  for (auto* vectors :
       {&state.position, &state.velocity, &state.acceleration, &state.boundary_position,
        &state.boundary_displacement, &state.boundary_velocity})
    for (auto& vector : *vectors)
      for (double& x : vector) take(x);
  for (auto& stress : state.stress)
    for (double& x : stress) take(x);
  for (double& x : state.stretch) take(x);
}

long state(Stack, KN<double>* numbers) {
  return with([&]<int D>(Kept<D>& one) -> long {
    auto moving = body_of(one).state();
    std::vector<double> values;
    each_number<D>(moving, [&](double& x) { values.push_back(x); });
    fill(*numbers, values);
    return numbers->N();
  });
}

long set_state(Stack, KN<double>* numbers) {
  return with([&]<int D>(Kept<D>& one) -> long {
    auto moving = body_of(one).state();
    long count = 0;
    each_number<D>(moving, [&](double& x) {
      if (count < numbers->N()) x = (*numbers)[count];
      ++count;
    });
    if (count != numbers->N()) throw std::runtime_error("a state of another number of points");
    body_of(one).set_state(std::move(moving));
    return count;
  });
}

}  // namespace

void add_material_points() {
  add("mpmBoxGrid", box);
  add("mpmTriangleGrid", triangles);
  add("mpmGridNodes", grid_nodes);
  add("mpmBody", body);
  add("mpmPoints", points);
  add("mpmBoundary", boundary);
  add("mpmHold", hold);
  add("mpmForces", forces);
  add("mpmStep", step);
  add("mpmSystem", system);
  add("mpmFinish", finish);
  add("mpmInterface", interface);
  add("mpmKineticEnergy", kinetic);
  add("mpmElasticEnergy", elastic);
  add("mpmInterfaceMass", interface_mass);
  add("mpmSave", save);
  add("mpmRestore", restore);
  add("mpmState", state);
  add("mpmSetState", set_state);
}

}  // namespace sandglass::freefem
