#pragma once

#include "process/process.hpp"
#include "record/run_directory.hpp"
#include "run/home.hpp"
#include "run/scripts.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// Runs a stage that is one program: renders its script, runs it in stages/NAME, and checks that it
/// made what it promised. Throws Error::participant when it did not.
Exit run_stage(const workflow::Stage& stage, const Home& home,
               const record::RunDirectory& directory, Scripts& scripts);

}  // namespace sandglass::run
