// Any bytes may be a workflow: it is read, or refused by an Error.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.hpp"
#include "workflow/json.hpp"
#include "workflow/model.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sandglass;
  workflow::LoadOptions options;
  options.templates_root = SANDGLASS_SOURCE_DIR "/templates";
  options.data_root = SANDGLASS_SOURCE_DIR "/data";
  try {
    const std::string text(reinterpret_cast<const char*>(data), size);
    (void)workflow::to_json(workflow::load_text(text, "fuzz.yaml", options)).dump();
  } catch (const Error&) {
  }
  return 0;
}
