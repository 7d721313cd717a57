#pragma once

#include <string>
#include <vector>

#include "record/provenance.hpp"
#include "record/run_directory.hpp"
#include "run/home.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// What a run began with, kept in run.json of its directory before anything is started: enough to
/// go on with it, to repeat it, and to know whether what it is made of has changed.
struct Beginning {
  std::string started;               ///< date and time
  std::vector<std::string> resumed;  ///< dates and times
  std::vector<std::string> command;  ///< the first one
  std::string workflow_path;         ///< as given
  std::string workflow_digest;
  workflow::Changes changes;
  std::vector<record::UsedFile> templates;  ///< relative to the project
  std::vector<record::UsedFile> data;
  std::string analyses_of;  ///< in a folder of `analyse`: the run whose record it holds
};

/// Makes and stores the beginning of a new run; workflow.yaml is in the directory already.
Beginning begin_run(const workflow::Workflow& workflow, const Home& home,
                    const std::vector<std::string>& command, const record::RunDirectory& directory);
/// Throws Error::environment when `directory` is no run directory, or nothing was begun in it.
Beginning read_beginning(const std::string& directory);
/// The same of a folder that holds the analyses of the run in `directory`.
void begin_analyses(Beginning beginning, const std::string& directory,
                    const record::RunDirectory& analyses);
/// Stores that the run goes on now.
void go_on(Beginning& beginning, const record::RunDirectory& directory);

/// The workflow as it was given to the run. Throws Error::refused when its file was altered.
workflow::Workflow load_again(const Beginning& beginning, const Home& home,
                              const std::string& directory);
/// Throws Error::refused naming every template and data file that is not what it was.
void require_unchanged(const Beginning& beginning, const workflow::Workflow& workflow,
                       const Home& home);
/// Removes what a run that ended before its time has left and nobody needs: slots, work
/// directories, stages that did not come to their end, and what was said of its end.
void clear_unfinished(const record::RunDirectory& directory);

/// The files below data/ that stages, participants and comparisons name.
std::vector<record::UsedFile> data_files(const workflow::Workflow& workflow, const Home& home);

}  // namespace sandglass::run
