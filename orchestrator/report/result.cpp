#include "report/result.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/file.hpp"

namespace sandglass::report {
namespace {

using json = nlohmann::ordered_json;

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json value_to_json(const Value& value) {
  if (const double* real = value.as<double>()) return number(*real);
  if (const std::int64_t* count = value.as<std::int64_t>()) return *count;
  if (const Value::List* list = value.as<Value::List>()) {
    json all = json::array();
    for (const Value& item : *list) all.push_back(value_to_json(item));
    return all;
  }
  return nullptr;
}

Value value_from_json(const json& value) {
  if (value.is_number()) return value.get<double>();
  if (!value.is_array()) return {};
  Value::List all;
  for (const json& item : value) all.push_back(value_from_json(item));
  return all;
}

void put_text(json& object, const char* key, const std::string& text) {
  if (!text.empty()) object[key] = text;
}

void put_number(json& object, const char* key, const std::optional<double>& value) {
  if (value) object[key] = number(*value);
}

std::string text_at(const json& object, const char* key) {
  return object.contains(key) ? object.at(key).get<std::string>() : std::string();
}

/// null stands for "not known".
std::optional<double> known_number_at(const json& object, const char* key) {
  if (!object.contains(key) || object.at(key).is_null()) return {};
  return object.at(key).get<double>();
}

/// null stands for a number that was not finite.
std::optional<double> number_at(const json& object, const char* key) {
  if (!object.contains(key)) return {};
  if (object.at(key).is_null()) return std::numeric_limits<double>::quiet_NaN();
  return object.at(key).get<double>();
}

json comparison_to_json(const ComparisonResult& comparison) {
  json object;
  object["name"] = comparison.name;
  object["metric"] = comparison.metric;
  put_number(object, "value", comparison.value);
  object["tolerance"] = number(comparison.tolerance);
  object["passed"] = comparison.passed ? json(*comparison.passed) : json(nullptr);
  put_text(object, "skipped", comparison.skipped);
  put_number(object, "reference", comparison.reference);
  put_number(object, "ours", comparison.ours);
  put_text(object, "subject", comparison.subject);
  put_text(object, "against", comparison.against);
  put_text(object, "unit", comparison.unit);
  put_text(object, "shown_in", comparison.shown_in);
  put_text(object, "because", comparison.because);
  put_text(object, "source", comparison.source);
  if (comparison.points) {
    object["points"] = *comparison.points;
    object["range"] = {number(comparison.from), number(comparison.to)};
  }
  return object;
}

ComparisonResult comparison_from_json(const json& object) {
  ComparisonResult comparison;
  comparison.name = object.at("name").get<std::string>();
  comparison.metric = text_at(object, "metric");
  comparison.value = number_at(object, "value");
  comparison.tolerance =
      number_at(object, "tolerance").value_or(std::numeric_limits<double>::quiet_NaN());
  if (!object.at("passed").is_null()) comparison.passed = object.at("passed").get<bool>();
  comparison.skipped = text_at(object, "skipped");
  comparison.reference = number_at(object, "reference");
  comparison.ours = number_at(object, "ours");
  comparison.subject = text_at(object, "subject");
  comparison.against = text_at(object, "against");
  comparison.unit = text_at(object, "unit");
  comparison.shown_in = text_at(object, "shown_in");
  comparison.because = text_at(object, "because");
  comparison.source = text_at(object, "source");
  if (object.contains("points")) {
    comparison.points = object.at("points").get<std::int64_t>();
    comparison.from = object.at("range").at(0).get<double>();
    comparison.to = object.at("range").at(1).get<double>();
  }
  return comparison;
}

}  // namespace

std::string status_name(ExitCode code) {
  switch (code) {
    case ExitCode::done:
      return "done";
    case ExitCode::usage:
      return "usage";
    case ExitCode::refused:
      return "refused";
    case ExitCode::participant:
      return "failed";
    case ExitCode::unstable:
      return "unstable";
    case ExitCode::mismatch:
      return "mismatch";
    case ExitCode::environment:
      return "environment";
    case ExitCode::interrupted:
      return "interrupted";
  }
  return "failed";
}

void add_analysis(Result& result, const Analysis& analysis) {
  for (const auto& [name, computed] : analysis.quantities) {
    result.quantities[name] = {computed.value, computed.unit, computed.meaning};
  }
  for (const auto& [name, curve] : analysis.curves) {
    if (!curve.file.empty()) result.curves[name] = "stages/" + curve.stage + "/" + curve.file;
  }
}

std::string to_json(const Result& result) {
  json document;
  document["format"] = 1;
  document["status"] = result.status;
  document["exit_code"] = result.exit_code;
  put_text(document, "error", result.error);
  document["wall_time_s"] = nullptr;  // these two are always there
  put_number(document, "wall_time_s", result.wall_time_s);
  document["windows"] = result.windows;
  document["overhead_s_per_window"] = nullptr;
  put_number(document, "overhead_s_per_window", result.overhead_s_per_window);
  json& quantities = document["quantities"] = json::object();
  for (const auto& [name, quantity] : result.quantities) {
    quantities[name] = {{"value", value_to_json(quantity.value)}, {"unit", quantity.unit}};
    put_text(quantities[name], "meaning", quantity.meaning);
  }
  json& comparisons = document["comparisons"] = json::array();
  for (const ComparisonResult& one : result.comparisons) {
    comparisons.push_back(comparison_to_json(one));
  }
  json& left_out = document["left_out"] = json::array();
  for (const Saving& saving : result.left_out) {
    json object = {{"name", saving.name}, {"what", saving.what}, {"why", saving.why}};
    put_number(object, "saving_s", saving.saving_s);
    left_out.push_back(std::move(object));
  }
  if (!result.notes.empty()) {
    json& notes = document["notes"] = json::array();
    for (const Note& note : result.notes) {
      notes.push_back({{"from", note.from}, {"text", note.text}});
    }
  }
  document["curves"] = json::object();
  for (const auto& [name, file] : result.curves) document["curves"][name] = file;
  // Text of a participant's log may hold bytes that are not UTF-8: they are shown as U+FFFD.
  return document.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

Result result_from_json(const std::string& text, const std::string& path) {
  try {
    const json document = json::parse(text);
    if (document.at("format") != 1) {
      throw Error::environment(fmt::format("'{}' has format {}, which this program does not know",
                                           path, document.at("format").dump()));
    }
    Result result;
    result.status = document.at("status").get<std::string>();
    result.exit_code = document.at("exit_code").get<int>();
    result.error = text_at(document, "error");
    result.wall_time_s = known_number_at(document, "wall_time_s");
    result.windows = document.at("windows").get<std::int64_t>();
    result.overhead_s_per_window = known_number_at(document, "overhead_s_per_window");
    for (const auto& [name, object] : document.at("quantities").items()) {
      result.quantities[name] = {value_from_json(object.at("value")), text_at(object, "unit"),
                                 text_at(object, "meaning")};
    }
    for (const json& object : document.at("comparisons")) {
      result.comparisons.push_back(comparison_from_json(object));
    }
    for (const json& object : document.at("left_out")) {
      result.left_out.push_back({text_at(object, "name"), text_at(object, "what"),
                                 text_at(object, "why"), number_at(object, "saving_s")});
    }
    const json notes = document.value("notes", json::array());
    for (const json& object : notes) {
      result.notes.push_back({text_at(object, "from"), text_at(object, "text")});
    }
    const json curves = document.value("curves", json::object());
    for (const auto& [name, file] : curves.items()) {
      result.curves[name] = file.get<std::string>();
    }
    return result;
  } catch (const json::exception& error) {
    throw Error::environment(fmt::format("'{}' is not a result of a run: {}", path, error.what()),
                             "run the workflow again");
  }
}

void write_result(const Result& result, const std::string& run_directory) {
  write_file(run_directory + "/result.json", to_json(result));
}

Result read_result(const std::string& run_directory) {
  const std::string path = run_directory + "/result.json";
  return result_from_json(read_file(path), path);
}

}  // namespace sandglass::report
