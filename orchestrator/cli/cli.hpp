#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "run/run.hpp"
#include "workflow/model.hpp"

/// The command line: one file per verb. Nothing below this room prints.
namespace sandglass::cli {

/// Parses the command line, executes the verb, prints errors; returns the exit status.
int main_program(int argc, char** argv);

/// What a verb does once the command line is understood.
using Action = std::function<ExitCode()>;

/// The command line as given, and the action that the chosen verb sets.
struct Session {
  std::vector<std::string> command;
  Action action;
};

void add_run(CLI::App& app, Session& session);
void add_resume(CLI::App& app, Session& session);
void add_analyse(CLI::App& app, Session& session);
void add_replay(CLI::App& app, Session& session);
void add_study(CLI::App& app, Session& session);
void add_why(CLI::App& app, Session& session);
void add_compare(CLI::App& app, Session& session);
void add_check(CLI::App& app, Session& session);
void add_plan(CLI::App& app, Session& session);
void add_report(CLI::App& app, Session& session);
void add_status(CLI::App& app, Session& session);
void add_verify(CLI::App& app, Session& session);
void add_profile(CLI::App& app, Session& session);
void add_bench(CLI::App& app, Session& session);
void add_doctor(CLI::App& app, Session& session);
void add_setup(CLI::App& app, Session& session);
void add_test(CLI::App& app, Session& session);
void add_clean(CLI::App& app, Session& session);
void add_reference(CLI::App& app, Session& session);
void add_completion(CLI::App& app, Session& session);

/// A verb with its examples, which end its help.
CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& description,
                   const std::string& examples);

/// Prints what came of a run: comparisons, time, where to look. Returns the exit status.
ExitCode show_ended(const run::Ended& ended);

/// The options of every verb that reads a workflow: FILE, --set, --no-prune.
struct WorkflowOptions {
  std::string file;
  std::vector<std::string> settings;
  std::vector<std::string> keep;
  CLI::Option* no_prune = nullptr;

  void add_to(CLI::App& verb);
  /// What was chosen, without the file. Throws Error::usage.
  [[nodiscard]] workflow::LoadOptions load_options() const;
  /// Reads and checks the workflow. Throws what workflow::load throws.
  [[nodiscard]] workflow::Workflow load() const;
  /// The same as it is written: what was chosen may be for the workflow that a study names.
  [[nodiscard]] workflow::Workflow load_as_written() const;
};

}  // namespace sandglass::cli
