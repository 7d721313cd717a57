#pragma once

#include "workflow/context.hpp"
#include "workflow/model.hpp"

namespace sandglass::workflow {

/// The key `study`. What its parameters are is known to the workflow that is swept only: names and
/// values are checked when the points are made. Reports a workflow without stages that is no study
/// of another one.
void read_study(const Context& context, Workflow& workflow);

}  // namespace sandglass::workflow
