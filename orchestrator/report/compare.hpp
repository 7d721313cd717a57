#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "report/analysis.hpp"
#include "workflow/model.hpp"

namespace sandglass::report {

/// How one comparison of the workflow came out. All numbers are SI.
struct ComparisonResult {
  std::string name;
  std::string metric;           ///< "relative difference", ...
  std::optional<double> value;  ///< the metric; absent when skipped; NaN never passes
  double tolerance = 0;
  std::optional<bool> passed;  ///< absent when skipped
  std::string skipped;         ///< why, when skipped
  std::optional<double> reference;
  std::optional<double> ours;
  std::string subject;   ///< the quantity or curve of ours
  std::string against;   ///< the quantity, curve or file it is compared with; empty for a number
  std::string unit;      ///< SI unit of reference and ours, and of value where it is not a ratio
  std::string shown_in;  ///< the unit that the workflow asks the report to show them in
  std::string because;   ///< where the tolerance comes from
  std::string source;    ///< where the reference was published
  // Curves only: how many points of ours lie in the common range of abscissae, and that range.
  std::optional<std::int64_t> points;
  double from = 0;
  double to = 0;
};

/// Makes every comparison of the workflow. A published reference whose conditions the run departs
/// from is skipped, and so is one whose quantity is not defined in this run. Throws
/// Error::participant for a quantity or curve that no analysis defines or that cannot be compared,
/// Error::environment for a reference file that cannot be read, Error::refused for one that is
/// malformed.
std::vector<ComparisonResult> compare(const workflow::Workflow& workflow, const Analysis& analysis,
                                      const std::string& data_root);

/// ExitCode::mismatch when a comparison did not pass, else ExitCode::done.
ExitCode verdict(const std::vector<ComparisonResult>& comparisons);

/// A curve as points (x ascending).
struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// A reference curve: a CSV file with '#' comment lines, one header row, and the columns x and y
/// first (others are not read). Values are SI, x ascends. Throws Error::refused with the place.
Points read_reference(const std::string& path);

/// Reads every reference file that the workflow's comparisons name, so that a broken one is found
/// before anything is run. Throws as read_reference does.
void check_references(const workflow::Workflow& workflow, const std::string& data_root);

/// The difference ours - reference at every point of ours inside the common range of abscissae,
/// the reference interpolated linearly.
struct Difference {
  std::vector<double> values;
  double from = 0;
  double to = 0;
};
Difference difference_of_curves(const Points& ours, const Points& reference);

}  // namespace sandglass::report
