#pragma once

#include <nlohmann/json_fwd.hpp>

#include "render/value.hpp"
#include "report/result.hpp"

/// The sections of the page as values for templates/report/report.html. JSON may lack anything:
/// what is not there is not shown.
namespace sandglass::report {

/// "class" (good, bad, calm), "sign", "sentence".
struct Banner {
  std::string colour;
  std::string sign;
  std::string sentence;
};
Banner banner_of(const Result& result);

Value::List comparison_rows(const Result& result);
Value::List quantity_rows(const Result& result);
/// Of a study's points.json: one sentence on all of them (or empty), and a row each.
std::string points_summary(const nlohmann::ordered_json& study);
Value::List point_rows(const nlohmann::ordered_json& study);
Value::List parameter_rows(const nlohmann::ordered_json& workflow);
/// "wall time 4.2 s, 30 windows, ..." : one sentence, or empty.
std::string time_summary(const Result& result);
Value::List time_rows(const Result& result, const nlohmann::ordered_json& provenance);
Value::List saving_rows(const Result& result);
Value::List note_rows(const Result& result);
/// The lines of the provenance's summary: name and text.
Value::List provenance_facts(const nlohmann::ordered_json& provenance);
/// The tables behind it: solvers, scripts, templates, data, environment.
Value::List provenance_tables(const nlohmann::ordered_json& provenance);

/// The text at object[key], or empty when there is none.
std::string text_at(const nlohmann::ordered_json& object, const char* key);

}  // namespace sandglass::report
