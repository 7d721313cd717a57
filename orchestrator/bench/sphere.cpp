#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "base/file.hpp"
#include "bench/bench.hpp"
#include "bench/loaded.hpp"
#include "process/process.hpp"

namespace sandglass::bench {

SphereTimes sphere(const run::Home& home, const std::string& folder, bool fresh,
                   std::int64_t windows) {
  workflow::Workflow scene = loaded(home, home.root + "/workflows/icy_stokes_sphere.yaml",
                                    {{"process", fresh ? "fresh" : "resident"}});
  scene.coupling->windows = windows + 1;
  const WindowEnds measured = window_ends(home, scene, folder);
  return {measured.ends.at(0) - measured.begin, spread_of(differences(measured.ends))};
}

std::vector<PutBack> sphere_with_put_back(const run::Home& home, const std::string& folder,
                                          std::int64_t windows) {
  const std::string path = home.root + "/workflows/icy_stokes_sphere.yaml";
  // Windows with a solve in each take some thousand times as long: a few tell as much.
  const std::int64_t few = std::min<std::int64_t>(windows, 20);
  const auto measure = [&](const std::vector<std::string>& put_back) {
    workflow::Workflow scene = loaded(home, path, {}, put_back);
    scene.coupling->windows = (put_back.size() > 1 ? few : windows) + 1;
    return spread_of(differences(window_ends(home, scene, folder).ends));
  };
  std::vector<PutBack> all{{"", measure({})}};
  const workflow::Workflow scene = loaded(home, path, {});
  for (const workflow::LeftOut& one : scene.left_out) {
    // A participant that is not asked again cannot do again what it is asked for.
    std::vector<std::string> names{one.name};
    for (const workflow::LeftOut& other : scene.left_out) {
      if (!one.unchanged_inputs && other.of == one.of && other.unchanged_inputs) {
        names.push_back(other.name);
      }
    }
    all.push_back({fmt::format("{}", fmt::join(names, " and ")), measure(names)});
  }
  for (const std::string& field : scene.coupling->fields_left_out) {
    all.push_back({field, measure({field})});
  }
  return all;
}

Spread polled_sphere(const run::Home& home, const std::string& folder, std::int64_t windows,
                     double interval) {
  Command command;
  command.arguments = {"/usr/bin/python3", home.templates() + "/bench/polling.py",
                       fmt::format("{}", windows), fmt::format("{}", interval)};
  command.directory = folder + "/polling";
  command.log = folder + "/polling.log";
  make_directories(command.directory);
  constexpr double deadline = 600;
  run_to_end("the stand-in for ICY", command, deadline);
  std::istringstream lines(read_file(command.log));
  std::vector<double> seconds;
  for (double one = 0; lines >> one;) seconds.push_back(one);
  return spread_of(std::move(seconds));
}

}  // namespace sandglass::bench
