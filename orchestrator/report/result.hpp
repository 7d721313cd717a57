#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/value.hpp"
#include "report/analysis.hpp"
#include "report/compare.hpp"

namespace sandglass::report {

struct ResultQuantity {
  Value value;  ///< a number, a list (also of lists), or absent: not defined in this run
  std::string unit;
  std::string meaning;
};

/// Something that was not run or not sent, and what that saved.
struct Saving {
  std::string name;
  std::string what;
  std::string why;
  std::optional<double> saving_s;  ///< absent: not known
};

/// A line that a participant or a stage wants the reader to see.
struct Note {
  std::string from;
  std::string text;
};

/// How a run ended: the content of result.json (format 1).
struct Result {
  std::string status = "done";  ///< see status_name
  int exit_code = 0;
  std::string error;  ///< what went wrong; empty when nothing did
  std::optional<double> wall_time_s;
  std::int64_t windows = 0;  ///< windows done
  std::optional<double> overhead_s_per_window;
  std::map<std::string, ResultQuantity> quantities;
  std::vector<ComparisonResult> comparisons;
  std::vector<Saving> left_out;
  std::vector<Note> notes;
  std::map<std::string, std::string> curves;  ///< name: CSV file, relative to the run directory
};

/// "done", "usage", "refused", "failed", "unstable", "mismatch", "environment", "interrupted"
std::string status_name(ExitCode code);

/// Takes quantities and curves' files over from the analysis.
void add_analysis(Result& result, const Analysis& analysis);

/// The JSON text. Numbers that are not finite become null; what is not known is left out.
std::string to_json(const Result& result);
/// Throws Error::environment naming `path` when the text is not a result.json of format 1.
Result result_from_json(const std::string& text, const std::string& path);

/// RUN_DIRECTORY/result.json, written completely or not at all. Throws Error::environment.
void write_result(const Result& result, const std::string& run_directory);
/// Throws Error::environment when there is none or it cannot be understood.
Result read_result(const std::string& run_directory);

}  // namespace sandglass::report
