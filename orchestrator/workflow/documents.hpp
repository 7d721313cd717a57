#pragma once

#include <string>

namespace sandglass::workflow {

/// The JSON schema (draft 2020-12) of the format, for editors: workflows/schema.json. It describes
/// what can be seen in one place; `load` checks more.
std::string json_schema();

/// The reference of all keys in Markdown: the generated part of workflows/README.md.
std::string reference_page();

/// The text of workflows/README.md with what stands between its two marker comments replaced by the
/// reference. Throws std::invalid_argument when the markers are not there.
std::string with_reference_page(const std::string& readme);

}  // namespace sandglass::workflow
