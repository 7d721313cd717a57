#pragma once

#include <functional>
#include <string>
#include <vector>

namespace sandglass::study {

/// A point to be run: a program of its own, so that whatever happens to it happens to it alone.
struct Task {
  std::string point;
  std::vector<std::string> arguments;  ///< the program first
  std::string log;                     ///< receives what it says
};

/// Hears of the tasks as they go.
struct Listener {
  std::function<void(const std::string& point)> started = [](const std::string&) {};
  std::function<void(const std::string& point)> ended = [](const std::string&) {};
};

/// Runs the tasks, at most `jobs` at a time, and returns when all have ended, however. Throws
/// Error::interrupted when the user interrupts: what runs is asked to end, and ended.
void run_locally(const std::vector<Task>& tasks, int jobs, const Listener& listener);

/// The same on a cluster, as one job array by its own `sbatch --wait`. The script is rendered from
/// templates/slurm/study.sh into `folder`; the tasks' paths must mean the same on all nodes.
/// `jobs` limits how many run at a time (0: the cluster decides). Partition, account, time limit
/// and so on come from sbatch's own environment variables (SBATCH_PARTITION, ...). Throws
/// Error::environment when there is no sbatch or it refuses the job.
void run_by_slurm(const std::vector<Task>& tasks, int jobs, const std::string& name,
                  const std::string& folder, const std::string& templates_root);

}  // namespace sandglass::study
