#include <fmt/format.h>

#include <filesystem>

#include "base/error.hpp"
#include "base/file.hpp"
#include "process/process.hpp"
#include "render/template.hpp"
#include "study/executor.hpp"

namespace sandglass::study {
namespace {

constexpr double kLongest = 3e7;  // s, a year: how long a cluster takes is its own affair

/// The number that sbatch gave the job; empty when it took none.
std::string submitted_job(const std::string& log) {
  static const std::string said = "Submitted batch job ";
  std::error_code none;
  const std::string text = std::filesystem::exists(log, none) ? read_file(log) : std::string();
  const std::size_t at = text.find(said);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + said.size();
  return text.substr(begin, text.find_first_not_of("0123456789", begin) - begin);
}

}  // namespace

void run_by_slurm(const std::vector<Task>& tasks, int jobs, const std::string& name,
                  const std::string& folder, const std::string& templates_root) {
  if (tasks.empty()) return;
  if (find_program("sbatch").empty()) {
    throw Error::environment(
        "there is no 'sbatch' here",
        "log in to a node from which jobs are submitted, or leave out --slurm");
  }
  Value::List list;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const auto& words = tasks[i].arguments;
    list.push_back(Value::Map{{"number", static_cast<std::int64_t>(i)},
                              {"log", tasks[i].log},
                              {"arguments", Value::List(words.begin(), words.end())}});
  }
  make_directories(folder);
  const std::string script = folder + "/study.sh";
  write_file(script, Template::load(templates_root, "slurm/study.sh").render({{"tasks", list}}));
  Command command;
  command.arguments = {
      "sbatch",
      "--wait",
      "--job-name=" + name,
      "--output=" + folder + "/%A_%a.log",
      fmt::format("--array=0-{}{}", tasks.size() - 1, jobs > 0 ? fmt::format("%{}", jobs) : ""),
      script};
  command.log = folder + "/sbatch.log";
  // What an earlier call was told is not said of this one.
  std::error_code none;
  std::filesystem::remove(command.log, none);
  try {
    run_to_end("sbatch", command, kLongest);
  } catch (const Error& error) {
    const std::string job = submitted_job(command.log);
    if (error.code() == ExitCode::interrupted && !job.empty()) {
      throw Error::interrupted(fmt::format(
          "interrupted; its job {} goes on: 'scancel {}' ends it, or call again when it has ended",
          job, job));
    }
    if (error.code() != ExitCode::participant) throw;
    // It fails as well when a task did: the points themselves say which and why.
    if (!job.empty()) return;
    Problem problem = error.problems().front();
    problem.remedy =
        "what sbatch needs (partition, account, ...) it also reads from "
        "SBATCH_PARTITION, SBATCH_ACCOUNT and so on";
    throw Error(ExitCode::environment, {problem});
  }
}

}  // namespace sandglass::study
