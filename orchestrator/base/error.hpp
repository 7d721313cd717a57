#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace sandglass {

/// The process exit status of every verb. Stable: scripts and studies depend on the numbers.
enum class ExitCode : int {
  done = 0,          ///< finished, and every comparison within its tolerance
  usage = 2,         ///< the command line is wrong
  refused = 3,       ///< the workflow (or a template it uses) is wrong; no solver was started
  participant = 4,   ///< a participant failed, timed out, or sent an array of the wrong shape
  unstable = 5,      ///< numerically unstable, or a non-finite value in an exchanged field
  mismatch = 6,      ///< a comparison out of tolerance, or a check that found a difference
  environment = 7,   ///< missing solver, disk full, directory not writable, in use, or already used
  interrupted = 130  ///< ended by the user
};

/// A place in a text file. Lines and columns count from 1; 0 means "not known".
struct Place {
  std::string file;
  int line = 0;
  int column = 0;

  /// "file:line:column", leaving out what is not known.
  [[nodiscard]] std::string text() const;
};

/// One thing that is wrong: where, what, what to do about it, and what else helps to see why.
struct Problem {
  Place place;
  std::string what;
  std::string remedy;
  std::string detail;  ///< lines of their own, such as the end of a log

  /// "file:line:column: what; remedy", with the detail on the lines below.
  [[nodiscard]] std::string text() const;
};

/// The one exception type of the program. It carries the exit code and one or more problems, each
/// saying what is wrong, where, and what to do. Built by the named constructors below only.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, std::vector<Problem> problems);

  static Error usage(std::string what, std::string remedy = {});
  static Error refused(Place place, std::string what, std::string remedy = {});
  static Error refused(std::vector<Problem> problems);
  static Error participant(std::string what, std::string remedy = {}, std::string detail = {});
  static Error unstable(std::string what, std::string remedy = {}, std::string detail = {});
  static Error mismatch(std::string what, std::string remedy = {});
  static Error environment(std::string what, std::string remedy = {});
  static Error interrupted(std::string what);

  [[nodiscard]] ExitCode code() const { return code_; }
  [[nodiscard]] const std::vector<Problem>& problems() const { return problems_; }

 private:
  ExitCode code_;
  std::vector<Problem> problems_;
};

/// The candidate nearest to `name` by edit distance, or empty when none is near enough to suggest.
std::string nearest(const std::string& name, const std::vector<std::string>& candidates);

/// "did you mean 'x'?" for the nearest candidate; else "valid: a, b, c".
std::string suggestion(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace sandglass
