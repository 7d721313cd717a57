#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "study/directory.hpp"

namespace sandglass::study {

/// One row of a study's table: a point and how its run ended.
struct Row {
  const Point* point = nullptr;
  std::string run;  ///< name of the point whose run it is
  Outcome outcome;
  nlohmann::ordered_json parameters;  ///< name: SI value, as resolved for this point
};

/// The table as analysis stages read it, format 1:
///   {"format": 1, "points": [{"name", "set", "label", "sample_of", "repetition", "expect",
///     "run" (its run directory, relative to the summary's), "status", "exit_code", "good",
///     "error", "windows", "parameters": {NAME: SI value}, "seconds": {"run", "start", "report",
///     "orchestrator", STAGE.., PARTICIPANT..}, "load" (of the machine at its end), "quantities":
///     {NAME: value}, "notes": [text]}]}
/// Of a point without a result there are only the first seven, and "good": false.
std::string table_to_json(const std::vector<Row>& rows, const StudyDirectory& directory);

/// The same for people and spreadsheets: one line a point; quantities that are lists are left out.
std::string table_to_csv(const std::vector<Row>& rows);

}  // namespace sandglass::study
