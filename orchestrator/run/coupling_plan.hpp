#pragma once

#include "coupling/engine.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// The workflow's coupling in the engine's words: participants and fields by number, in the order
/// of the workflow, with what happens to a field in transit. `workflow` has a coupling.
coupling::Plan plan_of(const workflow::Workflow& workflow);

}  // namespace sandglass::run
