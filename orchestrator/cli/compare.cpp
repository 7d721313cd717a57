#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "study/contrast.hpp"

namespace sandglass::cli {
namespace {

void show(const std::string& title, const std::vector<study::Difference>& differences,
          const std::string& same) {
  fmt::print("{}{}\n", title, differences.empty() ? ": " + same : std::string());
  for (const study::Difference& one : differences) {
    fmt::print("  {}: {} | {}{}\n", one.what, one.left, one.right,
               one.size.empty() ? "" : " (" + one.size + ")");
  }
}

ExitCode execute(const std::string& left, const std::string& right) {
  const study::Contrast contrast = study::contrast(left, right);
  fmt::print("{} | {}\n", left, right);
  show("Inputs", contrast.inputs, "all the same");
  show("Quantities", contrast.quantities, fmt::format("all {} the same", contrast.same_quantities));
  if (!contrast.quantities.empty()) {
    fmt::print("  the same: {}\n", contrast.same_quantities);
  }
  show("Curves", contrast.curves, fmt::format("all {} the same", contrast.same_curves));
  return ExitCode::done;
}

}  // namespace

void add_compare(CLI::App& app, Session& session) {
  auto paths = std::make_shared<std::vector<std::string>>();
  CLI::App* verb =
      add_verb(app, "compare", "put two runs or studies side by side: inputs, quantities, curves",
               "  sandglass compare runs/icy_stokes_sphere-0001 runs/icy_stokes_sphere-0002\n"
               "  sandglass compare runs/icy_stokes_stability runs/with_other_solvers");
  verb->add_option("runs", *paths, "two run directories, or the folders of two studies")
      ->required()
      ->expected(2)
      ->type_name("A B");
  verb->callback([&session, paths] {
    session.action = [paths] { return execute(paths->at(0), paths->at(1)); };
  });
}

}  // namespace sandglass::cli
