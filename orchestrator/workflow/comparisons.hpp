#pragma once

#include "workflow/context.hpp"

namespace sandglass::workflow {

/// Reads the comparisons that apply into workflow.comparisons; those that do not are checked too.
/// The stages must have been read.
void read_comparisons(const Context& context, Workflow& workflow);

}  // namespace sandglass::workflow
