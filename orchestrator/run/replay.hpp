#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "run/home.hpp"
#include "run/status.hpp"

namespace sandglass::run {

/// What came of repeating windows of a run.
struct Replayed {
  std::int64_t behind = 0;  ///< the checkpoint from which they were repeated; 0: the start
  std::int64_t first = 0;   ///< the windows that were compared
  std::int64_t last = 0;
  /// One dataset whose bytes are not those of the record.
  struct Difference {
    std::string dataset;
    std::int64_t window = 0;  ///< the first one that differs
    std::int64_t position = 0;
    double recorded = 0;
    double repeated = 0;
  };
  std::vector<Difference> differences;
  std::vector<std::string> datasets;  ///< that were compared
};

/// Repeats window `window` of the run in new processes, from its nearest checkpoint before it, or
/// from the start where there is none, and compares what is recorded, byte by byte; with `window` 0
/// all windows, from the start. Nothing in the run directory is changed. Throws
/// Error::environment when there is no such run or window, Error::refused when what the run was
/// made of has changed since, and what participants throw.
Replayed replay(const std::string& run_directory, std::int64_t window, const Home& home,
                Status& status);

}  // namespace sandglass::run
