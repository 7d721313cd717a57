#include "run/savings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.hpp"
#include "base/file.hpp"
#include "workflow/json.hpp"

namespace sandglass::run {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string microseconds(double seconds) { return fmt::format("{:.3g} us", 1e6 * seconds); }

/// The values of all parameters: only runs with the same ones take comparable times.
Json values_of(const Json& workflow) {
  Json values = Json::object();
  for (const auto& [name, parameter] : workflow.at("parameters").items()) {
    values[name] = parameter.at("value");
  }
  return values;
}

/// What one earlier run tells.
void add_run(const Json& workflow, const Json& result, const Json& provenance,
             std::map<std::string, MeasuredSaving>& savings) {
  const double windows = result.at("windows").get<double>();
  double work = 0;
  for (const auto& [name, seconds] : provenance.at("timings").at("participants").items()) {
    work += seconds.get<double>();
  }
  if (windows < 1) return;
  const double per_window = work / windows;
  for (const Json& item : workflow.at("left_out")) {
    MeasuredSaving& saving = savings[item.at("name").get<std::string>()];
    const bool left_out = item.at("active").get<bool>();
    int& runs = left_out ? saving.runs_without : saving.runs_with;
    double& least = left_out ? saving.seconds_without : saving.seconds_with;
    least = runs == 0 ? per_window : std::min(least, per_window);
    ++runs;
  }
  for (const Json& item : result.at("left_out")) {
    if (!item.contains("name") || !item.contains("saving_s")) continue;
    savings[item.at("name").get<std::string>()].by_itself = item.at("saving_s").get<double>();
  }
}

}  // namespace

std::string MeasuredSaving::text() const {
  if (by_itself) return fmt::format("saved {:.3g} s in the newest run", *by_itself);
  if (runs_with > 0 && runs_without > 0) {
    return fmt::format("saves {} of {} of the solvers' work per window ({} runs without, {} with)",
                       microseconds(seconds_with - seconds_without), microseconds(seconds_with),
                       runs_without, runs_with);
  }
  return "saving unknown: no earlier run here has measured it";
}

std::map<std::string, MeasuredSaving> measured_savings(const workflow::Workflow& workflow,
                                                       const std::string& runs) {
  std::map<std::string, MeasuredSaving> savings;
  if (!fs::is_directory(runs)) return savings;
  const Json ours = Json(workflow::to_json(workflow));
  std::vector<std::string> folders;
  for (const auto& entry : fs::directory_iterator(runs)) folders.push_back(entry.path().string());
  std::sort(folders.begin(), folders.end());
  for (const std::string& folder : folders) {
    if (!fs::exists(folder + "/provenance.json")) continue;
    try {
      const Json theirs = Json::parse(read_file(folder + "/workflow.json"));
      if (theirs.at("name") != ours.at("name") || values_of(theirs) != values_of(ours)) continue;
      add_run(theirs, Json::parse(read_file(folder + "/result.json")),
              Json::parse(read_file(folder + "/provenance.json")), savings);
    } catch (const Json::exception&) {
      continue;  // of another version, or cut off
    } catch (const Error&) {
      continue;
    }
  }
  return savings;
}

}  // namespace sandglass::run
