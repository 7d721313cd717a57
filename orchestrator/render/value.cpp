#include "render/value.hpp"

#include <array>

namespace sandglass {

std::string Value::type_name() const {
  static constexpr std::array names{"nothing", "number", "count", "switch", "text",
                                    "choice",  "markup", "list",  "map"};
  static_assert(names.size() == std::variant_size_v<decltype(data_)>);
  return names[data_.index()];
}

}  // namespace sandglass
