#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "workflow/problems.hpp"

namespace sandglass::workflow {

/// One value of a YAML document, with its place. Lines and columns (in characters) count from 1.
struct Node {
  enum class Kind {
    broken,   ///< already reported; to be passed over in silence
    nothing,  ///< no value was written
    scalar,
    list,
    map
  };
  struct Key {
    std::string text;
    int line = 0;
    int column = 0;
  };

  Kind kind = Kind::nothing;
  int line = 0;
  int column = 0;
  std::string text;     ///< of a scalar
  bool quoted = false;  ///< the scalar was in quotes or a block: it is text, whatever it looks like
  std::vector<Node> items;  ///< of a list; of a map, in the order of `keys`
  std::vector<Key> keys;

  /// The value of a map under this key, or null.
  [[nodiscard]] const Node* find(const std::string& key) const;
};

/// The largest text that is read, in bytes.
constexpr std::size_t largest_yaml = std::size_t{1} << 20U;

/// The data part of YAML 1.2: maps, lists and scalars. What makes YAML more than data (anchors,
/// aliases, tags, merge keys, several documents) and what makes a file say two things (duplicate
/// keys) is refused, as are texts beyond 1 MiB, 20 000 values, 1000 items in one list or map, or 50
/// levels, and those that are not UTF-8. Every problem that leaves a tree is added to `problems`;
/// after one that does not, the result is a `broken` node.
Node parse_yaml(const std::string& text, const std::string& file, Problems& problems);

/// UTF-8 without control characters other than line feed and tab.
bool is_clean_text(const std::string& text);

}  // namespace sandglass::workflow
