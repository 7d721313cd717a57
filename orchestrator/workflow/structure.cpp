#include "workflow/structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "workflow/values.hpp"

namespace sandglass::workflow {
namespace {

std::string titled(const Object& table) {
  return table.name == "left_out" ? "left_out" : "a " + table.name;
}

/// Reports when the node is not of the kind wanted. Broken nodes pass in silence. `name` is that of
/// the thing itself, where the key holds several.
bool is(const Node& node, Node::Kind wanted, const Key& key, const Scope& scope,
        const std::string& name = {}) {
  if (node.kind == wanted) return true;
  if (node.kind == Node::Kind::broken) return false;
  scope.report(scope.at(node),
               fmt::format("'{}' must be a {}", name.empty() ? key.name : name,
                           wanted == Node::Kind::list ? "list" : "map"),
               name.empty()
                   ? fmt::format("expected: {}, such as {}", description_of(key), key.example)
                   : fmt::format("write the keys of a {} in it", key.object));
  return false;
}

void check_given(const Node& node, const Key& key, const Scope& scope) {
  if (node.kind == Node::Kind::broken) return;
  if (node.kind != Node::Kind::list && node.kind != Node::Kind::map) {
    is(node, Node::Kind::list, key, scope);
    return;
  }
  for (const Node& item : node.items) {
    if (node.kind != Node::Kind::list || item.kind == Node::Kind::map) continue;
    if (item.kind == Node::Kind::scalar && !is_reference(item) && is_name(item.text)) continue;
    if (item.kind == Node::Kind::broken) continue;
    scope.report(scope.at(item), "a list under 'given' holds names of parameters and maps",
                 "write a name without '$', or {name: value}");
  }
  std::set<std::string> seen;
  for (const GivenEntry& entry : given_entries(node)) {
    if (!is_name(entry.name.text)) {
      scope.report(scope.at(entry.name),
                   fmt::format("{} is not a name", in_quotes(entry.name.text)),
                   "use letters, digits and underscores, no digit first, at most 100");
    } else if (!seen.insert(entry.name.text).second) {
      scope.report(scope.at(entry.name),
                   fmt::format("{} is given twice", in_quotes(entry.name.text)), "keep one");
    } else if (entry.value.kind == Node::Kind::nothing) {
      scope.report(scope.at(entry.name), fmt::format("'{}' has no value", entry.name.text),
                   "give it a value or remove it");
    } else {
      (void)scope.literal(entry.value);
    }
  }
}

void check_selection(const Node& node, const Key& key, const Scope& scope) {
  if (node.kind == Node::Kind::broken) return;
  if (node.kind == Node::Kind::scalar && (node.text == "all" || node.text == "none")) return;
  if (!is(node, Node::Kind::list, key, scope)) return;
  static const Key item_key{.name = "fields", .kind = Kind::name};
  for (const Node& item : node.items) (void)scope.scalar(item, item_key);
}

/// Parameters with a value, or a list of values, each. Whether they fit is known only with the
/// workflow that is swept.
void check_settings(const Node& node, const Key& key, const Scope& scope) {
  if (!is(node, Node::Kind::map, key, scope)) return;
  const bool sweep = key.kind == Kind::sweep;
  for (size_t i = 0; i < node.keys.size(); ++i) {
    const Node& item = node.items[i];
    const bool listed = item.kind == Node::Kind::list && !item.items.empty();
    const bool plain = std::all_of(item.items.begin(), item.items.end(), [](const Node& value) {
      return value.kind == Node::Kind::scalar;
    });
    if (item.kind == Node::Kind::broken) continue;
    if (sweep ? listed && plain : item.kind == Node::Kind::scalar) continue;
    scope.report(scope.at(node.keys[i]),
                 fmt::format("'{}' under '{}' must be a {}", node.keys[i].text, key.name,
                             sweep ? "list of values" : "single value"),
                 fmt::format("expected: {}, such as {}", description_of(key), key.example));
  }
}

void check_one(const Node& node, const Key& key, const Place& where, const Scope& scope,
               const std::string& name = {}) {
  switch (key.kind) {
    case Kind::object:
      if (is(node, Node::Kind::map, key, scope, name)) {
        check_structure(node, object(key.object), where, key.partial, scope);
      }
      return;
    case Kind::given:
      return check_given(node, key, scope);
    case Kind::condition:
      (void)scope.holds(node);
      return;
    case Kind::settings:
    case Kind::sweep:
      return check_settings(node, key, scope);
    case Kind::shape:
      (void)scope.shape(node);
      return;
    case Kind::selection:
      return check_selection(node, key, scope);
    case Kind::literal:
      // Read by whoever knows its type; here it only has to be a single value.
      if (node.kind == Node::Kind::list || node.kind == Node::Kind::map) {
        scope.report(scope.at(node), fmt::format("'{}' must be a single value", key.name),
                     "expected: " + description_of(key));
      }
      return;
    default:
      (void)scope.scalar(node, key);
  }
}

void check_value(const Node& node, const Key& key, const Place& where, const Scope& scope) {
  if (key.many == Many::one) return check_one(node, key, where, scope);
  const bool list = key.many == Many::list;
  if (!is(node, list ? Node::Kind::list : Node::Kind::map, key, scope)) return;
  for (size_t i = 0; i < node.items.size(); ++i) {
    const Node& item = node.items[i];
    if (list) {
      if (item.kind == Node::Kind::nothing) {
        scope.report(scope.at(item), fmt::format("an empty item in '{}'", key.name), "remove it");
      }
      check_one(item, key, scope.at(item), scope);
      continue;
    }
    const Node::Key& name = node.keys[i];
    if (!(key.partial ? is_choice_name(name.text) : is_name(name.text))) {
      scope.report(scope.at(name), fmt::format("{} is not a name", in_quotes(name.text)),
                   "use letters, digits and underscores, no digit first, at most 100");
    }
    if (item.kind == Node::Kind::nothing) {
      scope.report(scope.at(name), fmt::format("'{}' has no value", name.text),
                   fmt::format("give it the keys of a {}", key.object));
      continue;
    }
    check_one(item, key, scope.at(name), scope, name.text);
  }
}

Node reference_to(const Node& name) {
  Node node = name;
  node.text.insert(0, 1, '$');
  node.quoted = false;
  return node;
}

Node as_map(const std::vector<GivenEntry>& entries, const Node& at) {
  Node map;
  map.kind = Node::Kind::map;
  map.line = at.line;
  map.column = at.column;
  for (const GivenEntry& entry : entries) {
    map.keys.push_back(entry.name);
    map.items.push_back(entry.value);
  }
  return map;
}

void replace(Node& map, const Node::Key& key, const Node& value) {
  for (size_t i = 0; i < map.keys.size(); ++i) {
    if (map.keys[i].text != key.text) continue;
    map.keys[i] = key;
    map.items[i] = value;
    return;
  }
  map.keys.push_back(key);
  map.items.push_back(value);
}

}  // namespace

void check_structure(const Node& node, const Object& table, const Place& where, bool partial,
                     const Scope& scope) {
  for (size_t i = 0; i < node.keys.size(); ++i) {
    const Node::Key& name = node.keys[i];
    const Key* key = table.find(name.text);
    if (!key) {
      scope.unknown(scope.at(name), fmt::format("{} has no key", titled(table)), name.text,
                    table.key_names());
    } else if (node.items[i].kind == Node::Kind::nothing) {
      scope.report(scope.at(name), fmt::format("'{}' has no value", name.text),
                   fmt::format("expected: {}, such as {}", description_of(*key), key->example));
    } else {
      check_value(node.items[i], *key, scope.at(name), scope);
    }
  }
  if (partial) return;
  for (const Key& key : table.keys) {
    if (!key.required || node.find(key.name)) continue;
    scope.report(where, fmt::format("{} needs '{}'", titled(table), key.name),
                 fmt::format("add it, such as {}: {}", key.name, key.example));
  }
}

std::vector<GivenEntry> given_entries(const Node& given) {
  std::vector<GivenEntry> entries;
  const auto add_map = [&](const Node& map) {
    for (size_t i = 0; i < map.keys.size(); ++i) entries.push_back({map.keys[i], map.items[i]});
  };
  if (given.kind == Node::Kind::map) add_map(given);
  if (given.kind != Node::Kind::list) return entries;
  for (const Node& item : given.items) {
    if (item.kind == Node::Kind::map) add_map(item);
    if (item.kind == Node::Kind::scalar && is_name(item.text)) {
      entries.push_back({{item.text, item.line, item.column}, reference_to(item)});
    }
  }
  return entries;
}

Node merged(const Node& base, const Node& over) {
  Node result = base;
  for (size_t i = 0; i < over.keys.size(); ++i) {
    const Node* present = result.find(over.keys[i].text);
    if (over.keys[i].text != "given" || !present) {
      replace(result, over.keys[i], over.items[i]);
      continue;
    }
    Node joined = as_map(given_entries(*present), *present);
    for (const GivenEntry& entry : given_entries(over.items[i])) {
      replace(joined, entry.name, entry.value);
    }
    replace(result, over.keys[i], joined);
  }
  return result;
}

const Node* Section::find(const std::string& key) const {
  const Node* node = node_.find(key);
  return node && node->kind != Node::Kind::broken && node->kind != Node::Kind::nothing ? node
                                                                                       : nullptr;
}

Place Section::place(const std::string& key) const {
  const Node* node = node_.find(key);
  return scope_.at(node ? *node : node_);
}

std::optional<Value> Section::value(const std::string& key) const {
  const Node* node = find(key);
  const Key* row = table_.find(key);
  if (!node || !row) return std::nullopt;
  return scope_.scalar(*node, *row);
}

std::string Section::text(const std::string& key, const std::string& fallback) const {
  const std::optional<Value> found = value(key);
  return found ? plain_text(*found) : fallback;
}

double Section::number(const std::string& key, double fallback) const {
  const std::optional<Value> found = value(key);
  const double* number = found ? found->as<double>() : nullptr;
  return number ? *number : fallback;
}

std::int64_t Section::count(const std::string& key, std::int64_t fallback) const {
  const std::optional<Value> found = value(key);
  const std::int64_t* count = found ? found->as<std::int64_t>() : nullptr;
  return count ? *count : fallback;
}

bool Section::toggle(const std::string& key) const {
  const std::optional<Value> found = value(key);
  const bool* flag = found ? found->as<bool>() : nullptr;
  return flag && *flag;
}

std::vector<std::string> Section::texts(const std::string& key) const {
  std::vector<std::string> result;
  const Node* node = find(key);
  const Key* row = table_.find(key);
  if (!node || !row || node->kind != Node::Kind::list) return result;
  for (const Node& item : node->items) {
    if (const std::optional<Value> found = scope_.scalar(item, *row)) {
      result.push_back(plain_text(*found));
    }
  }
  return result;
}

}  // namespace sandglass::workflow
