#pragma once

#include "workflow/model.hpp"

namespace sandglass::study {

/// The workflow that looks at all points together: of a study of another workflow, its own stages
/// and comparisons; of a workflow that sweeps itself, nothing of it. The diagrams under
/// `work_precision` are stages too (templates/analysis/work_precision.py).
workflow::Workflow summary_of(const workflow::Workflow& study);

}  // namespace sandglass::study
