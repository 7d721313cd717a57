#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "render/template.hpp"

namespace sandglass {

/// One piece of a template. Sections hold their body between themselves and `end`; building blocks
/// are already in place.
struct Node {
  enum class Kind { text, value, section, inverted };
  Kind kind = Kind::text;
  std::string text;                ///< the literal text; of a tag its name as written
  std::vector<std::string> parts;  ///< the name between its dots; empty: {{.}}
  std::size_t end = 0;             ///< sections: index behind the last node of the body
  bool raw = false;                ///< stands where HTML escapes do not protect
  std::size_t file = 0;            ///< index into Parsed::files
  int line = 0;
  int column = 0;
};

struct Template::Parsed {
  std::string path;
  Language language = Language::text;
  std::vector<std::string> files;
  std::vector<Node> nodes;
  std::set<std::string> names;
  std::size_t text_size = 0;  ///< characters of literal text

  [[nodiscard]] Place place(const Node& node) const {
    return {files[node.file], node.line, node.column};
  }
};

namespace render {

/// A name as it may stand in a message: names of 10 kB are legal.
inline std::string shown(const std::string& name) {
  constexpr std::size_t longest = 60;
  return name.size() <= longest ? name : name.substr(0, longest) + "...";
}

}  // namespace render
}  // namespace sandglass
