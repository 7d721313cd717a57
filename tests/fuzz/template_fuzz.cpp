// Any bytes may be a template (the first one chooses the language): see fuzz.hpp.
#include <cstdint>

#include "../unit/render/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sandglass::fuzz_template(data, size);
  return 0;
}
