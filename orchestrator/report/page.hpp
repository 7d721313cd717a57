#pragma once

#include <string>
#include <vector>

#include "report/figures.hpp"

namespace sandglass::report {

/// Writes RUN_DIRECTORY/report.html, one self-contained page, and the figures it shows, from the
/// files of the run directory alone: result.json (needed), workflow.json, provenance.json and
/// stages/*/analysis.json (each optional). Returns what could not be shown and why, one sentence
/// each, as the page says too. Throws Error::environment when there is no result.json or the page
/// cannot be written, Error::interrupted when the user interrupts the drawing.
std::vector<std::string> write_report(const std::string& run_directory, const ReportTools& tools);

}  // namespace sandglass::report
