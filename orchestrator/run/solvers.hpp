#pragma once

#include <set>
#include <string>
#include <vector>

#include "base/file.hpp"
#include "process/process.hpp"
#include "record/provenance.hpp"
#include "run/home.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// How one external program is found, started, and named in the provenance.
struct SolverInfo {
  std::string name;     ///< as in workflows: "yade", "freefem", "gmsh", "python"
  std::string program;  ///< looked up on PATH
  std::string package;  ///< the Debian package it comes from; empty: installed by `setup`
  std::string role;     ///< one line, for `doctor`
};

/// All programs that a workflow can name, in the order of `doctor`.
const std::vector<SolverInfo>& solvers();
const SolverInfo& solver(const std::string& name);
std::string solver_name(workflow::Solver solver);
std::string solver_name(workflow::Program program);

/// Throws Error::environment when the solver is one that `setup` installs and it is not there.
void require_installed(const Home& home, const std::string& name);

/// The same of the private environment that a command runs in (python -m sandglass_private NAME).
void require_environment(const Home& home, const std::vector<std::string>& command);

/// The command that starts the solver as a participant (YADE and LAMMPS keep living around their
/// script; FreeFEM's script holds the loop).
Command participant_command(const Home& home, const workflow::Participant& participant,
                            const std::string& script);
/// The command that runs a stage's script once.
Command stage_command(const Home& home, const workflow::Stage& stage, const std::string& script);

/// The names of the solvers that a workflow needs, each once.
std::set<std::string> solvers_of(const workflow::Workflow& workflow);

/// Program, package version and digests, with the helpers of ours that it loads.
record::UsedProgram identify_solver(const Home& home, const std::string& name,
                                    const record::DigestOf& digest = digest_of_file);

}  // namespace sandglass::run
