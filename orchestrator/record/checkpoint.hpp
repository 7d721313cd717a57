#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "record/run_directory.hpp"

namespace sandglass::record {

/// The coupling's own part of a checkpoint.
struct CouplingState {
  double elapsed = 0;  ///< s of work until then, earlier parts of a resumed run included
  std::map<std::string, std::vector<double>> arrays;  ///< coupling::Memory
};

/// The windows of a run that have a checkpoint, ascending.
std::vector<std::int64_t> windows_with_checkpoint(const std::string& run_directory);

/// The checkpoints of a run: folders checkpoints/NNNNNNNNN, one per window behind which the run can
/// go on, each with one file or folder per participant that has a state, and coupling.h5.
///
/// A checkpoint is made under another name and flushed to the disk before it gets its own: whoever
/// looks, after a kill or a power cut too, finds it whole or not at all.
class Checkpoints {
 public:
  explicit Checkpoints(const RunDirectory& directory);

  /// The windows that have one, ascending.
  [[nodiscard]] std::vector<std::int64_t> windows() const;
  /// The newest one at or before this window.
  [[nodiscard]] std::optional<std::int64_t> newest(std::int64_t until) const;
  /// Where the state of a participant is.
  [[nodiscard]] std::string state_of(std::int64_t window, const std::string& participant) const;
  /// Throws Error::environment when it cannot be read.
  [[nodiscard]] CouplingState coupling_state(std::int64_t window) const;

  /// Begins the checkpoint behind this window. Returns the folder that participants write into.
  [[nodiscard]] std::string begin(std::int64_t window) const;
  /// Adds the coupling's state and makes the checkpoint count. The record must be flushed before.
  void complete(std::int64_t window, const CouplingState& state) const;
  /// Removes all but the newest `count` ones.
  void keep(std::int64_t count) const;
  /// Removes those behind this window, and unfinished ones.
  void drop_behind(std::int64_t window) const;

 private:
  [[nodiscard]] std::string path(std::int64_t window) const;
  std::string folder_;
};

}  // namespace sandglass::record
