#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "workflow/keys.hpp"
#include "workflow/scope.hpp"
#include "workflow/yaml.hpp"

namespace sandglass::workflow {

/// Checks a map against a table of keys, and everything below it: unknown keys, missing ones, and
/// values of the wrong kind. `where` is the place of whatever the map describes. `partial`:
/// required keys may be missing (a case of a choice).
void check_structure(const Node& node, const Object& table, const Place& where, bool partial,
                     const Scope& scope);

/// One name of a `given`, however it was written.
struct GivenEntry {
  Node::Key name;
  Node value;
};

/// `given: [diameter, {mesh: {file: a/b}}]` and `given: {diameter: $diameter, mesh: ...}` alike.
/// What is neither is passed over.
std::vector<GivenEntry> given_entries(const Node& given);

/// The map with the keys of `over` in place of, or after, its own; `given` is joined by name.
Node merged(const Node& base, const Node& over);

/// Convenient reading of a checked map: what is missing or wrong gives the fallback.
class Section {
 public:
  Section(const Node& node, const Object& table, const Scope& scope)
      : node_(node), table_(table), scope_(scope.silent()) {}

  [[nodiscard]] const Node* find(const std::string& key) const;
  [[nodiscard]] Place place(const std::string& key) const;  ///< of the value; else of the map
  [[nodiscard]] std::string text(const std::string& key, const std::string& fallback = {}) const;
  [[nodiscard]] double number(const std::string& key, double fallback) const;
  [[nodiscard]] std::int64_t count(const std::string& key, std::int64_t fallback) const;
  [[nodiscard]] bool toggle(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> texts(const std::string& key) const;

 private:
  [[nodiscard]] std::optional<Value> value(const std::string& key) const;

  const Node& node_;
  const Object& table_;
  Scope scope_;
};

}  // namespace sandglass::workflow
