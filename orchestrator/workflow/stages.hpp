#pragma once

#include <string>
#include <vector>

#include "workflow/context.hpp"

namespace sandglass::workflow {

/// Reads the stages that apply into workflow.stages, in an order in which they can run, and names
/// the others in stages_left_out. The participants must have been read: the coupling comes after
/// the makers of the files they are given.
void read_stages(const Context& context, Workflow& workflow);

}  // namespace sandglass::workflow
