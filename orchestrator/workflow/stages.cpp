#include "workflow/stages.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "workflow/scripts.hpp"

namespace sandglass::workflow {
namespace {

Program program_of(const std::string& name) {
  static const std::map<std::string, Program> programs = {
      {"gmsh", Program::gmsh},        {"python", Program::python}, {"freefem", Program::freefem},
      {"yade", Program::yade},        {"lammps", Program::lammps}, {"command", Program::command},
      {"coupling", Program::coupling}};
  return programs.at(name);
}

std::string ending_of(Program program) {
  switch (program) {
    case Program::gmsh:
      return ".geo";
    case Program::freefem:
      return ".edp";
    case Program::python:
    case Program::yade:
    case Program::lammps:
      return ".py";
    default:
      return {};
  }
}

/// Keys that the program needs, and those that mean nothing to it.
void check_keys(const Context& context, const Section& section, const Stage& stage,
                const std::string& program) {
  const auto needs = [&](const char* key, const char* example) {
    if (section.find(key)) return;
    context.problems.add(stage.place, fmt::format("a {} stage needs '{}'", program, key),
                         fmt::format("add it, such as {}", example));
  };
  const auto refuses = [&](const std::vector<const char*>& keys) {
    for (const char* key : keys) {
      if (!section.find(key)) continue;
      context.problems.add(section.place(key), fmt::format("a {} stage has no '{}'", program, key),
                           "remove it");
    }
  };
  if (stage.program == Program::coupling) {
    refuses({"template", "command", "given", "makes", "reuse", "analysis", "deadline"});
    if (!context.root.find("coupling")) {
      context.problems.add(stage.place, "there is no 'coupling' for this stage to run",
                           "add the key 'coupling', or remove the stage");
    }
  } else if (stage.program == Program::command) {
    needs("command", "command: [program, argument]");
    // Nobody knows what a program of somebody else's reads.
    refuses({"template", "given", "analysis", "reuse"});
  } else {
    needs("template", "template: python/prepare.py");
    refuses({"command"});
    if (stage.program != Program::python) refuses({"analysis"});
  }
}

/// One variant of a stage, checked. Nothing when even its program is unknown.
std::optional<Stage> read_stage(const Context& context, const Declared& declared,
                                const Variant& variant) {
  const Section section(variant.node, object("stage"), variant.scope);
  const std::string program = section.text("run");
  if (program.empty()) return std::nullopt;
  Stage stage;
  stage.name = declared.name;
  stage.place = declared.place;
  stage.program = program_of(program);
  stage.template_path = section.text("template");
  stage.command = section.texts("command");
  stage.given =
      read_given(context, variant.scope, variant.node, applies(variant.node, variant.scope));
  stage.makes = section.texts("makes");
  stage.reuse = section.toggle("reuse") && !context.puts_back(stage.name);
  stage.analysis = section.toggle("analysis");
  stage.deadline = section.number("deadline", stage.program == Program::coupling ? 0 : 600);
  for (const std::string& file : stage.makes) {
    if (is_inner_path(file)) continue;
    context.problems.add(section.place("makes"),
                         fmt::format("{} is not a file's place", in_quotes(file)),
                         "write a path below the stage's work directory");
  }
  check_keys(context, section, stage, program);
  Scripts scripts;
  scripts.template_path = stage.template_path;
  scripts.template_place = section.place("template");
  scripts.ending = ending_of(stage.program);
  scripts.given = stage.given;
  if (!ending_of(stage.program).empty()) check_scripts(context, scripts);
  return stage;
}

/// A stage that may or may not apply, while the order is found.
struct Candidate {
  Stage stage;
  bool applies = true;
};

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// What must come before each stage: as written, by files, and by the coupling.
void find_predecessors(const Context& context, std::vector<Candidate>& candidates,
                       const Workflow& workflow) {
  const std::vector<Declared> declared = declared_in(context, "stages");
  for (Candidate& candidate : candidates) {
    const auto own = std::find_if(declared.begin(), declared.end(), [&](const Declared& each) {
      return each.name == candidate.stage.name;
    });
    const Node node = effective(*own->node, context.scope);
    const Node* after = node.find("after");
    for (size_t i = 0; after && i < after->items.size(); ++i) {
      const Node& name = after->items[i];
      if (name.kind != Node::Kind::scalar || !is_name(name.text)) continue;
      const std::vector<std::string> names = names_of(declared);
      if (std::find(names.begin(), names.end(), name.text) == names.end()) {
        context.problems.unknown(context.scope.at(name), "there is no stage", name.text, names);
      } else {
        add_once(candidate.stage.after, name.text);
      }
    }
    for (const std::string& maker : makers(candidate.stage.given)) {
      add_once(candidate.stage.after, maker);
    }
    if (candidate.stage.program == Program::coupling) {
      for (const Participant& participant : workflow.participants) {
        for (const std::string& maker : makers(participant.given)) {
          add_once(candidate.stage.after, maker);
        }
      }
    }
    if (!candidate.stage.analysis) continue;
    for (const Candidate& other : candidates) {
      if (other.stage.program == Program::coupling) {
        add_once(candidate.stage.after, other.stage.name);
      }
    }
  }
}

/// The stages that no order can satisfy end up in a cycle: "a -> b -> a".
void report_cycle(const Context& context, const std::vector<Candidate>& left) {
  const auto find = [&](const std::string& name) {
    return std::find_if(left.begin(), left.end(),
                        [&](const Candidate& each) { return each.stage.name == name; });
  };
  // Every stage left waits for another one that is left: following that leads into the cycle.
  std::vector<std::string> path{left.front().stage.name};
  while (true) {
    const auto here = find(path.back());
    const auto next =
        std::find_if(here->stage.after.begin(), here->stage.after.end(),
                     [&](const std::string& name) { return find(name) != left.end(); });
    const auto seen = std::find(path.begin(), path.end(), *next);
    const bool closed = seen != path.end();
    if (closed) path.erase(path.begin(), seen);
    path.push_back(*next);
    if (closed) break;
  }
  std::reverse(path.begin(), path.end());  // from what comes first to what waits for it
  context.problems.add(find(path.front())->stage.place,
                       fmt::format("the stages wait for each other: {}", fmt::join(path, " -> ")),
                       "remove one 'after', or one file that is passed back");
}

/// First those that wait for nothing, in file order.
std::vector<Candidate> in_order(const Context& context, std::vector<Candidate> waiting) {
  std::vector<Candidate> done;
  while (!waiting.empty()) {
    const auto ready =
        std::find_if(waiting.begin(), waiting.end(), [&](const Candidate& candidate) {
          return std::none_of(waiting.begin(), waiting.end(), [&](const Candidate& other) {
            const auto& after = candidate.stage.after;
            return std::find(after.begin(), after.end(), other.stage.name) != after.end();
          });
        });
    if (ready == waiting.end()) {
      report_cycle(context, waiting);
      return done;
    }
    done.push_back(std::move(*ready));
    waiting.erase(ready);
  }
  return done;
}

void check_coupling_stages(const Context& context, const std::vector<Candidate>& candidates) {
  const Candidate* first = nullptr;
  const bool declared_wrong = candidates.size() < declared_in(context, "stages").size();
  for (const Candidate& candidate : candidates) {
    if (candidate.stage.program != Program::coupling) continue;
    if (first) {
      context.problems.add(candidate.stage.place, "a second coupling stage",
                           fmt::format("'{}' already runs the coupling", first->stage.name));
    }
    first = &candidate;
  }
  const Node* coupling = context.root.find("coupling");
  const Node* stages = context.root.find("stages");
  if (!coupling || coupling->kind != Node::Kind::map || !stages) return;
  if (!first && !declared_wrong && stages->kind == Node::Kind::map) {
    context.problems.add(context.scope.at(*coupling), "no stage runs the coupling",
                         "add a stage such as couple: {run: coupling}");
  }
}

}  // namespace

void read_stages(const Context& context, Workflow& workflow) {
  const std::vector<Declared> declared = declared_in(context, "stages");
  if (declared.size() > most_declared) {
    context.problems.add(declared[most_declared].place,
                         fmt::format("more than {} stages", most_declared),
                         "a stage that repeats is a study");
    return;
  }
  std::vector<Candidate> candidates;
  for (const Declared& each : declared) {
    bool selected = true;
    for (const Variant& variant : variants_of(context.scope, each)) {
      std::optional<Stage> stage = read_stage(context, each, variant);
      if (stage && selected) {
        candidates.push_back({std::move(*stage), applies(variant.node, variant.scope)});
      }
      selected = false;
    }
  }
  check_coupling_stages(context, candidates);
  find_predecessors(context, candidates, workflow);
  for (Candidate& candidate : in_order(context, std::move(candidates))) {
    if (candidate.applies) {
      workflow.stages.push_back(std::move(candidate.stage));
    } else {
      workflow.stages_left_out.push_back(candidate.stage.name);
    }
  }
  // A stage that does not apply is not waited for.
  for (Stage& stage : workflow.stages) {
    std::erase_if(stage.after, [&](const std::string& name) {
      const auto& out = workflow.stages_left_out;
      return std::find(out.begin(), out.end(), name) != out.end();
    });
  }
}

}  // namespace sandglass::workflow
