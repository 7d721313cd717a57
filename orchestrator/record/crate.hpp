#pragma once

#include <map>
#include <string>
#include <vector>

namespace sandglass::record {

/// The name of the crate's description in a run directory.
inline constexpr const char* kCrateFile = "ro-crate-metadata.json";

/// Describes a run directory as a Workflow Run RO-Crate (Provenance Run Crate profile 0.5), from
/// what lies in it: the workflow as main entity with its parameters, the solvers, an action for the
/// run and one for each participant and checkpoint interval, every file with its SHA-256. Replaces
/// an older description. Throws Error::environment.
///
/// Profile: https://w3id.org/ro/wfrun/provenance/0.5
void write_crate(const std::string& run_directory);

/// Takes files that were made again (relative paths) into the crate that is there, and leaves the
/// digests of all others as they were. Throws Error::environment.
void refresh_crate(const std::string& run_directory, const std::vector<std::string>& files);

/// What verify found.
struct Verdict {
  std::size_t files = 0;  ///< looked at
  std::vector<std::string> altered;
  std::vector<std::string> missing;
  std::vector<std::string> added;
  /// Templates, data files and programs, outside of the run directory, that are not what the run
  /// used.
  std::vector<std::string> changed_since;
  std::string crate_digest;  ///< whoever keeps it elsewhere can trust the description itself

  [[nodiscard]] bool whole() const { return altered.empty() && missing.empty() && added.empty(); }
};

/// Compares every file of the run directory with its digest in the crate, and what the run used
/// from elsewhere with its digest in provenance.json; `project` is where templates/ and data/ are,
/// `build` where the FreeFEM plugin is.
/// Throws Error::environment when there is no crate, or one that cannot be understood.
Verdict verify(const std::string& run_directory, const std::string& project,
               const std::string& build);

}  // namespace sandglass::record
