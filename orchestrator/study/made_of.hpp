#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "run/home.hpp"
#include "study/memory.hpp"
#include "workflow/model.hpp"

namespace sandglass::study {

/// What a result is made of. A result whose parts are the same is the same result.
struct MadeOf {
  /// Name and digest, such as "template yade/settling_sphere.py", "participant fluid", "data ...",
  /// "solver yade", "orchestrator: coupling".
  std::map<std::string, std::string> parts;
  /// Name and value as people write it. They act through the parts: a parameter that no part uses
  /// does not matter, but a part that changed is explained by them.
  std::map<std::string, std::string> parameters;
};

/// Finds what workflows are made of; what several of them share is looked up once.
class Ingredients {
 public:
  Ingredients(run::Home home, FileMemory& memory);
  /// `workflow` as resolved for one point.
  MadeOf of(const workflow::Workflow& workflow);

 private:
  void add_template(MadeOf& made_of, const std::string& path);
  void add_command(MadeOf& made_of, const std::vector<std::string>& command);
  void add_solver(MadeOf& made_of, const std::string& name);

  run::Home home_;
  FileMemory& memory_;
  std::map<std::string, std::vector<std::string>> files_of_template_;
  std::map<std::string, std::map<std::string, std::string>> parts_of_solver_;
};

/// What of the parts differs, in words: "parameter density: 2650 kg/m3 -> 2500 kg/m3", "template
/// yade/settling_sphere.py changed", "solver yade: 2023.02a-1 -> 2024.01". Empty when a result made
/// of `before` is one of `now`.
std::vector<std::string> differences(const MadeOf& before, const MadeOf& now);

/// A text that is the same for two points with the same result.
std::string key_of(const MadeOf& made_of);

std::string to_json(const MadeOf& made_of);
/// Empty when the text is no such thing.
MadeOf made_of_from_json(const std::string& text);

}  // namespace sandglass::study
