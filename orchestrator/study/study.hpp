#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "run/home.hpp"
#include "run/status.hpp"
#include "study/executor.hpp"
#include "study/points.hpp"
#include "workflow/model.hpp"

namespace sandglass::study {

struct Options {
  std::string file;            ///< the study
  workflow::LoadOptions load;  ///< settings and what to keep, for all points
  std::string out;             ///< its folder; empty: `runs`/NAME, found again by the next call
  std::string runs = "runs";
  int jobs = 0;        ///< runs at a time; 0: as many as there are cores (Slurm: as it likes)
  bool slurm = false;  ///< by a cluster's scheduler instead of here
  bool again = false;  ///< run all points, also those that are there
  std::vector<std::string> command;  ///< the command line, for the provenance
};

/// A point that did not end as the study expects, or whose comparisons failed.
struct Blemish {
  std::string point;
  std::string error;
};

/// How a call ended.
struct Ended {
  ExitCode code = ExitCode::done;
  std::string directory;
  std::string report;            ///< of the summary; empty when there is none
  std::string error;             ///< of the summary; empty when all is well
  std::size_t points = 0;        ///< all
  std::size_t reused = 0;        ///< were there already
  std::size_t twins = 0;         ///< resolve to the same workflow as another one
  bool unchanged = false;        ///< nothing to do at all
  std::vector<Blemish> failed;   ///< not as expected
  std::vector<Blemish> outside;  ///< as expected, but out of tolerance
};

/// Runs what is not there yet, then the study's own stages and comparisons over all points. A bad
/// point costs one point: ExitCode::participant when any ended otherwise than expected, else that
/// of the summary, else ExitCode::mismatch for points out of tolerance where the study judges them.
/// Throws Error::refused, Error::usage for what is wrong with the file, Error::interrupted when the
/// user interrupts; the next call goes on.
Ended execute(const Options& options, const run::Home& home, const Listener& listener,
              run::Status& status);

/// Why a point would be run.
struct Reason {
  std::string point;
  std::vector<std::string> lines;  ///< empty: it would not
};

/// The reasons of every point, in order; nothing is run or changed. Twins are not listed.
std::vector<Reason> why(const Options& options, const run::Home& home);

/// Something that points of a study do not need, as workflow::LeftOut.
struct LeftOut {
  std::string name, what, why;
  std::size_t points = 0;    ///< that leave it out
  std::size_t measured = 0;  ///< of those, the ones whose runs have measured what it saves
  double saved = 0;          ///< s, in these runs together
};

/// What a call would do.
struct Plan {
  std::size_t points = 0;
  std::size_t twins = 0;        ///< resolve to the same workflow as another one
  std::vector<Reason> reasons;  ///< as why()
  std::vector<LeftOut> left_out;
};
Plan plan(const Options& options, const run::Home& home);

}  // namespace sandglass::study
