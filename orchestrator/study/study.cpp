#include "study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "base/file.hpp"
#include "process/interrupt.hpp"
#include "run/run.hpp"
#include "run/solvers.hpp"
#include "study/made_of.hpp"
#include "study/summary.hpp"
#include "study/table.hpp"
#include "workflow/json.hpp"

namespace sandglass::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t most_problems = 20;

/// The study file itself: its points are settings of the workflow it names, not of itself.
workflow::Workflow load_study(const Options& options) {
  workflow::LoadOptions load = options.load;
  load.settings.clear();
  load.keep.clear();
  workflow::Workflow file = workflow::load(options.file, load);
  if (!file.study) {
    throw Error::usage(fmt::format("'{}' has no 'study'", options.file),
                       "give it one (workflows/README.md), or use 'sandglass run'");
  }
  return file;
}

/// Everything about a point that is known before it runs.
struct Prepared {
  Point point;
  MadeOf made_of;
  std::size_t runs_as = 0;  ///< index of the point whose run is its own: itself, or its twin's
  nlohmann::ordered_json parameters;
  std::vector<workflow::LeftOut> left_out;
};

class Study {
 public:
  Study(const Options& options, const run::Home& home)
      : options_(options),
        home_(home),
        file_(load_study(options)),
        base_(file_.study->of.empty() ? options.file : file_.study->of),
        directory_(fs::absolute(options.out.empty() ? options.runs + "/" + file_.name : options.out)
                       .lexically_normal()
                       .string()),
        memory_(directory_.file("memory.json")) {}

  /// Without loading a single point: the files look as they did, and all results are there.
  bool unchanged(Ended& ended) {
    const std::string path = directory_.file("seen.json");
    std::error_code error;
    if (options_.again || !fs::exists(path, error)) return false;
    const json seen = json::parse(read_file(path), nullptr, false);
    if (!seen.is_object() || seen.value("call", "") != call()) return false;
    for (const auto& [name, found] : seen.at("programs").items()) {
      if (find_program(name) != found) return false;
    }
    for (const json& run : seen.at("runs")) {
      if (!fs::exists(directory_.run_of(run) + "/result.json", error)) return false;
    }
    if (!memory_.all_unchanged()) return false;
    ended.code = static_cast<ExitCode>(seen.at("code").get<int>());
    ended.error = seen.at("error");
    ended.points = seen.at("points");
    ended.twins = seen.at("twins");
    ended.reused = ended.points;
    for (const json& one : seen.at("failed")) ended.failed.push_back({one.at(0), one.at(1)});
    for (const json& one : seen.at("outside")) ended.outside.push_back({one.at(0), one.at(1)});
    ended.unchanged = true;
    locate(ended);
    return true;
  }

  void prepare() {
    Ingredients ingredients(home_, memory_);
    std::vector<Problem> problems;
    std::set<std::string> said;
    std::map<std::string, std::size_t> first_of_key;
    memory_.look(options_.file);
    memory_.look(base_);
    for (Point& point : make_points(*file_.study, options_.load.settings)) {
      workflow::LoadOptions load = options_.load;
      load.settings = point.settings;
      try {
        const workflow::Workflow workflow = workflow::load(base_, load);
        if (workflow.study && !workflow.study->of.empty()) {
          throw Error::refused(file_.study->place, fmt::format("'{}' is a study itself", base_),
                               "sweep the workflow that it sweeps");
        }
        for (const std::string& name : run::solvers_of(workflow)) {
          const std::string& program = run::solver(name).program;
          programs_[program] = find_program(program);
        }
        Prepared one{std::move(point), ingredients.of(workflow), points_.size(), {}, {}};
        for (const workflow::LeftOut& item : workflow.left_out) {
          if (item.active) one.left_out.push_back(item);
        }
        const nlohmann::ordered_json resolved = workflow::to_json(workflow);
        for (const auto& [name, parameter] : resolved.at("parameters").items()) {
          one.parameters[name] = parameter.at("value");
        }
        const std::string key = fmt::format("{} {}", key_of(one.made_of), one.point.repetition);
        one.runs_as = first_of_key.emplace(key, points_.size()).first->second;
        points_.push_back(std::move(one));
      } catch (const Error& error) {
        if (error.code() != ExitCode::refused && error.code() != ExitCode::usage) throw;
        for (const Problem& problem : error.problems()) {
          if (said.insert(problem.text()).second) problems.push_back(problem);
        }
        if (problems.size() > most_problems) break;
      }
    }
    if (!problems.empty()) throw Error::refused(std::move(problems));
  }

  /// Why the point has to be run; empty when its result is good.
  [[nodiscard]] std::vector<std::string> reasons(const Prepared& one) const {
    const MadeOf before = directory_.made_of(one.point.name);
    const Outcome outcome = directory_.outcome(one.point.name);
    std::error_code unseen;
    // What a point would be made of is noted before its turn comes.
    const bool begun = fs::exists(directory_.run_of(one.point.name), unseen);
    if (before.parts.empty() || !begun) return {"was never run"};
    std::vector<std::string> lines = differences(before, one.made_of);
    if (!lines.empty()) return lines;
    if (outcome.state == Outcome::State::running) return {"is running"};
    if (can_go_on(one)) return {"its run was ended on its way: it goes on behind a checkpoint"};
    if (outcome.state == Outcome::State::left) return {"its run ended without a result"};
    if (outcome.final()) return {};
    return {fmt::format("its run failed: {}", outcome.result->error)};
  }

  [[nodiscard]] std::vector<Reason> all_reasons() const {
    std::vector<Reason> all;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].runs_as == i) all.push_back({points_[i].point.name, reasons(points_[i])});
    }
    return all;
  }

  [[nodiscard]] Plan plan() const {
    Plan plan{points_.size(), 0, all_reasons(), {}};
    plan.twins = plan.points - plan.reasons.size();
    std::map<std::string, std::size_t> known;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].runs_as != i) continue;
      const Outcome outcome = directory_.outcome(points_[i].point.name);
      for (const workflow::LeftOut& item : points_[i].left_out) {
        const auto [found, is_new] = known.emplace(item.name, plan.left_out.size());
        if (is_new) plan.left_out.push_back({item.name, item.what, item.why});
        add_measured(outcome, plan.left_out[found->second]);
      }
    }
    return plan;
  }

  void run_points(const Listener& listener) {
    require_none_running();
    write_entries();
    std::vector<Task> tasks;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Prepared& one = points_[i];
      if (one.runs_as != i) continue;
      if (!options_.again && reasons(one).empty()) {
        ++reused_;
        continue;
      }
      if (can_go_on(one)) {
        tasks.push_back(going_on_with(one.point));
        continue;
      }
      directory_.prepare(one.point.name, one.made_of);
      tasks.push_back(task_of(one.point));
    }
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    if (options_.slurm) {
      run_by_slurm(tasks, options_.jobs, file_.name, directory_.file("slurm"), home_.templates());
    } else {
      run_locally(tasks, options_.jobs > 0 ? options_.jobs : cores, listener);
    }
  }

  Ended conclude(run::Status& status) {
    Ended ended;
    ended.points = points_.size();
    std::vector<Row> rows;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Prepared& one = points_[i];
      const std::string& run = points_[one.runs_as].point.name;
      rows.push_back({&one.point, run, directory_.outcome(run), one.parameters});
      if (one.runs_as != i) ++ended.twins;
      judge(rows.back(), ended);
    }
    ended.reused = reused_;
    std::error_code ignored;
    fs::remove_all(directory_.summary(), ignored);
    run::Options summary;
    summary.out = directory_.summary();
    summary.command = options_.command;
    summary.files = {{"points.json", table_to_json(rows, directory_)},
                     {"points.csv", table_to_csv(rows)}};
    const workflow::Workflow over_all = summary_of(file_);
    const run::Ended seen = run::execute(over_all, home_, summary, status);
    ended.code = seen.code;
    ended.error = seen.error;
    if (ended.code == ExitCode::done && file_.study->judge && !ended.outside.empty()) {
      ended.code = ExitCode::mismatch;
    }
    if (!ended.failed.empty() && seen.code != ExitCode::interrupted) {
      ended.code = ExitCode::participant;
    }
    locate(ended);
    keep(over_all, rows, ended);
    return ended;
  }

  [[nodiscard]] const StudyDirectory& directory() const { return directory_; }

 private:
  /// One that somebody else runs or replays: its folder is not ours to move.
  void require_none_running() const {
    for (const Prepared& one : points_) {
      const std::string& name = one.point.name;
      if (directory_.outcome(name).state != Outcome::State::running) continue;
      throw Error::environment(
          fmt::format("point '{}' is in use by another process", name),
          fmt::format("wait for it ('sandglass status {}' shows it), or end it",
                      directory_.run_of(name)));
    }
  }

  static void add_measured(const Outcome& outcome, LeftOut& item) {
    ++item.points;
    if (!outcome.result) return;
    for (const report::Saving& one : outcome.result->left_out) {
      if (one.name != item.name || !one.saving_s) continue;
      ++item.measured;
      item.saved += *one.saving_s;
    }
  }

  /// Killed or interrupted on its way, behind a checkpoint, and made of the same as now. What
  /// failed by itself is run anew.
  [[nodiscard]] bool can_go_on(const Prepared& one) const {
    const MadeOf before = directory_.made_of(one.point.name);
    if (options_.again || before.parts.empty() || !differences(before, one.made_of).empty()) {
      return false;
    }
    const Outcome outcome = directory_.outcome(one.point.name);
    const bool interrupted =
        outcome.result && static_cast<ExitCode>(outcome.result->exit_code) == ExitCode::interrupted;
    return (outcome.state == Outcome::State::left || interrupted) &&
           directory_.has_checkpoint(one.point.name);
  }

  [[nodiscard]] Task going_on_with(const Point& point) const {
    return {point.name,
            {fs::read_symlink("/proc/self/exe").string(), "resume", directory_.run_of(point.name)},
            directory_.log_of(point.name)};
  }

  [[nodiscard]] Task task_of(const Point& point) const {
    Task task{point.name, {}, directory_.log_of(point.name)};
    task.arguments = {fs::read_symlink("/proc/self/exe").string(), "run", base_};
    for (const workflow::Setting& setting : point.settings) {
      task.arguments.insert(task.arguments.end(), {"--set", setting.name + "=" + setting.text});
    }
    if (options_.load.keep_all) task.arguments.emplace_back("--no-prune");
    for (const std::string& name : options_.load.keep) {
      task.arguments.insert(task.arguments.end(), {"--no-prune", name});
    }
    task.arguments.insert(task.arguments.end(), {"--out", directory_.run_of(point.name)});
    return task;
  }

  void write_entries() const {
    std::vector<StudyDirectory::Entry> entries;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Prepared& one = points_[i];
      entries.push_back({one.point.name,
                         one.runs_as == i ? std::string() : points_[one.runs_as].point.name,
                         one.point.unstable});
    }
    directory_.write(options_.file, entries);
  }

  void judge(const Row& row, Ended& ended) const {
    const Outcome& outcome = row.outcome;
    const Point& point = *row.point;
    if (!outcome.good(point)) {
      std::string error = outcome.result ? outcome.result->error : std::string();
      if (error.empty() && outcome.final()) {
        error = point.unstable ? "it ended well, but was expected to be unstable" : "";
      }
      if (error.empty()) error = "it left no result\n" + end_of_log(directory_.log_of(row.run));
      ended.failed.push_back({point.name, error});
    } else if (static_cast<ExitCode>(outcome.result->exit_code) == ExitCode::mismatch) {
      ended.outside.push_back({point.name, outcome.result->error});
    }
  }

  void locate(Ended& ended) const {
    ended.directory = directory_.path();
    const std::string report = directory_.summary() + "/report.html";
    std::error_code error;
    if (fs::exists(report, error)) ended.report = report;
  }

  /// What was asked for, apart from what is in files.
  [[nodiscard]] std::string call() const {
    json asked = {fs::absolute(options_.file).string(),
                  options_.load.keep_all,
                  options_.load.keep,
                  fs::read_symlink("/proc/self/exe").string(),
                  home_.root,
                  home_.build};
    for (const auto& one : options_.load.settings) asked.push_back({one.name, one.text});
    return digest_of_text(asked.dump());
  }

  /// For the next call, when there is nothing left to do: what was looked at, and what came out.
  void keep(const workflow::Workflow& over_all, const std::vector<Row>& rows, const Ended& ended) {
    Ingredients(home_, memory_).of(over_all);
    memory_.look(fs::read_symlink("/proc/self/exe").string());
    memory_.keep();
    std::error_code ignored;
    fs::remove(directory_.file("seen.json"), ignored);
    const bool complete =
        std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.outcome.final(); });
    const bool concluded = fs::exists(directory_.summary() + "/result.json", ignored);
    if (!complete || !concluded || Interrupt::requested()) return;
    const auto pairs = [](const std::vector<Blemish>& blemishes) {
      json all = json::array();
      for (const Blemish& one : blemishes) all.push_back({one.point, one.error});
      return all;
    };
    json runs = json::array();
    for (const Row& row : rows) runs.push_back(row.run);
    const json seen = {{"format", 1},
                       {"call", call()},
                       {"programs", programs_},
                       {"runs", runs},
                       {"points", ended.points},
                       {"twins", ended.twins},
                       {"code", static_cast<int>(ended.code)},
                       {"error", ended.error},
                       {"failed", pairs(ended.failed)},
                       {"outside", pairs(ended.outside)}};
    write_file(directory_.file("seen.json"), seen.dump(1) + "\n");
  }

  const Options& options_;
  const run::Home& home_;
  workflow::Workflow file_;
  std::string base_;
  StudyDirectory directory_;
  FileMemory memory_;
  std::vector<Prepared> points_;
  std::map<std::string, std::string> programs_;
  std::size_t reused_ = 0;
};

}  // namespace

Ended execute(const Options& options, const run::Home& home, const Listener& listener,
              run::Status& status) {
  Interrupt::install();
  Study study(options, home);
  make_directories(study.directory().path());
  study.directory().require_own();
  const auto lock = record::RunDirectory::open(study.directory().path());
  Ended ended;
  if (study.unchanged(ended)) return ended;
  study.prepare();
  study.run_points(listener);
  return study.conclude(status);
}

Plan plan(const Options& options, const run::Home& home) {
  Study study(options, home);
  study.prepare();
  return study.plan();
}

std::vector<Reason> why(const Options& options, const run::Home& home) {
  Study study(options, home);
  study.prepare();
  return study.all_reasons();
}

}  // namespace sandglass::study
