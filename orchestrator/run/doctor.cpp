#include "run/doctor.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <filesystem>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/file.hpp"
#include "exchange/slot.hpp"
#include "hdf5/hdf5.hpp"
#include "process/interrupt.hpp"
#include "run/solvers.hpp"

namespace sandglass::run {
namespace {

/// A folder of its own for the trials, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sandglass-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw_system_error("make the folder", pattern, errno);
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// A solver's trial: a script, and a line that its output must hold.
struct Trial {
  std::string solver;
  std::string file;
  std::string script;
  std::string expected;
  std::string success;
};

const std::vector<Trial>& trials() {
  static const std::vector<Trial> all = {
      {"yade", "trial.py",
       "O.bodies.append(sphere((0, 0, 0), 1e-3))\n"
       "O.engines = [ForceResetter(), NewtonIntegrator(damping=0, gravity=(0, 0, -10))]\n"
       "O.dt = 1e-3\n"
       "O.step()\n"
       "O.step()\n"
       "assert abs(O.bodies[0].state.vel[2] + 0.02) < 1e-15\n"
       "print('trial done')\n",
       "trial done", "one sphere fell two steps"},
      {"freefem", "trial.edp",
       "load \"sandglass\"\n"
       "mesh Th = square(4, 4);\n"
       "fespace Vh(Th, P1);\n"
       "Vh u, v;\n"
       "solve laplace(u, v) = int2d(Th)(dx(u)*dx(v) + dy(u)*dy(v)) + on(1, u = 0) + on(3, u = 1);\n"
       "assert(abs(u(0.5, 0.5) - 0.5) < 1e-12);\n"
       "assert(allfinite(u[]));\n"
       "sandglassFinished();\n",
       "sandglass: finished", "one Laplace problem solved, plugin loaded"},
      {"gmsh", "trial.geo",
       "Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Point(3) = {0, 1, 0, 1};\n"
       "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1};\n"
       "Curve Loop(1) = {1, 2, 3}; Plane Surface(1) = {1};\n"
       "Mesh 2;\n"
       "Printf(\"trial done, %g nodes\", Mesh.NbNodes);\n",
       "trial done", "one triangle meshed"},
      {"python", "trial.py",
       "import h5py, matplotlib, meshio, numpy\n"
       "print('trial done: numpy', numpy.__version__, 'h5py', h5py.__version__,\n"
       "      'meshio', meshio.__version__, 'matplotlib', matplotlib.__version__)\n",
       "trial done", "numpy, h5py, meshio and matplotlib imported"}};
  return all;
}

std::string packages_of(const std::string& name, const std::string& package) {
  if (name == "python") return "python3 python3-h5py python3-meshio python3-matplotlib";
  if (name == "freefem") return package + " libfreefem++-dev";
  return package;
}

Finding run_trial(const Home& home, const Trial& trial, const std::string& folder) {
  const SolverInfo& info = solver(trial.solver);
  Finding finding{info.name, info.role, false, false, {}, {}, {}, 0};
  finding.remedy = "apt-get install " + packages_of(info.name, info.package);
  if (find_program(info.program).empty()) {
    finding.text = fmt::format("the program '{}' is not there", info.program);
    return finding;
  }
  finding.version = record::package_version(info.package);
  const SystemClock clock;
  const double start = clock.now();
  try {
    workflow::Stage stage;
    stage.name = info.name;
    stage.program = trial.solver == "yade"      ? workflow::Program::yade
                    : trial.solver == "freefem" ? workflow::Program::freefem
                    : trial.solver == "gmsh"    ? workflow::Program::gmsh
                                                : workflow::Program::python;
    const std::string script = folder + "/" + trial.file;
    write_file(script, trial.script);
    Command command = stage_command(home, stage, script);
    command.directory = folder;
    command.log = folder + "/" + info.name + ".log";
    run_to_end(info.name, command, 60);
    finding.good = read_file(command.log).find(trial.expected) != std::string::npos;
    finding.text = finding.good ? trial.success : "its trial ended without the expected answer";
  } catch (const Error& error) {
    if (error.code() == ExitCode::interrupted) throw;
    finding.text = error.what();
  }
  finding.seconds = clock.now() - start;
  return finding;
}

Finding check_exchange(const std::string& folder) {
  Finding finding{"exchange", "memory-mapped HDF5 files",   false, false, hdf5::library_version(),
                  {},         "use a local disk for --out", 0};
  try {
    exchange::Slot slot(folder + "/slot.h5", "doctor", {{"field", "1", {3}}}, {}, true);
    const std::vector<double> values = {1, 2, 3};
    slot.give(0, values, {3});
    const hdf5::File file(slot.path(), hdf5::File::Mode::read);
    finding.good = file.read_numbers("/in/field/values") == values;
    finding.text = finding.good ? "what was written through memory is read from the file"
                                : "what was written through memory does not arrive in the file";
  } catch (const Error& error) {
    finding.text = error.what();
  }
  return finding;
}

}  // namespace

void examine(const Home& home, const std::function<void(const Finding&)>& found) {
  Interrupt::install();
  const TemporaryFolder folder;
  for (const Trial& trial : trials()) found(run_trial(home, trial, folder.path()));
  found(check_exchange(folder.path()));
}

}  // namespace sandglass::run
