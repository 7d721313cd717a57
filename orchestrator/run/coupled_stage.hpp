#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "participant/participant.hpp"
#include "record/run_directory.hpp"
#include "run/home.hpp"
#include "run/scripts.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// What the coupling leaves behind besides its record, whole or not.
struct CoupledOutcome {
  std::int64_t windows = 0;        ///< complete, all of them recorded
  std::int64_t windows_taken = 0;  ///< of those, the ones of earlier parts of a resumed run
  double elapsed_before = 0;       ///< s that the earlier parts took until their checkpoint
  double time = 0;                 ///< physical time reached, s
  double start_seconds = 0;        ///< until all participants were ready
  double loop_seconds = 0;         ///< all windows together
  std::map<std::string, double> participant_seconds;  ///< work in windows, by their own account
  std::map<std::string, double> peak_memory_bytes;
  double working_seconds = 0;  ///< of the loop, what it waited for participants' own work
  double exchange_seconds = 0;
  double record_seconds = 0;
  double checkpoint_seconds = 0;
  double render_seconds = 0;
  std::vector<std::string> notes;  ///< "fluid: ..."
  std::vector<participant::Saving> savings;

  /// Seconds per window that no participant worked.
  [[nodiscard]] double overhead_per_window() const;
};

/// Which of the windows are run.
struct Span {
  /// Go on behind this window, from its checkpoint below `checkpoints` and the record that is
  /// there; 0: from the start.
  std::int64_t behind = 0;
  const record::RunDirectory* checkpoints = nullptr;
  /// The last one, or 0 for the workflow's last.
  std::int64_t until = 0;
  bool keeps_record = true;  ///< false: the record begins behind `behind`, with nothing taken over
  double began = 0;          ///< when this process began the run, by SystemClock
};

/// Runs the workflow's coupling in this run directory. `outcome` is filled as far as the run came,
/// also when this throws; the record then holds every complete window.
void run_coupling(const workflow::Workflow& workflow, const Home& home,
                  const record::RunDirectory& directory, Scripts& scripts, const Span& span,
                  CoupledOutcome& outcome,
                  const std::function<void(std::int64_t window, double time)>& progress);

/// What the first `windows` windows of the record at `path` tell of the coupling that made them.
CoupledOutcome outcome_of_record(const workflow::Coupling& coupling, const std::string& path,
                                 std::int64_t windows);

}  // namespace sandglass::run
