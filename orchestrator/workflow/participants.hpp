#pragma once

#include "workflow/context.hpp"

namespace sandglass::workflow {

/// Reads what can be left out and applies here into workflow.left_out.
void read_left_out(const Context& context, Workflow& workflow);

/// Reads the participants that apply into workflow.participants; all variants are checked. What can
/// be left out of a participant arrives in its `given` as a switch.
void read_participants(const Context& context, Workflow& workflow);

}  // namespace sandglass::workflow
