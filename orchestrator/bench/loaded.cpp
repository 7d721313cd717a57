#include "bench/loaded.hpp"

#include "base/clock.hpp"
#include "run/coupled_stage.hpp"

namespace sandglass::bench {

workflow::Workflow loaded(const run::Home& home, const std::string& path,
                          const std::vector<workflow::Setting>& settings,
                          const std::vector<std::string>& put_back) {
  workflow::LoadOptions options;
  options.templates_root = home.templates();
  options.data_root = home.data();
  options.settings = settings;
  options.keep = put_back;
  return workflow::load(path, options);
}

WindowEnds window_ends(const run::Home& home, const workflow::Workflow& workflow,
                       const std::string& folder) {
  const auto directory = record::RunDirectory::create({}, folder, workflow.name);
  run::Scripts scripts(home.templates(), directory.folder("scripts"));
  run::CoupledOutcome outcome;
  const SystemClock clock;
  WindowEnds result;
  result.ends.reserve(static_cast<std::size_t>(workflow.coupling->windows));
  result.begin = clock.now();
  run::run_coupling(workflow, home, directory, scripts, run::Span{}, outcome,
                    [&](std::int64_t, double) { result.ends.push_back(clock.now()); });
  result.overhead = outcome.overhead_per_window();
  return result;
}

std::vector<double> differences(std::span<const double> times) {
  std::vector<double> result;
  for (std::size_t i = 1; i < times.size(); ++i) result.push_back(times[i] - times[i - 1]);
  return result;
}

}  // namespace sandglass::bench
