#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::exchange {

using Shape = std::vector<std::int64_t>;

/// A field as one participant sees it in its slot.
struct FieldLayout {
  std::string name;
  std::string unit;
  Shape capacity;  ///< the largest shape it can have; the first axis may turn out shorter
};

/// "[3, 2]"
std::string shape_text(const Shape& shape);

}  // namespace sandglass::exchange
