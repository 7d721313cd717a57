#pragma once

#include <span>
#include <string>
#include <vector>

#include "run/home.hpp"
#include "workflow/model.hpp"

namespace sandglass::bench {

workflow::Workflow loaded(const run::Home& home, const std::string& path,
                          const std::vector<workflow::Setting>& settings,
                          const std::vector<std::string>& put_back = {});

/// When the windows of a coupling ended.
struct WindowEnds {
  double begin = 0;  ///< s, before anything was started
  std::vector<double> ends;
  double overhead = 0;   ///< s per window in which no participant worked
  double processor = 0;  ///< s per window of this program's own, behind the first one
};
/// Runs the workflow's coupling, and nothing else of it, in a new run directory below `folder`.
WindowEnds window_ends(const run::Home& home, const workflow::Workflow& workflow,
                       const std::string& folder);

std::vector<double> differences(std::span<const double> times);

}  // namespace sandglass::bench
