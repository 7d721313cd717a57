#include <cmath>
#include <random>
#include <sstream>

#include "base/clock.hpp"
#include "base/file.hpp"
#include "bench/bench.hpp"
#include "bench/loaded.hpp"
#include "exchange/mapping.hpp"
#include "run/scripts.hpp"
#include "run/stage.hpp"

namespace sandglass::bench {

ImpactTimes impact(const run::Home& home, const std::string& folder, const std::string& continuum,
                   std::int64_t windows) {
  workflow::Workflow scene =
      loaded(home, home.root + "/workflows/beam_single_impact.yaml", {{"continuum", continuum}});
  scene.coupling->windows = windows;
  const WindowEnds measured = window_ends(home, scene, folder);
  return {measured.ends.back() - measured.begin, measured.ends.back() - measured.ends.front(),
          measured.overhead, measured.processor};
}

double impact_alone(const run::Home& home, const std::string& folder, std::int64_t windows) {
  const workflow::Workflow alone = loaded(home, home.templates() + "/bench/impact_alone.yaml",
                                          {{"windows", std::to_string(windows)}});
  const auto directory = record::RunDirectory::create({}, folder, alone.name);
  run::Scripts scripts(home.templates(), directory.folder("scripts"));
  run::run_stage(alone.stages.at(0), home, directory, scripts);
  double seconds = 0;
  std::istringstream(read_file(directory.path() + "/stages/impact/impact.txt")) >> seconds;
  return seconds;
}

MappingTimes mapping(std::int64_t points, bool linear) {
  // Squares of a unit square, each cut into two triangles.
  constexpr int side = 300;
  exchange::Interface surface{3, {}, 3, {}};
  for (int i = 0; i <= side; ++i) {
    for (int j = 0; j <= side; ++j) {
      surface.points.insert(surface.points.end(), {1.0 * i / side, 1.0 * j / side, 0.0});
      if (i == side || j == side) continue;
      const std::int64_t a = i * (side + 1) + j;
      const std::int64_t b = a + side + 1;
      surface.cells.insert(surface.cells.end(), {a, b, a + 1, b, b + 1, a + 1});
    }
  }
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> anywhere(0, 1);
  std::vector<double> others(static_cast<std::size_t>(3 * points), 0.0);
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (i % 3 != 2) others[i] = anywhere(random);
  }
  const std::vector<double> values(surface.points.size(), 1.0);
  const SystemClock clock;
  const double start = clock.now();
  const exchange::Mapping made(
      linear ? exchange::MappingMethod::linear : exchange::MappingMethod::nearest, surface, others,
      0.1);
  const double ready = clock.now();
  const double once = made.consistent(values, 3).at(0);  // used, so that it is not left out
  return {ready - start, clock.now() - ready + 0 * once};
}

}  // namespace sandglass::bench
