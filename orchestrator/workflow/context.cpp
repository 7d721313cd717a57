#include "workflow/context.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace sandglass::workflow {
namespace {

constexpr std::size_t most_variants = 1000;

/// The case for a choice: its own, or `otherwise`.
const Node* case_for(const Node& cases, const std::string& choice) {
  const Node* own = cases.find(choice);
  return own ? own : cases.find("otherwise");
}

Node without_cases(const Node& node) {
  Node result = node;
  result.keys.clear();
  result.items.clear();
  for (size_t i = 0; i < node.keys.size(); ++i) {
    if (node.keys[i].text == "choose" || node.keys[i].text == "cases") continue;
    result.keys.push_back(node.keys[i]);
    result.items.push_back(node.items[i]);
  }
  return result;
}

/// The choice parameter, when `choose` and `cases` fit together; else reported.
const Parameter* chooser(const Scope& scope, const Declared& declared) {
  const Node* choose = declared.node->find("choose");
  const Node* cases = declared.node->find("cases");
  if (!choose && !cases) return nullptr;
  if (!choose || !cases) {
    scope.report(
        declared.place,
        fmt::format("'{}' without '{}'", choose ? "choose" : "cases", choose ? "cases" : "choose"),
        "they belong together");
    return nullptr;
  }
  if (choose->kind != Node::Kind::scalar || cases->kind != Node::Kind::map) return nullptr;
  const Parameter* parameter = scope.wanted(scope.at(*choose), choose->text);
  if (!parameter) return nullptr;
  if (parameter->type != Parameter::Type::choice) {
    scope.report(scope.at(*choose),
                 fmt::format("parameter '{}' is a {}", parameter->name, type_text(*parameter)),
                 "'choose' needs a choice");
    return nullptr;
  }
  std::vector<std::string> valid = parameter->choices;
  valid.emplace_back("otherwise");
  for (const Node::Key& key : cases->keys) {
    if (std::find(valid.begin(), valid.end(), key.text) == valid.end()) {
      scope.unknown(scope.at(key), fmt::format("parameter '{}' has no choice", parameter->name),
                    key.text, valid);
    }
  }
  for (const std::string& choice : parameter->choices) {
    if (case_for(*cases, choice)) continue;
    scope.report(declared.place,
                 fmt::format("no case for choice '{}' of '{}'", choice, parameter->name),
                 "add the case, or one called otherwise");
  }
  return parameter;
}

/// The variants of one choice after the other, what is selected first.
void add_variants(const Scope& scope, const Declared& declared, std::vector<Variant>& result) {
  if (result.size() >= most_variants) {
    if (result.size() == most_variants) {
      scope.report(declared.place,
                   fmt::format("its cases within cases are more than {}", most_variants),
                   "give what differs in parameters");
      result.push_back({scope, without_cases(*declared.node)});
    }
    return;
  }
  const Parameter* parameter = chooser(scope, declared);
  if (!parameter) {
    result.push_back({scope, effective(*declared.node, scope)});
    return;
  }
  const auto add = [&](const std::string& choice, const Scope& assumed) {
    Node node = without_cases(*declared.node);
    const Node* chosen = case_for(*declared.node->find("cases"), choice);
    if (chosen && chosen->kind == Node::Kind::map) node = merged(node, *chosen);
    add_variants(assumed, {declared.name, declared.place, &node}, result);
  };
  const std::string selected = plain_text(scope.value_of(*parameter));
  add(selected, scope);
  for (const std::string& choice : parameter->choices) {
    if (choice != selected) add(choice, scope.assuming(parameter->name, choice));
  }
}

}  // namespace

bool Context::puts_back(const std::string& name) const {
  return options.keep_all ||
         std::find(options.keep.begin(), options.keep.end(), name) != options.keep.end();
}

const Template* TemplateShelf::get(const std::string& path, const Place& used_at,
                                   Problems& problems) {
  const auto [entry, fresh] = shelf_.try_emplace(path);
  if (fresh && is_file_below(root_, path)) {
    entry->second.exists = true;
    try {
      entry->second.parsed = Template::load(root_, path);
    } catch (const Error& error) {
      problems.add(error.problems());
    }
  }
  if (!entry->second.exists) {
    const std::string near = nearest(path, files_below(root_));
    problems.add(used_at, fmt::format("there is no template {}", in_quotes(path)),
                 near.empty() ? "templates are files below templates/"
                              : fmt::format("did you mean '{}'?", near));
  }
  return entry->second.parsed ? &*entry->second.parsed : nullptr;
}

std::vector<Declared> declared_in(const Context& context, const std::string& section) {
  std::vector<Declared> result;
  const Node* map = context.root.find(section);
  if (!map || map->kind != Node::Kind::map) return result;
  for (size_t i = 0; i < map->keys.size(); ++i) {
    if (map->items[i].kind != Node::Kind::map) continue;
    result.push_back({map->keys[i].text, context.scope.at(map->keys[i]), &map->items[i]});
  }
  return result;
}

std::vector<std::string> names_of(const std::vector<Declared>& declared) {
  std::vector<std::string> names;
  names.reserve(declared.size());
  for (const Declared& each : declared) names.push_back(each.name);
  return names;
}

std::vector<Variant> variants_of(const Scope& scope, const Declared& declared) {
  std::vector<Variant> result;
  add_variants(scope, declared, result);
  return result;
}

Node effective(const Node& node, const Scope& scope) {
  Node base = without_cases(node);
  const Node* choose = node.find("choose");
  const Node* cases = node.find("cases");
  if (!choose || !cases || cases->kind != Node::Kind::map) return base;
  const Parameter* parameter = scope.parameter(choose->text);
  if (!parameter) return base;
  const Node* chosen = case_for(*cases, plain_text(scope.value_of(*parameter)));
  if (!chosen || chosen->kind != Node::Kind::map) return base;
  return effective(merged(base, *chosen), scope);  // which may choose again
}

bool applies(const Node& node, const Scope& scope) {
  const Node* when = node.find("when");
  return !when || when->kind != Node::Kind::map || scope.silent().holds(*when);
}

bool is_file_below(const std::string& root, const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(std::filesystem::path(root) / path, ignored);
}

std::vector<std::string> files_below(const std::string& root) {
  std::vector<std::string> result;
  std::error_code error;
  auto walk = std::filesystem::recursive_directory_iterator(root, error);
  const auto end = std::filesystem::recursive_directory_iterator();
  while (!error && walk != end && result.size() < 10'000) {
    if (walk->is_regular_file(error)) {
      result.push_back(std::filesystem::relative(walk->path(), root, error).string());
    }
    walk.increment(error);
  }
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace sandglass::workflow
