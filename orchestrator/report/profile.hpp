#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::report {

/// Where the time of a run's coupling went, from its record (the columns /timings of every window)
/// and, where the run came to its end, provenance.json.
struct Profile {
  struct Row {
    std::string name;    ///< of the participant, or what was done
    double seconds = 0;  ///< in all windows
    bool aside = false;  ///< beside the windows: start-up, stages, checkpoints, report
  };
  std::int64_t windows = 0;
  double loop_seconds = 0;  ///< all windows together; participants that work at once overlap in it
  std::vector<Row> rows;
};

/// Throws Error::environment when there is no record, or one that cannot be understood.
Profile read_profile(const std::string& run_directory);

/// Writes a trace for ui.perfetto.dev or chrome://tracing: one line per participant and one for the
/// orchestrator, with each window's work, exchange, rendering, recording and waiting. The record
/// knows how long these took, not when: they are drawn one behind the other. Beyond some ten
/// thousand windows several share a slice. Throws Error::environment.
void write_trace(const std::string& run_directory, const std::string& path);

}  // namespace sandglass::report
