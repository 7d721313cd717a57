#include "workflow/participants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "workflow/scripts.hpp"

namespace sandglass::workflow {
namespace {

Solver solver_of(const std::string& name) {
  static const std::map<std::string, Solver> solvers = {{"yade", Solver::yade},
                                                        {"freefem", Solver::freefem},
                                                        {"lammps", Solver::lammps},
                                                        {"command", Solver::command}};
  return solvers.at(name);
}

void check_keys(const Context& context, const Section& section, const Participant& participant,
                const std::string& solver) {
  const auto needs = [&](const char* key, const char* example) {
    if (section.find(key)) return;
    context.problems.add(participant.place, fmt::format("a {} participant needs '{}'", solver, key),
                         fmt::format("add it, such as {}", example));
  };
  const auto refuses = [&](const char* key) {
    if (!section.find(key)) return;
    context.problems.add(section.place(key),
                         fmt::format("a {} participant has no '{}'", solver, key), "remove it");
  };
  if (participant.solver == Solver::command) {
    refuses("ranks");
    needs("command", "command: [program, argument]");
    if (section.find("given") && !section.find("template") && !section.find("window_template")) {
      context.problems.add(section.place("given"), "given, but there is no template to use it",
                           "add 'template', or remove 'given'");
    }
  } else {
    needs("template", participant.solver == Solver::freefem ? "template: freefem/stokes_box.edp"
                                                            : "template: yade/settling_sphere.py");
    refuses("command");
    if (participant.solver == Solver::freefem) refuses("window_template");
    if (participant.solver != Solver::lammps) refuses("ranks");
  }
}

/// Whether it is the engine that leaves it out, and not the participant's script.
bool by_unchanged_inputs(const Section& section) {
  return section.text("by") == "unchanged_inputs";
}

/// Adds the switches of what can be left out of this participant in this scope.
void add_switches(const Context& context, const Declared& declared, const Scope& scope,
                  GivenMap& given) {
  for (const Declared& each : declared_in(context, "left_out")) {
    const Section section(*each.node, object("left_out"), scope);
    const std::vector<std::string> also = section.texts("also");
    const bool told = section.text("of") == declared.name ||
                      std::find(also.begin(), also.end(), declared.name) != also.end();
    if (!told || !applies(*each.node, scope) || by_unchanged_inputs(section)) continue;
    const Given flag{Value(!context.puts_back(each.name)), std::nullopt, each.place};
    if (!given.emplace(each.name, flag).second) {
      context.problems.add(each.place,
                           fmt::format("'{}' is also given to '{}'", each.name, declared.name),
                           "give one of them another name");
    }
  }
}

std::optional<Participant> read_participant(const Context& context, const Declared& declared,
                                            const Variant& variant) {
  const Section section(variant.node, object("participant"), variant.scope);
  const std::string solver = section.text("solver");
  if (solver.empty()) return std::nullopt;
  Participant result;
  result.name = declared.name;
  result.place = declared.place;
  result.solver = solver_of(solver);
  result.template_path = section.text("template");
  result.window_template_path = section.text("window_template");
  result.command = section.texts("command");
  result.lifetime = section.text("process") == "fresh" ? Lifetime::fresh : Lifetime::resident;
  constexpr std::int64_t most_threads = 4096;
  result.threads = static_cast<int>(std::min(section.count("threads", 1), most_threads));
  result.ranks = static_cast<int>(std::min(section.count("ranks", 1), most_threads));
  result.deadline = section.number("deadline", 60);
  result.given =
      read_given(context, variant.scope, variant.node, applies(variant.node, variant.scope));
  add_switches(context, declared, variant.scope, result.given);
  check_keys(context, section, result, solver);
  const char* ending = result.solver == Solver::command   ? ""
                       : result.solver == Solver::freefem ? ".edp"
                                                          : ".py";
  check_scripts(context,
                {result.template_path, section.place("template"), result.window_template_path,
                 section.place("window_template"), ending, result.given});
  return result;
}

}  // namespace

void read_left_out(const Context& context, Workflow& workflow) {
  const std::vector<std::string> participants = names_of(declared_in(context, "participants"));
  for (const Declared& each : declared_in(context, "left_out")) {
    const Section section(*each.node, object("left_out"), context.scope);
    LeftOut item{.name = each.name,
                 .of = section.text("of"),
                 .also = section.texts("also"),
                 .what = section.text("what"),
                 .why = section.text("why"),
                 .active = !context.puts_back(each.name),
                 .unchanged_inputs = by_unchanged_inputs(section),
                 .place = each.place};
    if (std::find(participants.begin(), participants.end(), item.of) == participants.end()) {
      if (!item.of.empty()) {
        context.problems.unknown(section.place("of"), "there is no participant", item.of,
                                 participants);
      }
      continue;
    }
    for (const std::string& name : item.also) {
      if (std::find(participants.begin(), participants.end(), name) == participants.end()) {
        context.problems.unknown(section.place("also"), "there is no participant", name,
                                 participants);
      }
    }
    if (applies(*each.node, context.scope)) workflow.left_out.push_back(std::move(item));
  }
}

void read_participants(const Context& context, Workflow& workflow) {
  const std::vector<Declared> declared = declared_in(context, "participants");
  if (declared.size() > most_declared) {
    context.problems.add(declared[most_declared].place,
                         fmt::format("more than {} participants", most_declared),
                         "one participant may stand for many grains or bodies");
    return;
  }
  for (const Declared& each : declared) {
    bool selected = true;
    for (const Variant& variant : variants_of(context.scope, each)) {
      std::optional<Participant> participant = read_participant(context, each, variant);
      if (participant && selected && applies(variant.node, variant.scope)) {
        workflow.participants.push_back(std::move(*participant));
      }
      selected = false;
    }
  }
  const Node* participants = context.root.find("participants");
  if (participants && !context.root.find("coupling")) {
    context.problems.add(context.scope.at(*participants),
                         "there are participants and no 'coupling'", "add the key 'coupling'");
  }
  // What is left out of a participant that does not take part is not left out: it is not there.
  std::erase_if(workflow.left_out, [&](const LeftOut& item) {
    return std::none_of(workflow.participants.begin(), workflow.participants.end(),
                        [&](const Participant& each) { return each.name == item.of; });
  });
}

}  // namespace sandglass::workflow
