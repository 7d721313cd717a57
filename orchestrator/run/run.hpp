#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "record/run_directory.hpp"
#include "run/home.hpp"
#include "run/status.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

struct Options {
  std::string out;                   ///< run directory; empty: a new numbered one below `runs`
  std::string runs = "runs";         ///< where numbered run directories are made
  std::vector<std::string> command;  ///< the command line, for the provenance
  std::map<std::string, std::string> files;  ///< name and text, put into the run directory first
};

/// How a run ended. The same is in result.json.
struct Ended {
  ExitCode code = ExitCode::done;
  std::string error;                ///< empty when all went well
  std::string directory;            ///< of the run
  std::string report;               ///< path of report.html; empty when none could be made
  bool complete_before = false;     ///< there was nothing to resume
  std::int64_t went_on_behind = 0;  ///< this window, from its checkpoint; 0: from the start
};

/// Executes one workflow: stages in order, the coupling among them, comparisons, result, report.
/// A run that fails returns its error and leaves its record, logs and result.json behind; only what
/// stops a run directory from existing at all is thrown (Error::environment).
Ended execute(const workflow::Workflow& workflow, const Home& home, const Options& options,
              Status& status);

/// Goes on with a run that was killed, interrupted, or failed, from its newest checkpoint, or from
/// the start where there is none. Its record ends with the same bytes as that of an unbroken run,
/// as far as the solvers repeat bit by bit. A run that came to its end is left as it is.
/// Throws Error::environment when `directory` is no run directory or in use, Error::refused when
/// what the run was made of has changed since.
Ended resume(const std::string& directory, const Home& home, const Options& options,
             Status& status);

/// Runs the analysis stages on what the run in `directory` has recorded so far, and compares and
/// reports, all in a run directory of its own (`options.out`). The run is only read and may be
/// going on; the templates of its analyses may have changed. Throws Error::environment when
/// `directory` is no run directory or nothing is recorded.
Ended analyse(const std::string& directory, const Home& home, const Options& options,
              Status& status);

/// Renders every script of the workflow without storing or starting anything. Throws
/// Error::refused.
struct RenderedScript {
  std::string whose;
  std::string template_path;
  std::size_t bytes = 0;
};
std::vector<RenderedScript> dry_run(const workflow::Workflow& workflow, const Home& home);

}  // namespace sandglass::run
