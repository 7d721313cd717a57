#include "workflow/scripts.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace sandglass::workflow {
namespace {

void check_data_file(const Context& context, const std::string& file, const Place& place) {
  const std::string& root = context.options.data_root;
  if (is_file_below(root, file)) return;
  const std::string near = nearest(file, files_below(root));
  context.problems.add(
      place, fmt::format("there is no data file {}", in_quotes(file)),
      near.empty() ? "data files are files below data/" : fmt::format("did you mean '{}'?", near));
}

void check_file(const Context& context, const Scope& scope, const FileReference& reference,
                const Place& place, bool running) {
  if (reference.stage.empty()) return check_data_file(context, reference.file, place);
  const std::vector<Declared> stages = declared_in(context, "stages");
  const auto stage = std::find_if(stages.begin(), stages.end(), [&](const Declared& each) {
    return each.name == reference.stage;
  });
  if (stage == stages.end()) {
    context.problems.unknown(place, "there is no stage", reference.stage, names_of(stages));
    return;
  }
  const Node node = effective(*stage->node, scope);
  const std::vector<std::string> makes = Section(node, object("stage"), scope).texts("makes");
  if (std::find(makes.begin(), makes.end(), reference.file) == makes.end()) {
    context.problems.unknown(place, fmt::format("stage '{}' does not make", stage->name),
                             reference.file, makes);
  } else if (running && !applies(node, scope)) {
    context.problems.add(place, fmt::format("stage '{}' is not run here", stage->name),
                         "its 'when' does not hold where this file is used");
  }
}

bool unreadable(const Given& given) { return given.value.absent() && !given.file; }

/// The values as the template will have them, with a made-up path for a file.
Value::Map values_of(const GivenMap& given) {
  Value::Map values;
  for (const auto& [name, each] : given) {
    values[name] =
        each.file ? Value(fmt::format("/{}/{}", each.file->stage, each.file->file)) : each.value;
    if (unreadable(each)) values[name] = Value("");
  }
  return values;
}

/// Without those about a value that could not be read: one message about it is enough.
std::vector<Problem> about_readable(std::vector<Problem> problems, const GivenMap& given) {
  std::erase_if(problems, [&](const Problem& problem) {
    return std::any_of(given.begin(), given.end(), [&](const auto& item) {
      return unreadable(item.second) && item.second.place.text() == problem.place.text();
    });
  });
  return problems;
}

bool check_ending(const Context& context, const Scripts& scripts, const std::string& path,
                  const Place& place) {
  if (scripts.ending.empty() || path.ends_with(scripts.ending)) return true;
  context.problems.add(place, fmt::format("{} is not a {} script", in_quotes(path), scripts.ending),
                       fmt::format("the program wants a file that ends in {}", scripts.ending));
  return false;
}

/// Values without those that only the other template uses.
Value::Map own_values(Value::Map values, const Template& own, const std::set<std::string>& others) {
  for (const std::string& name : others) {
    if (!own.names().contains(name)) values.erase(name);
  }
  return values;
}

}  // namespace

GivenMap read_given(const Context& context, const Scope& scope, const Node& node, bool running) {
  GivenMap result;
  const Node* given = node.find("given");
  if (!given) return result;
  const Scope silent = scope.silent();
  for (const GivenEntry& entry : given_entries(*given)) {
    const std::optional<Literal> literal = silent.literal(entry.value);
    // What could not be read is reported already, and is still given: as nothing.
    Given value{literal ? literal->value : Value(), literal ? literal->file : std::nullopt,
                scope.at(entry.name)};
    if (value.file) check_file(context, scope, *value.file, scope.at(entry.value), running);
    result.emplace(entry.name.text, std::move(value));
  }
  return result;
}

void check_scripts(const Context& context, const Scripts& scripts) {
  const auto get = [&](const std::string& path, const Place& place) -> const Template* {
    if (path.empty()) return nullptr;
    if (!check_ending(context, scripts, path, place)) return nullptr;
    return context.templates.get(path, place, context.problems);
  };
  const Template* script = get(scripts.template_path, scripts.template_place);
  const Template* window = get(scripts.window_template_path, scripts.window_template_place);
  const bool complete =
      (script || scripts.template_path.empty()) && (window || scripts.window_template_path.empty());
  if (!complete || (!script && !window)) return;

  const auto given_at = [&](const std::string& name) {
    const auto found = scripts.given.find(name);
    return found == scripts.given.end() ? scripts.template_place : found->second.place;
  };
  const auto check = [&](const Template& own, const Value::Map& values) {
    context.problems.add(about_readable(own.check(values, given_at), scripts.given));
  };
  const Value::Map values = values_of(scripts.given);
  static const std::set<std::string> none;
  if (script) check(*script, own_values(values, *script, window ? window->names() : none));
  if (!window) return;
  Value::Map window_values = own_values(values, *window, script ? script->names() : none);
  if (window->names().contains("window")) {
    window_values["window"] = Value::Map{{"index", 1}, {"begin", 0.0}, {"end", 1.0}};
  }
  check(*window, window_values);
}

std::vector<std::string> makers(const GivenMap& given) {
  std::set<std::string> names;
  for (const auto& [name, each] : given) {
    if (each.file && !each.file->stage.empty()) names.insert(each.file->stage);
  }
  return {names.begin(), names.end()};
}

}  // namespace sandglass::workflow
