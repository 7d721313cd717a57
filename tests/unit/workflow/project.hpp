#pragma once

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "../support/errors.hpp"
#include "../support/scratch.hpp"
#include "workflow/model.hpp"

namespace sandglass::workflow {

/// A folder with templates and data, and workflows loaded from memory as "w.yaml".
class Project {
 public:
  Project() {
    options.templates_root = scratch_.file("templates");
    options.data_root = scratch_.file("data");
    std::filesystem::create_directories(options.data_root + "/icy");
    write("templates/python/ball.py", "diameter = {{diameter}}\n");
    write("templates/python/empty.py", "pass\n");
    write("templates/yade/ball.py", "diameter = {{diameter}}\n");
    write("templates/yade/ball_window.py", "print({{window.index}}, {{density}})\n");
    write("templates/freefem/ball.edp", "real d = {{diameter}};\n");
    write("templates/freefem/mesh.edp", "mesh m = {{mesh}};\n");
    write("templates/gmsh/box.geo", "d = {{diameter}};\n");
    write("data/icy/figure_2.csv", "time,velocity\n0,0\n");
  }

  void write(const std::string& name, const std::string& text) const {
    const std::string path = scratch_.file(name);
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    std::ofstream(path) << text;
  }

  [[nodiscard]] Workflow load(const std::string& text) const {
    return load_text(text, "w.yaml", options);
  }
  [[nodiscard]] Workflow load(const std::string& text, const std::vector<Setting>& settings) const {
    LoadOptions changed = options;
    changed.settings = settings;
    return load_text(text, "w.yaml", changed);
  }

  /// "file:line:column: what" of every problem, in order; the remedies are tested where they
  /// matter.
  [[nodiscard]] std::vector<std::string> problems(const std::string& text,
                                                  const std::vector<Setting>& settings = {}) const {
    const Error error = test::error_of([&] { (void)load(text, settings); });
    std::vector<std::string> lines;
    for (const Problem& problem : error.problems()) {
      lines.push_back(problem.place.text() + ": " + problem.what);
    }
    return lines;
  }

  LoadOptions options;

 private:
  test::Scratch scratch_;
};

/// A head without faults; what is tested is appended. Its last line is line 4.
inline const std::string head = R"(sandglass: 1
name: test
parameters:
  diameter: {value: 0.1 mm, unit: mm, above: 0}
)";

/// A coupled workflow without faults.
inline const std::string coupled = R"(sandglass: 1
name: test
parameters:
  diameter: {value: 0.1 mm, unit: mm, above: 0}
  density: {value: 2650, unit: kg/m3}
  window: {value: 1 ms}
  end_time: {value: 30 ms}
  fluid: {value: plain, choices: [plain, meshed]}
stages:
  mesh:
    run: gmsh
    template: gmsh/box.geo
    given: [diameter]
    makes: [box.msh]
    when: {fluid: meshed}
  couple:
    run: coupling
  analyse:
    run: python
    template: python/ball.py
    given: [diameter]
    analysis: true
participants:
  grains:
    solver: yade
    template: yade/ball.py
    window_template: yade/ball_window.py
    given: [diameter, density]
  fluid:
    solver: freefem
    choose: fluid
    cases:
      plain: {template: freefem/ball.edp, given: [diameter]}
      meshed: {template: freefem/mesh.edp, given: {mesh: {file: mesh/box.msh}}}
coupling:
  window: $window
  end: $end_time
  order: [grains, fluid]
  fields:
    velocity: {unit: m/s, shape: [1], from: grains, to: fluid}
    drag: {unit: N, shape: [1], from: fluid, to: grains}
)";

/// The text with its only `from` replaced.
inline std::string changed(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  if (at == std::string::npos || text.find(from, at + 1) != std::string::npos) {
    ADD_FAILURE() << "not exactly once in the text: " << from;
    return text;
  }
  return text.replace(at, from.size(), to);
}

}  // namespace sandglass::workflow
