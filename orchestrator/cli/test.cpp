#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <thread>

#include "base/file.hpp"
#include "cli/cli.hpp"
#include "run/home.hpp"

namespace sandglass::cli {
namespace {

ExitCode execute(const std::vector<std::string>& more) {
  const std::string program = find_program("ctest");
  if (program.empty()) throw Error::environment("ctest is not there", "apt-get install cmake");
  std::vector<std::string> arguments = {
      "ctest",
      "--test-dir",
      run::Home::find().build,
      "--output-on-failure",
      "--parallel",
      std::to_string(std::max(1U, std::thread::hardware_concurrency()))};
  arguments.insert(arguments.end(), more.begin(), more.end());
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
  throw_system_error("execute", program, errno);
}

}  // namespace

void add_test(CLI::App& app, Session& session) {
  CLI::App* verb = add_verb(app, "test", "run the project's tests (ctest); more arguments go to it",
                            "  sandglass test\n"
                            "  sandglass test -L unit\n"
                            "  sandglass test -R stokes --verbose");
  verb->prefix_command();
  verb->callback(
      [&session, verb] { session.action = [verb] { return execute(verb->remaining()); }; });
}

}  // namespace sandglass::cli
