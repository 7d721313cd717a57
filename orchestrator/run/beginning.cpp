#include "run/beginning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/file.hpp"
#include "record/crate.hpp"
#include "run/products.hpp"
#include "run/scripts.hpp"

namespace sandglass::run {
namespace {

using Json = nlohmann::json;

constexpr const char* kFile = "run.json";
constexpr int kFormat = 1;

/// Every template that the workflow can render, with all that they include.
std::vector<record::UsedFile> template_files(const workflow::Workflow& workflow, const Home& home) {
  Scripts scripts(home.templates(), "");
  const auto add = [&](const std::string& path) {
    if (!path.empty()) scripts.get(path);
  };
  for (const workflow::Stage& stage : workflow.stages) add(stage.template_path);
  for (const workflow::Participant& one : workflow.participants) {
    add(one.template_path);
    add(one.window_template_path);
  }
  return scripts.template_files();
}

Json to_json(const Beginning& beginning) {
  Json settings = Json::array();
  for (const workflow::Setting& one : beginning.changes.settings) {
    settings.push_back({{"name", one.name}, {"text", one.text}});
  }
  return {{"format", kFormat},
          {"started", beginning.started},
          {"resumed", beginning.resumed},
          {"command", beginning.command},
          {"workflow", {{"path", beginning.workflow_path}, {"digest", beginning.workflow_digest}}},
          {"settings", settings},
          {"keep_all", beginning.changes.keep_all},
          {"keep", beginning.changes.keep},
          {"analyses_of", beginning.analyses_of},
          {"templates", record::to_json(beginning.templates)},
          {"data", record::to_json(beginning.data)}};
}

void store(const Beginning& beginning, const record::RunDirectory& directory) {
  write_file(directory.file(kFile),
             to_json(beginning).dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::vector<record::UsedFile> files_of(const Json& json) {
  std::vector<record::UsedFile> files;
  for (const Json& one : json) files.push_back({one.at("path"), one.at("digest")});
  return files;
}

/// What differs between then and now, as problems.
void compare(const std::vector<record::UsedFile>& then, const std::vector<record::UsedFile>& now,
             std::vector<Problem>& problems) {
  const auto digest_in = [](const std::vector<record::UsedFile>& files, const std::string& path) {
    const auto found = std::find_if(files.begin(), files.end(),
                                    [&](const record::UsedFile& one) { return one.path == path; });
    return found == files.end() ? std::string() : found->digest;
  };
  const auto add = [&](const std::string& path, const char* what) {
    Problem problem;
    problem.place.file = path;
    problem.what = what;
    problem.remedy = "bring it back as it was, or run anew";
    problems.push_back(std::move(problem));
  };
  for (const record::UsedFile& one : then) {
    const std::string digest = digest_in(now, one.path);
    if (digest.empty()) {
      add(one.path, "was used when the run began, and is not any more");
    } else if (digest != one.digest) {
      add(one.path, "has changed since the run began");
    }
  }
  for (const record::UsedFile& one : now) {
    if (digest_in(then, one.path).empty()) add(one.path, "was not used when the run began");
  }
}

}  // namespace

std::vector<record::UsedFile> data_files(const workflow::Workflow& workflow, const Home& home) {
  std::vector<record::UsedFile> files;
  for (const std::string& path : workflow::data_files(workflow)) {
    files.push_back({"data/" + path, digest_of_file(home.data() + "/" + path)});
  }
  return files;
}

Beginning begin_run(const workflow::Workflow& workflow, const Home& home,
                    const std::vector<std::string>& command,
                    const record::RunDirectory& directory) {
  Beginning beginning;
  beginning.started = date_and_time();
  beginning.command = command;
  if (!beginning.command.empty()) beginning.command[0] = "sandglass";
  beginning.workflow_path = workflow.path;
  beginning.workflow_digest = digest_of_file(directory.file("workflow.yaml"));
  beginning.changes = workflow.changes;
  beginning.templates = template_files(workflow, home);
  beginning.data = data_files(workflow, home);
  store(beginning, directory);
  return beginning;
}

Beginning read_beginning(const std::string& directory) {
  const std::string path = directory + "/" + kFile;
  if (!std::filesystem::exists(path)) {
    throw Error::environment(
        fmt::format("'{}' is not a run directory, or was left before its run began: it has no {}",
                    directory, kFile),
        "run its workflow anew");
  }
  try {
    const Json json = Json::parse(read_file(path));
    Beginning beginning;
    beginning.started = json.at("started");
    beginning.resumed = json.at("resumed");
    beginning.command = json.at("command");
    beginning.workflow_path = json.at("workflow").at("path");
    beginning.workflow_digest = json.at("workflow").at("digest");
    for (const Json& one : json.at("settings")) {
      beginning.changes.settings.push_back({one.at("name"), one.at("text")});
    }
    beginning.changes.keep_all = json.at("keep_all");
    beginning.changes.keep = json.at("keep");
    beginning.analyses_of = json.value("analyses_of", "");
    beginning.templates = files_of(json.at("templates"));
    beginning.data = files_of(json.at("data"));
    return beginning;
  } catch (const Json::exception& problem) {
    throw Error::environment(fmt::format("'{}' cannot be understood: {}", path, problem.what()),
                             "it was altered, or written by another version: run anew");
  }
}

void begin_analyses(Beginning beginning, const std::string& directory,
                    const record::RunDirectory& analyses) {
  beginning.analyses_of = directory;
  store(beginning, analyses);
}

void go_on(Beginning& beginning, const record::RunDirectory& directory) {
  beginning.resumed.push_back(date_and_time());
  store(beginning, directory);
}

workflow::Workflow load_again(const Beginning& beginning, const Home& home,
                              const std::string& directory) {
  const std::string text = read_file(directory + "/workflow.yaml");
  if (digest_of_text(text) != beginning.workflow_digest) {
    throw Error::refused({directory + "/workflow.yaml", 0, 0}, "was altered after the run began",
                         "bring it back as it was, or run anew");
  }
  workflow::LoadOptions options;
  static_cast<workflow::Changes&>(options) = beginning.changes;
  options.templates_root = home.templates();
  options.data_root = home.data();
  return workflow::load_text(text, beginning.workflow_path, options);
}

void require_unchanged(const Beginning& beginning, const workflow::Workflow& workflow,
                       const Home& home) {
  std::vector<Problem> problems;
  compare(beginning.templates, template_files(workflow, home), problems);
  compare(beginning.data, data_files(workflow, home), problems);
  if (!problems.empty()) throw Error::refused(std::move(problems));
}

void clear_unfinished(const record::RunDirectory& directory) {
  std::vector<std::string> unneeded;
  for (const char* name : {"exchange", "work", "result.json", "report.html", record::kCrateFile}) {
    unneeded.push_back(directory.file(name));
  }
  if (std::filesystem::exists(directory.file("stages"))) {
    for (const auto& entry : std::filesystem::directory_iterator(directory.file("stages"))) {
      if (!made_in(entry.path().string())) unneeded.push_back(entry.path().string());
    }
  }
  for (const std::string& path : unneeded) {
    std::error_code error;
    std::filesystem::remove_all(path, error);
    if (error) throw_system_error("remove", path, error.value());
  }
}

}  // namespace sandglass::run
