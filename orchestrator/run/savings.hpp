#pragma once

#include <map>
#include <optional>
#include <string>

#include "workflow/model.hpp"

namespace sandglass::run {

/// What earlier runs of the same workflow with the same parameters tell about one thing that is
/// left out.
struct MeasuredSaving {
  std::optional<double> by_itself;  ///< s in the newest run, as its participant measured it
  int runs_with = 0;                ///< runs that put it back
  int runs_without = 0;             ///< runs that left it out
  double seconds_with = 0;          ///< least work of the participants per window, s
  double seconds_without = 0;

  /// One sentence: "saved 1.2 ms in all", "saves 40 us of 95 us per window (...)", "unknown ...".
  [[nodiscard]] std::string text() const;
};

/// By name of what is left out, from the run directories below `runs`. Runs that cannot be read are
/// passed over.
std::map<std::string, MeasuredSaving> measured_savings(const workflow::Workflow& workflow,
                                                       const std::string& runs);

}  // namespace sandglass::run
