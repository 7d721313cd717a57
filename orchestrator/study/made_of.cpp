#include "study/made_of.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/file.hpp"
#include "orchestrator_digests.hpp"
#include "render/template.hpp"
#include "run/solvers.hpp"
#include "workflow/json.hpp"

namespace sandglass::study {
namespace {

using nlohmann::json;
using Json = nlohmann::ordered_json;

/// What only explains, without the keys that change no number.
std::string digest_of(Json part, const std::vector<const char*>& without = {}) {
  for (const char* key : without) part.erase(key);
  return digest_of_text(part.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// A part of a solver such as "version" is shown as it is; a digest would only bury the number.
bool is_digest(const std::string& text) {
  constexpr std::size_t sha256 = 64;
  return text.size() == sha256 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

Ingredients::Ingredients(run::Home home, FileMemory& memory)
    : home_(std::move(home)), memory_(memory) {}

MadeOf Ingredients::of(const workflow::Workflow& workflow) {
  MadeOf made_of;
  const Json resolved = workflow::to_json(workflow);
  for (const auto& [name, one] : resolved.at("parameters").items()) {
    made_of.parameters[name] = one.at("shown");
  }
  for (const Json& one : resolved.at("stages")) {
    made_of.parts["stage " + one.at("name").get<std::string>()] = digest_of(one);
  }
  for (const Json& one : resolved.at("participants")) {
    made_of.parts["participant " + one.at("name").get<std::string>()] = digest_of(one);
  }
  if (!resolved.at("coupling").is_null()) {
    made_of.parts["coupling"] = digest_of(resolved.at("coupling"));
  }
  for (Json one : resolved.at("comparisons")) {
    if (one.at("reference").is_object()) one["reference"].erase("source");
    made_of.parts["comparison '" + one.at("name").get<std::string>() + "'"] =
        digest_of(one, {"because", "unit"});
  }
  for (const Json& one : resolved.at("left_out")) {
    made_of.parts["left_out " + one.at("name").get<std::string>()] =
        digest_of(one, {"what", "why"});
  }
  for (const workflow::Stage& stage : workflow.stages) {
    add_template(made_of, stage.template_path);
    add_command(made_of, stage.command);
  }
  for (const workflow::Participant& one : workflow.participants) {
    add_template(made_of, one.template_path);
    add_template(made_of, one.window_template_path);
    add_command(made_of, one.command);
  }
  for (const std::string& file : workflow::data_files(workflow)) {
    made_of.parts["data " + file] = memory_.digest(home_.data() + "/" + file);
  }
  for (const std::string& name : run::solvers_of(workflow)) add_solver(made_of, name);
  for (const auto& [room, digest] : orchestrator_digests) {
    made_of.parts[fmt::format("orchestrator: {}", room)] = digest;
  }
  return made_of;
}

void Ingredients::add_template(MadeOf& made_of, const std::string& path) {
  if (path.empty()) return;
  auto [entry, is_new] = files_of_template_.try_emplace(path);
  if (is_new) entry->second = Template::load(home_.templates(), path).files();
  for (const std::string& file : entry->second) {
    made_of.parts["template " + file] = memory_.digest(home_.templates() + "/" + file);
  }
}

/// The program and the files that an argument vector names; of Python's modules, those of ours; of
/// optional solvers, the list of packages that is installed.
void Ingredients::add_command(MadeOf& made_of, const std::vector<std::string>& command) {
  const auto add = [&](const std::string& name, const std::string& path) {
    std::error_code error;
    if (path.empty() || !std::filesystem::is_regular_file(path, error)) return;
    made_of.parts[name] = memory_.digest(path);
  };
  const auto add_module = [&](const std::string& module) {
    const std::string file = "python/" + module + ".py";
    add("template " + file, home_.templates() + "/" + file);
  };
  for (std::size_t i = 0; i < command.size(); ++i) {
    const std::string& word = command[i];
    if (i == 0) {
      add("program " + word, find_program(word));
    } else if (command[i - 1] == "-m") {
      add_module(word);
      add_module("sandglass_participant");
    } else {
      add("file " + word, word);
      if (word.find('/') != std::string::npos) continue;
      add("solver " + word, home_.solver_folder(word) + "/installed");
    }
  }
}

void Ingredients::add_solver(MadeOf& made_of, const std::string& name) {
  auto [entry, is_new] = parts_of_solver_.try_emplace(name);
  if (is_new) {
    // Versions come from dpkg; a new one means a new program or library, or this file changed.
    memory_.look("/var/lib/dpkg/status");
    const record::UsedProgram used = run::identify_solver(
        home_, name, [&](const std::string& path) { return memory_.digest(path); });
    entry->second["solver " + name] = used.version;
    entry->second[fmt::format("solver {}: {}", name, used.path)] = used.digest;
    for (const record::UsedFile& part : used.parts) {
      entry->second[fmt::format("solver {}: {}", name, part.path)] = part.digest;
    }
  }
  made_of.parts.insert(entry->second.begin(), entry->second.end());
}

std::vector<std::string> differences(const MadeOf& before, const MadeOf& now) {
  if (before.parts == now.parts) return {};
  std::vector<std::string> said;
  for (const auto& [name, value] : now.parameters) {
    const auto old = before.parameters.find(name);
    if (old == before.parameters.end()) {
      said.push_back(fmt::format("parameter {} is new", name));
    } else if (old->second != value) {
      said.push_back(fmt::format("parameter {}: {} -> {}", name, old->second, value));
    }
  }
  const bool parameters_explain = !said.empty();
  for (const auto& [name, digest] : now.parts) {
    const auto old = before.parts.find(name);
    if (old == before.parts.end()) {
      said.push_back(name + " is new");
      continue;
    }
    if (old->second == digest) continue;
    // What parameters act through need not be named beside them.
    const bool resolved = name == "coupling" || name.starts_with("stage ") ||
                          name.starts_with("participant ") || name.starts_with("comparison ");
    if (resolved && parameters_explain) continue;
    const bool shown = !is_digest(digest) && !is_digest(old->second);
    said.push_back(shown ? fmt::format("{}: {} -> {}", name, old->second, digest)
                         : name + " changed");
  }
  for (const auto& [name, digest] : before.parts) {
    if (!now.parts.contains(name)) said.push_back(name + " is gone");
  }
  return said;
}

std::string key_of(const MadeOf& made_of) { return digest_of_text(json(made_of.parts).dump()); }

std::string to_json(const MadeOf& made_of) {
  return json{{"format", 1}, {"parts", made_of.parts}, {"parameters", made_of.parameters}}.dump(1) +
         "\n";
}

MadeOf made_of_from_json(const std::string& text) {
  const json kept = json::parse(text, nullptr, false);
  MadeOf made_of;
  if (!kept.is_object() || kept.value("format", 0) != 1) return made_of;
  try {
    kept.at("parts").get_to(made_of.parts);
    kept.at("parameters").get_to(made_of.parameters);
  } catch (const json::exception&) {
    return {};
  }
  return made_of;
}

}  // namespace sandglass::study
