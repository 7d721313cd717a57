#pragma once

#include <string>
#include <vector>

#include "workflow/model.hpp"
#include "workflow/problems.hpp"
#include "workflow/yaml.hpp"

namespace sandglass::workflow {

/// The parameters of a workflow with their final values: as declared, or as set from the command
/// line. `root` is the whole workflow. Wrong values and declarations that contradict themselves are
/// added to `problems`; what check_structure reports is passed over. Throws Error::usage for a
/// setting whose name no parameter has, and for one that is set twice.
std::vector<Parameter> read_parameters(const Node& root, const std::string& file,
                                       const std::vector<Setting>& settings, Problems& problems);

}  // namespace sandglass::workflow
