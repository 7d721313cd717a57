#pragma once

#include <optional>
#include <string>
#include <vector>

/// The one table of the workflow format, version 1. What is checked, the JSON schema and the
/// reference page all come from here; a new key is one more row.
namespace sandglass::workflow {

constexpr int format_version = 1;

/// What stands at a key.
enum class Kind {
  version,    ///< the number of the format
  text,       ///< any text
  name,       ///< a word of letters, digits and underscores that does not begin with a digit
  choice,     ///< one of the names listed in the row
  toggle,     ///< true or false
  count,      ///< a whole number
  number,     ///< a number, with a unit or SI
  unit,       ///< a unit
  template_,  ///< path of a template, relative to templates/
  literal,    ///< a number, switch or text, typed by how it is written
  given,      ///< names and values for a template
  condition,  ///< parameters and the values they must have
  settings,   ///< parameters and the value each is set to
  sweep,      ///< parameters and the values each takes in turn
  shape,      ///< lengths of the axes of an array
  selection,  ///< a list of names, or all, or none
  object      ///< a map with keys of its own: another table
};

enum class Many { one, list, map };

struct Key {
  std::string name = {};
  Kind kind = Kind::text;
  Many many = Many::one;
  bool required = false;
  bool reference = false;  ///< `$parameter` may stand here
  std::string unit = {};   ///< of a number: convertible to this; "*": to the unit named elsewhere
  std::optional<double> above = {};     ///< SI, exclusive
  std::optional<double> minimum = {};   ///< SI, inclusive
  std::vector<std::string> names = {};  ///< of a choice
  std::string object = {};              ///< name of the other table
  bool partial = false;                 ///< the other table applies without its required keys
  std::string fallback = {};            ///< what holds when the key is not there, in words
  std::string doc = {};
  std::string example = {};
};

struct Object {
  std::string name;
  std::string doc;
  std::vector<Key> keys;

  [[nodiscard]] const Key* find(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> key_names() const;
};

/// All tables; the first is the workflow itself.
const std::vector<Object>& objects();
const Object& object(const std::string& name);

/// What stands at the key, in words: "number in s, or $parameter".
std::string description_of(const Key& key);

}  // namespace sandglass::workflow
