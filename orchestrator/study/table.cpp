#include "study/table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/unit.hpp"

namespace sandglass::study {
namespace {

using Json = nlohmann::ordered_json;

Json read_json(const std::string& path) {
  try {
    return Json::parse(read_file(path));
  } catch (const Json::exception&) {
    return Json::object();
  } catch (const Error&) {
    return Json::object();
  }
}

Json seconds_of(const Json& provenance, const report::Result& result) {
  Json seconds = Json::object();
  if (result.wall_time_s) seconds["run"] = *result.wall_time_s;
  if (!provenance.contains("timings")) return seconds;
  const Json& timings = provenance.at("timings");
  for (const char* one : {"start", "report", "orchestrator"}) {
    if (timings.contains(one)) seconds[one] = timings.at(one);
  }
  for (const char* many : {"stages", "participants"}) {
    if (!timings.contains(many)) continue;
    for (const auto& [name, value] : timings.at(many).items()) seconds[name] = value;
  }
  // What another run had made already is not free: it counts as what making it took there.
  const Json made_before = timings.value("made_before", Json::object());
  for (const auto& [name, value] : made_before.items()) {
    const double made = value.get<double>();
    if (seconds.contains("run")) {
      seconds["run"] = seconds["run"].get<double>() + made - seconds.value(name, 0.0);
    }
    seconds[name] = made;
  }
  return seconds;
}

Json value_of(const Value& value) {
  if (const double* number = value.as<double>()) {
    return std::isfinite(*number) ? Json(*number) : Json(nullptr);
  }
  const Value::List* list = value.as<Value::List>();
  if (list == nullptr) return nullptr;
  Json all = Json::array();
  for (const Value& item : *list) all.push_back(value_of(item));
  return all;
}

Json row_to_json(const Row& row, const StudyDirectory& directory) {
  const Point& point = *row.point;
  Json one = {{"name", point.name},
              {"set", point.set},
              {"label", point.label},
              {"sample_of", point.sample_of},
              {"repetition", point.repetition},
              {"expect", point.unstable ? "unstable" : "done"},
              {"run", "../points/" + row.run},
              {"good", row.outcome.good(point)}};
  if (!row.outcome.result) return one;
  const report::Result& result = *row.outcome.result;
  const Json provenance = read_json(directory.run_of(row.run) + "/provenance.json");
  one["status"] = result.status;
  one["exit_code"] = result.exit_code;
  one["error"] = result.error;
  one["windows"] = result.windows;
  one["parameters"] = row.parameters;
  one["seconds"] = seconds_of(provenance, result);
  if (provenance.contains("host")) one["load"] = provenance.at("host").value("load", Json());
  one["quantities"] = Json::object();
  for (const auto& [name, quantity] : result.quantities) {
    one["quantities"][name] = value_of(quantity.value);
  }
  one["notes"] = Json::array();
  for (const report::Note& note : result.notes) one["notes"].push_back(note.text);
  return one;
}

/// Quoted where a spreadsheet would stumble.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

std::string table_to_json(const std::vector<Row>& rows, const StudyDirectory& directory) {
  Json points = Json::array();
  for (const Row& row : rows) points.push_back(row_to_json(row, directory));
  return Json{{"format", 1}, {"points", points}}.dump(1, ' ', false,
                                                      Json::error_handler_t::replace) +
         "\n";
}

std::string table_to_csv(const std::vector<Row>& rows) {
  std::set<std::string> settings;
  std::set<std::string> quantities;
  for (const Row& row : rows) {
    for (const workflow::Setting& one : row.point->settings) settings.insert(one.name);
    if (!row.outcome.result) continue;
    for (const auto& [name, quantity] : row.outcome.result->quantities) {
      if (quantity.value.as<double>() != nullptr) quantities.insert(name);
    }
  }
  std::string text = "point,set,status,windows,seconds";
  for (const std::string& name : settings) text += "," + name;
  for (const std::string& name : quantities) text += "," + name;
  text += "\n";
  for (const Row& row : rows) {
    const auto& result = row.outcome.result;
    text += cell(row.point->name) + "," + cell(row.point->set) + ",";
    text += result ? result->status : "left";
    text += fmt::format(",{},{}", result ? std::to_string(result->windows) : "",
                        result && result->wall_time_s ? shortest(*result->wall_time_s) : "");
    for (const std::string& name : settings) {
      const auto found = row.parameters.find(name);
      const bool there = found != row.parameters.end();
      text += "," + (there ? cell(found->is_string() ? found->get<std::string>() : found->dump())
                           : std::string());
    }
    for (const std::string& name : quantities) {
      text += ",";
      if (!result) continue;
      const auto found = result->quantities.find(name);
      if (found == result->quantities.end()) continue;
      const double* number = found->second.value.as<double>();
      if (number != nullptr) text += shortest(*number);
    }
    text += "\n";
  }
  return text;
}

}  // namespace sandglass::study
