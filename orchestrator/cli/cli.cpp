#include "cli/cli.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "cli/terminal.hpp"
#include "run/home.hpp"

namespace sandglass::cli {
namespace {

constexpr const char* kExitCodes =
    "Exit status: 0 done, all comparisons within tolerance; 2 usage; 3 workflow refused;\n"
    "4 participant failed; 5 numerically unstable; 6 comparison out of tolerance;\n"
    "7 environment (solver missing, disk full, directory in use); 130 interrupted.";

void print_error(const Error& error) {
  for (const Problem& problem : error.problems()) {
    tell("sandglass: {}\n", problem.text());
  }
}

/// The first files that a program opens would else take the places of streams that were closed, and
/// messages would go into them.
void hold_standard_streams() {
  while (true) {
    const int descriptor = ::open("/dev/null", O_RDWR);
    if (descriptor > STDERR_FILENO) ::close(descriptor);
    if (descriptor < 0 || descriptor > STDERR_FILENO) return;
  }
}

/// Throws Error::usage for a verb that there is not.
void require_verb(const CLI::App& app, const std::vector<std::string>& command) {
  if (command.size() < 2 || command[1].empty() || command[1][0] == '-') return;
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    verbs.push_back(verb->get_name());
  }
  if (std::find(verbs.begin(), verbs.end(), command[1]) != verbs.end()) return;
  throw Error::usage(fmt::format("there is no verb '{}'", command[1]),
                     suggestion(command[1], verbs));
}

/// The words behind the program's name, last first, as CLI11 wants them. A file behind --no-prune
/// is the workflow, not a name.
std::vector<std::string> words_of(const std::vector<std::string>& command) {
  std::vector<std::string> words(command.begin() + (command.empty() ? 0 : 1), command.end());
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    std::error_code error;
    if (words[i] == "--no-prune" && std::filesystem::is_regular_file(words[i + 1], error)) {
      std::swap(words[i], words[i + 1]);
    }
  }
  std::reverse(words.begin(), words.end());
  return words;
}

}  // namespace

CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& description,
                   const std::string& examples) {
  CLI::App* verb = app.add_subcommand(name, description);
  verb->footer("Examples:\n" + examples);
  return verb;
}

void WorkflowOptions::add_to(CLI::App& verb) {
  verb.add_option("file", file, "the workflow (YAML)")->required()->type_name("FILE");
  verb.add_option(
          "--set", settings,
          "override a parameter: a number with a unit (a bare number is SI), true or false, "
          "or a name from the parameter's list")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->take_all();
  no_prune = verb.add_option("--no-prune", keep,
                             "put back what this scene does not need: all of it, or these by name")
                 ->type_name("NAME")
                 ->expected(0, 1)
                 ->take_all();
}

workflow::LoadOptions WorkflowOptions::load_options() const {
  const run::Home home = run::Home::find();
  workflow::LoadOptions options;
  options.templates_root = home.templates();
  options.data_root = home.data();
  for (const std::string& text : settings) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw Error::usage(fmt::format("--set '{}' is not NAME=VALUE", text),
                         "write for example --set diameter='0.2 mm'");
    }
    options.settings.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  for (const std::string& name : keep) {
    if (!name.empty()) options.keep.push_back(name);
  }
  options.keep_all = no_prune->count() > 0 && options.keep.empty();
  return options;
}

workflow::Workflow WorkflowOptions::load() const { return workflow::load(file, load_options()); }

workflow::Workflow WorkflowOptions::load_as_written() const {
  workflow::LoadOptions options = load_options();
  options.settings.clear();
  options.keep.clear();
  return workflow::load(file, options);
}

int main_program(int argc, char** argv) {
  hold_standard_streams();
  CLI::App app{"Sandglass: coupled grain-continuum simulations from one YAML workflow"};
  app.name("sandglass");
  app.set_version_flag("--version", "sandglass " SANDGLASS_VERSION);
  app.footer(kExitCodes);
  app.require_subcommand(1);
  Session session;
  session.command.assign(argv, argv + argc);
  add_run(app, session);
  add_resume(app, session);
  add_analyse(app, session);
  add_replay(app, session);
  add_study(app, session);
  add_why(app, session);
  add_compare(app, session);
  add_check(app, session);
  add_plan(app, session);
  add_report(app, session);
  add_status(app, session);
  add_verify(app, session);
  add_profile(app, session);
  add_bench(app, session);
  add_doctor(app, session);
  add_setup(app, session);
  add_test(app, session);
  add_clean(app, session);
  add_reference(app, session);
  add_completion(app, session);
  try {
    require_verb(app, session.command);
    app.parse(words_of(session.command));
    return static_cast<int>(session.action());
  } catch (const CLI::ParseError& error) {
    // Help and version come this way too, with status 0.
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
  } catch (const Error& error) {
    print_error(error);
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    tell("sandglass: {}\n", error.what());
    return static_cast<int>(ExitCode::environment);
  }
}

}  // namespace sandglass::cli
