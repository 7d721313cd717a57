#pragma once

#include "workflow/context.hpp"

namespace sandglass::workflow {

/// Reads `coupling` and `record` into workflow.coupling. The participants must have been read: one
/// that does not apply drops out of the order, and with it the fields it sends.
void read_coupling(const Context& context, Workflow& workflow);

}  // namespace sandglass::workflow
