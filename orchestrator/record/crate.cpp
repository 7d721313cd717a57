#include "record/crate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "base/clock.hpp"
#include "base/file.hpp"
#include "hdf5/hdf5.hpp"
#include "record/crate_files.hpp"

namespace sandglass::record {
namespace {

using Json = nlohmann::ordered_json;

/// More than so many actions of one participant help nobody: longer intervals are described.
constexpr std::int64_t kMostIntervals = 1000;
constexpr const char* kWorkflow = "workflow.yaml";

Json reference(const std::string& id) { return {{"@id", id}}; }

Json references(const std::vector<std::string>& ids) {
  if (ids.size() == 1) return reference(ids[0]);
  Json list = Json::array();
  for (const std::string& id : ids) list.push_back(reference(id));
  return list;
}

/// A file of the run directory as JSON; an empty object when it is not there, or not whole.
Json read_json(const std::string& path) {
  std::error_code unseen;
  if (!std::filesystem::is_regular_file(path, unseen)) return Json::object();
  Json json = Json::parse(read_file(path), nullptr, false);
  return json.is_object() ? json : Json::object();
}

std::string text_of(const Json& crate) {
  return crate.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// Where a solver is at home; an action must name it by an address.
std::string address_of(const std::string& solver) {
  if (solver == "yade") return "https://yade-dem.org/";
  if (solver == "freefem") return "https://freefem.org/";
  if (solver == "gmsh") return "https://gmsh.info/";
  if (solver == "python") return "https://www.python.org/";
  if (solver == "lammps") return "https://www.lammps.org/";
  if (solver == "kratos") return "https://github.com/KratosMultiphysics/Kratos";
  return "urn:sandglass:" + solver;
}

std::string type_of(const std::string& parameter_type) {
  if (parameter_type == "count") return "Integer";
  if (parameter_type == "toggle") return "Boolean";
  return parameter_type == "number" ? "Float" : "Text";
}

std::string format_of(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".json") return "application/json";
  if (ending == ".yaml") return "application/yaml";
  if (ending == ".h5") return "application/x-hdf5";
  if (ending == ".html") return "text/html";
  if (ending == ".csv") return "text/csv";
  if (ending == ".png") return "image/png";
  if (ending == ".svg") return "image/svg+xml";
  if (ending == ".py") return "text/x-python";
  return ending == ".log" || ending == ".edp" || ending == ".geo" ? "text/plain"
                                                                  : "application/octet-stream";
}

class Crate {
 public:
  explicit Crate(const std::string& directory)
      : directory_(directory),
        workflow_(read_json(directory + "/workflow.json")),
        provenance_(read_json(directory + "/provenance.json")),
        result_(read_json(directory + "/result.json")),
        files_(files_of_crate(directory)) {
    for (const Json& script : list(provenance_, "scripts")) {
      const std::string path = script.value("path", "");
      digests_[path] = script.value("digest", "");
      const Windows windows = script.value("windows", Windows{});
      scripts_of_[script.value("participant", "")].push_back({id_of_path(path), windows});
    }
  }

  [[nodiscard]] Json build() {
    add_profiles();
    add_parameters();
    add_engine();
    for (const Json& stage : list(workflow_, "stages")) {
      if (stage.value("run", "") != "coupling") add_stage(stage);
    }
    for (const Json& participant : list(workflow_, "participants")) add_participant(participant);
    add_run();
    add_files();
    add_workflow();
    add_root();
    return {{"@context",
             {"https://w3id.org/ro/crate/1.1/context",
              "https://w3id.org/ro/terms/workflow-run/context"}},
            {"@graph", graph_}};
  }

 private:
  /// First and last window, of as many intervals as there are; none: all windows.
  using Windows = std::vector<std::pair<std::int64_t, std::int64_t>>;
  struct Script {
    std::string id;
    Windows windows;
    [[nodiscard]] bool used_in(std::int64_t first, std::int64_t last) const {
      return windows.empty() || std::any_of(windows.begin(), windows.end(), [&](const auto& one) {
               return one.first <= last && one.second >= first;
             });
    }
  };
  /// Begin and end of an action, in words.
  struct Times {
    std::string began, ended;
  };

  static Json list(const Json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_array() ? *found : Json::array();
  }

  [[nodiscard]] bool has(const std::string& file) const {
    return std::binary_search(files_.begin(), files_.end(), file);
  }

  /// With its offset written out, as the profile wants it.
  [[nodiscard]] std::string time(const char* which) const {
    const std::string text = provenance_.value(which, "");
    return text.ends_with("Z") ? text.substr(0, text.size() - 1) + "+00:00" : text;
  }
  [[nodiscard]] Times times_of_run() const { return {time("started"), time("ended")}; }

  /// Those of the whole run where the stage's own are not known: made before the run was resumed.
  [[nodiscard]] Times times_of_stage(const std::string& name) const {
    const Json stages = provenance_.value("stages", Json::object());
    const Json stage = stages.value(name, Json::object());
    const double ended = stage.value("ended", 0.0);
    if (ended <= 0) return times_of_run();
    return {date_and_time(stage.value("began", 0.0)), date_and_time(ended)};
  }

  std::vector<std::string> scripts_in(const std::string& whose, std::int64_t first,
                                      std::int64_t last) {
    std::vector<std::string> ids;
    for (const Script& script : scripts_of_[whose]) {
      if (script.used_in(first, last)) ids.push_back(script.id);
    }
    return ids;
  }

  void add_profiles() {
    const auto profile = [&](const std::string& id, const char* name, const char* version) {
      graph_.push_back(
          {{"@id", id}, {"@type", "CreativeWork"}, {"name", name}, {"version", version}});
      profiles_.push_back(id);
    };
    profile("https://w3id.org/ro/wfrun/process/0.5", "Process Run Crate", "0.5");
    profile("https://w3id.org/ro/wfrun/workflow/0.5", "Workflow Run Crate", "0.5");
    profile("https://w3id.org/ro/wfrun/provenance/0.5", "Provenance Run Crate", "0.5");
    profile("https://w3id.org/workflowhub/workflow-ro-crate/1.0", "Workflow RO-Crate", "1.0");
  }

  void add_parameters() {
    const Json parameters = workflow_.value("parameters", Json::object());
    for (const auto& [name, parameter] : parameters.items()) {
      const std::string formal = "#parameter-" + name;
      const std::string actual = "#value-" + name;
      graph_.push_back({{"@id", formal},
                        {"@type", "FormalParameter"},
                        {"name", name},
                        {"description", parameter.value("meaning", "")},
                        {"additionalType", type_of(parameter.value("type", ""))},
                        {"workExample", reference(actual)}});
      Json value = {{"@id", actual},
                    {"@type", "PropertyValue"},
                    {"name", name},
                    {"value", parameter.value("shown", "")},
                    {"exampleOfWork", reference(formal)}};
      if (const std::string unit = parameter.value("unit", ""); !unit.empty()) {
        value["unitText"] = unit;
      }
      graph_.push_back(value);
      inputs_.push_back(formal);
      values_.push_back(actual);
    }
  }

  void add_engine() {
    const Json program = provenance_.value("program", Json::object());
    graph_.push_back({{"@id", engine_},
                      {"@type", "SoftwareApplication"},
                      {"name", "Sandglass"},
                      {"url", engine_},
                      {"softwareVersion", program.value("version", "")},
                      {"sha256", program.value("digest", "")}});
    graph_.push_back({{"@id", "#language"},
                      {"@type", "ComputerLanguage"},
                      {"name", "Sandglass workflow (YAML)"},
                      {"version", "1"}});
  }

  /// The program that a step executes, once.
  std::string tool(const std::string& solver) {
    const std::string id = address_of(solver);
    if (std::find(tools_.begin(), tools_.end(), id) != tools_.end()) return id;
    tools_.push_back(id);
    Json entity = {{"@id", id}, {"@type", "SoftwareApplication"}, {"name", solver}, {"url", id}};
    for (const Json& used : list(provenance_, "solvers")) {
      if (used.value("name", "") != solver) continue;
      entity["softwareVersion"] = used.value("version", "");
      entity["sha256"] = used.value("digest", "");
    }
    if (!entity.contains("softwareVersion")) entity["softwareVersion"] = "unknown";
    graph_.push_back(entity);
    return id;
  }

  /// A step, the actions that carried it out, and the one that ordered them.
  void add_step(const std::string& name, const std::string& description, const std::string& tool_id,
                const std::vector<std::string>& actions) {
    const std::string step = "#step-" + name;
    graph_.push_back({{"@id", step},
                      {"@type", "HowToStep"},
                      {"name", name},
                      {"description", description},
                      {"position", std::to_string(steps_.size() + 1)},
                      {"workExample", reference(tool_id)}});
    steps_.push_back(step);
    const std::string control = "#control-" + name;
    graph_.push_back({{"@id", control},
                      {"@type", "ControlAction"},
                      {"name", "orchestrate " + name},
                      {"instrument", reference(step)},
                      {"object", references(actions)}});
    controls_.push_back(control);
  }

  void add_stage(const Json& stage) {
    const std::string name = stage.value("name", "");
    const std::string program = tool(stage.value("run", ""));
    std::vector<std::string> made;
    for (const std::string& file : files_) {
      if (file.starts_with("stages/" + name + "/")) made.push_back(id_of_path(file));
    }
    // A stage that was not reached has no action; its step stands there all the same.
    const bool done = !made.empty() || !scripts_of_[name].empty();
    const std::string action = "#stage-" + name;
    if (done) {
      add_action(action, "stage " + name, "the stage was run once", times_of_stage(name), program,
                 scripts_in(name, 0, 0), made);
    }
    add_step(name, "stage", program, done ? std::vector{action} : std::vector<std::string>{});
  }

  void add_participant(const Json& participant) {
    const std::string name = participant.value("name", "");
    const std::string program = tool(participant.value("solver", ""));
    const std::int64_t windows = result_.value("windows", std::int64_t{0});
    const Json coupling = workflow_.value("coupling", Json::object());
    std::int64_t every = coupling.value("checkpoint_every", std::int64_t{0});
    if (every <= 0 || every > windows) every = std::max<std::int64_t>(windows, 1);
    every *= std::max<std::int64_t>(
        1, (windows + every * kMostIntervals - 1) / (every * kMostIntervals));
    const std::vector<double> work = column(name, windows);
    const std::vector<double> began = column("began", windows);
    const std::vector<double> ended = column("ended", windows);
    const double window = coupling.value("window_s", 0.0);
    std::vector<std::string> actions;
    for (std::int64_t first = 1; first <= windows; first += every) {
      const std::int64_t last = std::min(windows, first + every - 1);
      const auto begin = static_cast<std::size_t>(first - 1);
      const auto end = static_cast<std::size_t>(last);
      double seconds = 0;
      for (std::size_t k = begin; k < std::min(end, work.size()); ++k) seconds += work[k];
      const Times times = end <= ended.size()
                              ? Times{date_and_time(began[begin]), date_and_time(ended[end - 1])}
                              : times_of_run();
      actions.push_back(fmt::format("#{}-windows-{}-{}", name, first, last));
      add_action(
          actions.back(), fmt::format("{}, windows {} to {}", name, first, last),
          fmt::format("physical time {:g} s to {:g} s, {:g} s of work",
                      static_cast<double>(first - 1) * window, static_cast<double>(last) * window,
                      seconds),
          times, program, scripts_in(name, first, last),
          has("record.h5") ? std::vector<std::string>{"record.h5"} : std::vector<std::string>{});
    }
    add_step(name, "participant of the coupling", program, actions);
    for (const Script& script : scripts_of_[name]) {
      if (!script.windows.empty()) add_windows(script, name);
    }
  }

  /// Which windows of an interval a script was made for.
  void add_windows(const Script& script, const std::string& participant) {
    const std::string id = fmt::format("#windows-of-{}-{}", script.id, participant);
    std::string text;
    for (const auto& [first, last] : script.windows) {
      text += fmt::format("{}{}", text.empty() ? "" : " ", first);
      if (last > first) text += fmt::format("-{}", last);
    }
    graph_.push_back({{"@id", id},
                      {"@type", "PropertyValue"},
                      {"name", "windows of " + participant},
                      {"value", text}});
    windows_of_[script.id].push_back(id);
  }

  /// A column of the record's timings.
  [[nodiscard]] std::vector<double> column(const std::string& name, std::int64_t windows) const {
    if (!has("record.h5") || windows == 0) return {};
    const hdf5::File record(directory_ + "/record.h5", hdf5::File::Mode::read);
    const std::string path = "/timings/" + name;
    if (!record.exists(path)) return {};
    return record.read_numbers(path, std::min(windows, record.shape(path).at(0)));
  }

  void add_action(const std::string& id, const std::string& name, const std::string& description,
                  const Times& times, const std::string& instrument,
                  const std::vector<std::string>& objects,
                  const std::vector<std::string>& results) {
    graph_.push_back({{"@id", id},
                      {"@type", "CreateAction"},
                      {"name", name},
                      {"description", description},
                      {"startTime", times.began},
                      {"endTime", times.ended},
                      {"actionStatus", kCompleted},
                      {"instrument", reference(instrument)},
                      {"object", references(objects)},
                      {"result", references(results)}});
    actions_.push_back(id);
  }

  /// The run as a whole, and the program that organised it.
  void add_run() {
    std::vector<std::string> results;
    for (const char* file : {"record.h5", "result.json", "report.html", "provenance.json"}) {
      if (has(file)) results.emplace_back(file);
    }
    add_action("#run", "run of " + workflow_.value("name", ""),
               "the whole workflow, orchestrated by Sandglass", times_of_run(), kWorkflow, values_,
               results);
    const std::string error = result_.value("error", "");
    // A comparison out of tolerance is a result, not a failure of the run.
    constexpr int mismatch = 6;
    const int code = result_.value("exit_code", 0);
    if (code != 0 && code != mismatch) {
      graph_.back()["actionStatus"] = kFailed;
      graph_.back()["error"] = error;
    }
    graph_.push_back({{"@id", "#organize"},
                      {"@type", "OrganizeAction"},
                      {"name", "orchestrate " + workflow_.value("name", "")},
                      {"startTime", time("started")},
                      {"endTime", time("ended")},
                      {"instrument", reference(engine_)},
                      {"object", references(controls_)},
                      {"result", reference("#run")}});
  }

  void add_files() {
    for (const std::string& file : files_) {
      const std::string path = directory_ + "/" + file;
      Json entity = {
          {"@id", id_of_path(file)},
          {"@type", "File"},
          {"name", file},
          {"encodingFormat", format_of(file)},
          {"contentSize", std::to_string(std::filesystem::file_size(path))},
          {"sha256", digests_.contains(file) ? digests_.at(file) : digest_of_file(path)}};
      if (const auto windows = windows_of_.find(id_of_path(file)); windows != windows_of_.end()) {
        entity["additionalProperty"] = references(windows->second);
      }
      if (file == kWorkflow) {
        workflow_file_ = entity;
        continue;
      }
      if (file == "record.h5") entity["exampleOfWork"] = reference(record_);
      graph_.push_back(entity);
    }
    if (!has("record.h5")) return;
    graph_.push_back({{"@id", record_},
                      {"@type", "FormalParameter"},
                      {"name", "record"},
                      {"description", "the history of all windows"},
                      {"additionalType", "File"},
                      {"workExample", reference("record.h5")}});
  }

  void add_workflow() {
    Json entity = {{"@id", kWorkflow},
                   {"@type", {"File", "SoftwareSourceCode", "ComputationalWorkflow", "HowTo"}}};
    entity.update(workflow_file_.is_object() ? workflow_file_ : Json::object());
    entity["@type"] = {"File", "SoftwareSourceCode", "ComputationalWorkflow", "HowTo"};
    entity["name"] = workflow_.value("title", "");
    entity["description"] = workflow_.value("description", "");
    entity["version"] = entity.value("sha256", "").substr(0, 16);
    entity["conformsTo"] =
        reference("https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE");
    entity["programmingLanguage"] = reference("#language");
    entity["input"] = references(inputs_);
    entity["output"] = references(has("record.h5") ? std::vector<std::string>{record_}
                                                   : std::vector<std::string>{});
    entity["hasPart"] = references(tools_);
    entity["step"] = references(steps_);
    graph_.push_back(entity);
  }

  void add_root() {
    std::vector<std::string> parts;
    for (const std::string& file : files_) parts.push_back(id_of_path(file));
    std::vector<std::string> mentions = actions_;
    mentions.emplace_back("#organize");
    graph_.push_back({{"@id", "./"},
                      {"@type", "Dataset"},
                      {"name", "Run of " + workflow_.value("name", "a workflow")},
                      {"description", workflow_.value("title", "")},
                      {"datePublished", provenance_.value("ended", date_and_time())},
                      {"license", "not stated: ask whoever made this run"},
                      {"conformsTo", references(profiles_)},
                      {"mainEntity", reference(kWorkflow)},
                      {"hasPart", references(parts)},
                      {"mentions", references(mentions)}});
    graph_.push_back({{"@id", kCrateFile},
                      {"@type", "CreativeWork"},
                      {"conformsTo",
                       {reference("https://w3id.org/ro/crate/1.1"),
                        reference("https://w3id.org/workflowhub/workflow-ro-crate/1.0")}},
                      {"about", reference("./")}});
  }

  static constexpr const char* kCompleted = "http://schema.org/CompletedActionStatus";
  static constexpr const char* kFailed = "http://schema.org/FailedActionStatus";
  const std::string engine_ = "urn:sandglass:sandglass";
  const std::string record_ = "#output-record";
  const std::string& directory_;
  Json workflow_;
  Json provenance_;
  Json result_;
  std::vector<std::string> files_;
  std::map<std::string, std::string> digests_;  ///< of scripts, from when they were rendered
  std::map<std::string, std::vector<Script>> scripts_of_;
  std::map<std::string, std::vector<std::string>> windows_of_;  ///< a script's
  Json workflow_file_;
  Json graph_ = Json::array();
  std::vector<std::string> profiles_;
  std::vector<std::string> inputs_;
  std::vector<std::string> values_;
  std::vector<std::string> tools_;
  std::vector<std::string> steps_;
  std::vector<std::string> controls_;
  std::vector<std::string> actions_;
};

}  // namespace

void write_crate(const std::string& run_directory) {
  write_file(run_directory + "/" + kCrateFile, text_of(Crate(run_directory).build()));
}

void refresh_crate(const std::string& run_directory, const std::vector<std::string>& files) {
  const std::string path = run_directory + "/" + kCrateFile;
  Json crate = read_json(path);
  if (!crate.contains("@graph")) return write_crate(run_directory);
  for (const std::string& file : files) {
    const std::string id = id_of_path(file);
    for (Json& entity : crate.at("@graph")) {
      if (entity.value("@id", "") != id) continue;
      entity["sha256"] = digest_of_file(run_directory + "/" + file);
      entity["contentSize"] =
          std::to_string(std::filesystem::file_size(run_directory + "/" + file));
    }
  }
  write_file(path, text_of(crate));
}

}  // namespace sandglass::record
