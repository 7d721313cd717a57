#include "run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "base/clock.hpp"
#include "base/file.hpp"
#include "base/unit.hpp"
#include "hdf5/hdf5.hpp"
#include "process/interrupt.hpp"
#include "record/checkpoint.hpp"
#include "record/crate.hpp"
#include "record/provenance.hpp"
#include "record/record.hpp"
#include "report/analysis.hpp"
#include "report/compare.hpp"
#include "report/page.hpp"
#include "report/result.hpp"
#include "run/beginning.hpp"
#include "run/coupled_stage.hpp"
#include "run/products.hpp"
#include "run/solvers.hpp"
#include "run/stage.hpp"
#include "run/status_file.hpp"
#include "workflow/json.hpp"

namespace sandglass::run {
namespace {

/// Room on the disk for the result, kept free until the end: a full disk must not cost it.
constexpr const char* kReserve = "reserve";
constexpr std::size_t kReserveBytes = 262144;

std::vector<record::UsedProgram> identify_all(const Home& home,
                                              const std::set<std::string>& names) {
  std::vector<record::UsedProgram> used;
  for (const std::string& name : names) used.push_back(identify_solver(home, name));
  return used;
}

void write_report(const std::string& directory, const Home& home) {
  report::ReportTools tools;
  tools.templates_root = home.templates();
  report::write_report(directory, tools);
}

/// What of a workflow is done.
enum class Part {
  whole,
  rest,      ///< of a run that was begun before
  analyses,  ///< of what another run has made, copied into the directory
};

class Run {
 public:
  /// `beginning` is that of the run to go on with or to analyse.
  Run(const workflow::Workflow& workflow, const Home& home, const Options& options, Status& status,
      record::RunDirectory directory, Part part = Part::whole,
      std::optional<Beginning> beginning = std::nullopt)
      : workflow_(workflow),
        home_(home),
        options_(options),
        started_(clock_.now()),
        directory_(std::move(directory)),
        scripts_(home.templates(), directory_.folder("scripts")),
        status_(directory_.file("status.json"), status),
        part_(part) {
    if (part == Part::whole) {
      write_file(directory_.file("workflow.yaml"), read_file(workflow.path));
      beginning = begin_run(workflow, home, options.command, directory_);
    }
    beginning_ = std::move(*beginning);
    write_file(directory_.file(kReserve), std::string(kReserveBytes, '0'));
    progress_.name = std::filesystem::path(directory_.path()).filename().string();
  }

  Ended execute() {
    Ended ended;
    ended.directory = directory_.path();
    try {
      begin("prepare");
      prepare();
      run_stages();
      conclude();
    } catch (const Error& error) {
      result_.exit_code = static_cast<int>(error.code());
      result_.status = report::status_name(error.code());
      result_.error = error.what();
    } catch (const std::exception& error) {
      result_.exit_code = static_cast<int>(ExitCode::environment);
      result_.status = report::status_name(ExitCode::environment);
      result_.error = error.what();
    }
    close(ended);
    ended.code = static_cast<ExitCode>(result_.exit_code);
    ended.error = result_.error;
    ended.went_on_behind = outcome_.windows_taken;
    return ended;
  }

 private:
  void begin(const std::string& stage) {
    progress_.stage = stage;
    progress_.elapsed = clock_.now() - started_;
    status_.begin(progress_);
  }

  void prepare() {
    write_file(directory_.file("workflow.json"),
               workflow::to_json(workflow_).dump(1, ' ', false,
                                                 nlohmann::ordered_json::error_handler_t::replace) +
                   "\n");
    for (const auto& [name, text] : options_.files) write_file(directory_.file(name), text);
    for (const std::string& name : solvers_of(workflow_)) require_installed(home_, name);
    for (const workflow::Participant& one : workflow_.participants) {
      require_environment(home_, one.command);
    }
    // Reading whole solvers takes a while: it is done while they start.
    solvers_ = std::async(std::launch::async, identify_all, home_, solvers_of(workflow_)).share();
  }

  void run_stages() {
    for (const workflow::Stage& stage : workflow_.stages) {
      begin(stage.name);
      const double start = clock_.now();
      auto& [began, ended] = stage_times_[stage.name];
      began = seconds_since_1970();
      if (stage.program == workflow::Program::coupling) {
        couple();
      } else {
        make(stage);
      }
      stage_seconds_[stage.name] += clock_.now() - start;
      ended = seconds_since_1970();
    }
  }

  /// Runs a stage, or takes over what is there: of this run before it was resumed, or kept from
  /// another one.
  void make(const workflow::Stage& stage) {
    const double start = clock_.now();
    if (part_ != Part::whole && !stage.analysis) {
      if (const auto made = made_in(directory_.file("stages/" + stage.name))) {
        return made->taken ? take(stage, *made) : go_on_with(stage, *made);
      }
    }
    if (part_ == Part::analyses && !stage.analysis) {
      throw Error::environment(fmt::format("the run has not come to stage {}", stage.name),
                               "wait for it");
    }
    std::string made_of;
    if (stage.reuse) {
      made_of = KeptProducts::made_of(stage, home_, directory_, scripts_, program_of(stage));
      if (const auto made = kept_.take(stage, made_of, directory_)) return take(stage, *made);
    }
    const Exit ended = run_stage(stage, home_, directory_, scripts_);
    peak_memory_[stage.name] = ended.peak_memory_bytes;
    if (stage.analysis) return;
    store_made(stage, directory_, made_of, clock_.now() - start);
    if (stage.reuse) kept_.keep(stage, made_of, directory_);
  }

  /// Another run made the stage's products.
  void take(const workflow::Stage& stage, const Made& made) {
    made_before_[stage.name] = made.seconds;
    result_.left_out.push_back(
        {stage.name, "stage " + stage.name,
         fmt::format("made of the same before (digest {}), and kept", made.made_of.substr(0, 16)),
         made.seconds});
  }

  /// An earlier part of this run made the stage's products.
  void go_on_with(const workflow::Stage& stage, const Made& made) {
    stage_seconds_[stage.name] = made.seconds;
    seconds_of_earlier_stages_ += made.seconds;
  }

  /// Its program as the provenance knows it; a command's is known by its words.
  [[nodiscard]] record::UsedProgram program_of(const workflow::Stage& stage) const {
    const std::string name = solver_name(stage.program);
    for (const record::UsedProgram& used : solvers_.get()) {
      if (used.name == name) return used;
    }
    return {};
  }

  /// A run that goes on does so behind its newest checkpoint that the record reaches.
  [[nodiscard]] Span span() const {
    Span span;
    span.began = started_;
    span.checkpoints = &directory_;
    if (part_ == Part::whole) return span;
    const record::Checkpoints checkpoints(directory_);
    span.behind = checkpoints.newest(workflow_.coupling->windows).value_or(0);
    checkpoints.drop_behind(span.behind);
    return span;
  }

  void couple() {
    if (part_ == Part::analyses) return take_windows();
    const double start = clock_.now();
    const Span span = this->span();
    progress_.windows = workflow_.coupling->windows;
    progress_.end = static_cast<double>(progress_.windows) * workflow_.coupling->window;
    run_coupling(workflow_, home_, directory_, scripts_, span, outcome_,
                 [&](std::int64_t window, double time) {
                   const double now = clock_.now();
                   progress_.window = window;
                   progress_.time = time;
                   progress_.elapsed = now - started_;
                   progress_.rate = static_cast<double>(window - span.behind) /
                                    std::max(1e-9, now - start - outcome_.start_seconds);
                   progress_.left =
                       static_cast<double>(progress_.windows - window) / progress_.rate;
                   status_.window(progress_);
                 });
  }

  /// The coupling is what the record has of it.
  void take_windows() {
    const workflow::Coupling& coupling = *workflow_.coupling;
    const std::string record = directory_.file("record.h5");
    const std::int64_t windows = record::windows_of(record);
    outcome_ = outcome_of_record(coupling, record, windows);
    outcome_.elapsed_before += seconds_of_earlier_stages_;
    if (windows == coupling.windows) return;
    add_note(fmt::format("coupling: {} of {} windows, as far as the run had come", windows,
                         coupling.windows));
  }

  /// Quantities and comparisons; the verdict.
  void conclude() {
    std::vector<std::string> stages;
    for (const workflow::Stage& stage : workflow_.stages) {
      if (stage.analysis) stages.push_back(stage.name);
    }
    const report::Analysis analysis = report::read_analyses(directory_.path(), stages);
    report::add_analysis(result_, analysis);
    result_.comparisons = report::compare(workflow_, analysis, home_.data());
    const ExitCode verdict = report::verdict(result_.comparisons);
    result_.exit_code = static_cast<int>(verdict);
    result_.status = report::status_name(verdict);
    if (verdict == ExitCode::mismatch) result_.error = mismatch_text();
  }

  [[nodiscard]] std::string mismatch_text() const {
    std::string text;
    for (const report::ComparisonResult& one : result_.comparisons) {
      if (!one.passed || *one.passed) continue;
      const bool defined = one.value && std::isfinite(*one.value);
      text += fmt::format("\n  '{}': its {} is {}, the tolerance {} ({})", one.name, one.metric,
                          defined ? shortest(*one.value) : "not a finite number",
                          shortest(one.tolerance), one.because);
    }
    return "out of tolerance:" + text;
  }

  /// Writes what is to be kept, whatever happened before.
  void close(Ended& ended) {
    std::error_code ignored;
    std::filesystem::remove(directory_.file(kReserve), ignored);
    result_.windows = outcome_.windows;
    if (outcome_.windows > outcome_.windows_taken) {
      result_.overhead_s_per_window = outcome_.overhead_per_window();
    }
    if (outcome_.windows > 0) add_left_out();
    for (const std::string& note : outcome_.notes) add_note(note);
    result_.wall_time_s = wall_time();
    try {
      write_provenance();
      report::write_result(result_, directory_.path());
      if (!Interrupt::requested()) make_report(ended);
      record::write_crate(directory_.path());
    } catch (const Error& error) {
      fail_late(error);
    }
    progress_.stage = result_.status;
    progress_.left = 0;
    begin(result_.status);
  }

  /// All parts of a resumed run, as far as their work counts.
  [[nodiscard]] double wall_time() const {
    // A checkpoint knows of all before it.
    const double before =
        outcome_.windows_taken > 0 ? outcome_.elapsed_before : seconds_of_earlier_stages_;
    return before + clock_.now() - started_;
  }

  void make_report(Ended& ended) {
    begin("report");
    const double start = clock_.now();
    write_report(directory_.path(), home_);
    ended.report = directory_.file("report.html");
    report_seconds_ = clock_.now() - start;
    result_.wall_time_s = wall_time();
    write_provenance();
    report::write_result(result_, directory_.path());
  }

  /// The result could not be kept or shown: an error of its own, unless there is one already.
  void fail_late(const Error& error) {
    if (result_.exit_code == 0 || result_.exit_code == static_cast<int>(ExitCode::mismatch)) {
      result_.exit_code = static_cast<int>(error.code());
      result_.status = report::status_name(error.code());
      result_.error = error.what();
    } else {
      result_.error += std::string("\n") + error.what();
    }
    try {
      report::write_result(result_, directory_.path());
    } catch (const Error&) {
      // The same disk that refused before: the error is on its way to the user already.
    }
  }

  void add_left_out() {
    for (const std::string& field : workflow_.coupling->fields_left_out) {
      result_.left_out.push_back(
          {field, "field " + field, "nobody receives or records it", std::nullopt});
    }
    for (const workflow::LeftOut& one : workflow_.left_out) {
      if (!one.active) continue;
      report::Saving saving{one.name, one.what, one.why, std::nullopt};
      for (const participant::Saving& measured : outcome_.savings) {
        if (measured.name == one.name) saving.saving_s = measured.seconds;
      }
      result_.left_out.push_back(saving);
    }
  }

  void add_note(const std::string& note) {
    const size_t colon = note.find(": ");
    result_.notes.push_back({note.substr(0, colon), note.substr(colon + 2)});
  }

  void write_provenance() {
    nlohmann::json json;
    json["format"] = 1;
    json["started"] = beginning_.started;
    json["resumed"] = beginning_.resumed;
    json["ended"] = date_and_time();
    json["host"] = record::describe_machine();
    json["program"] = {{"name", "sandglass"},
                       {"version", SANDGLASS_VERSION},
                       {"digest", digest_of_file("/proc/self/exe")},
                       {"hdf5", hdf5::library_version()}};
    std::vector<std::string> command = options_.command;
    if (!command.empty()) command[0] = "sandglass";
    json["command"] = command;
    if (part_ == Part::analyses) {
      json["recorded_by"] = {{"command", beginning_.command},
                             {"templates", record::to_json(beginning_.templates)}};
    }
    json["workflow"] = {{"path", workflow_.path},
                        {"digest", digest_of_file(directory_.file("workflow.yaml"))}};
    json["solvers"] = nlohmann::json::array();
    if (solvers_.valid()) {
      for (const record::UsedProgram& used : solvers_.get()) {
        json["solvers"].push_back(record::to_json(used));
      }
    }
    json["templates"] = record::to_json(scripts_.template_files());
    json["scripts"] = nlohmann::json::array();
    for (const Scripts::Stored& stored : scripts_.stored()) {
      json["scripts"].push_back(
          {{"participant", stored.whose},
           {"template", stored.template_path},
           {"path", "scripts/" + std::filesystem::path(stored.path).filename().string()},
           {"digest", stored.digest}});
      if (!stored.windows.empty()) json["scripts"].back()["windows"] = stored.windows;
    }
    json["data"] = record::to_json(data_files(workflow_, home_));
    json["environment"] = record::describe_environment();
    json["timings"] = {
        {"participants", outcome_.participant_seconds},
        {"exchange", outcome_.exchange_seconds},
        {"record", outcome_.record_seconds},
        {"checkpoints", outcome_.checkpoint_seconds},
        {"render", scripts_.seconds()},
        {"orchestrator", outcome_.overhead_per_window() * static_cast<double>(outcome_.windows)},
        {"start", outcome_.start_seconds},
        {"stages", stage_seconds_},
        {"made_before", made_before_},
        {"report", report_seconds_}};
    for (const auto& [name, bytes] : outcome_.peak_memory_bytes) peak_memory_[name] = bytes;
    json["peak_memory_bytes"] = peak_memory_;
    for (const auto& [name, times] : stage_times_) {
      json["stages"][name] = {{"began", times.first}, {"ended", times.second}};
    }
    write_file(directory_.file("provenance.json"),
               json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  }

  const workflow::Workflow& workflow_;
  const Home& home_;
  const Options& options_;
  SystemClock clock_;
  double started_;
  record::RunDirectory directory_;
  Scripts scripts_;
  StatusFile status_;
  Progress progress_;
  Beginning beginning_;
  Part part_;
  report::Result result_;
  CoupledOutcome outcome_;
  std::shared_future<std::vector<record::UsedProgram>> solvers_;
  KeptProducts kept_;
  std::map<std::string, double> stage_seconds_;
  /// By seconds_since_1970; 0 for the end of one that failed.
  std::map<std::string, std::pair<double, double>> stage_times_;
  std::map<std::string, double> peak_memory_;
  /// By name of the stage, what making its products took another run.
  std::map<std::string, double> made_before_;
  double seconds_of_earlier_stages_ = 0;  ///< of this run, before it was resumed
  double report_seconds_ = 0;
};

}  // namespace

Ended execute(const workflow::Workflow& workflow, const Home& home, const Options& options,
              Status& status) {
  Interrupt::install();
  report::check_references(workflow, home.data());
  return Run(workflow, home, options, status,
             record::RunDirectory::create(options.out, options.runs, workflow.name))
      .execute();
}

Ended resume(const std::string& path, const Home& home, const Options& options, Status& status) {
  Interrupt::install();
  // Asked before there is a lock, and again behind it: a folder that is no run's gets none.
  static_cast<void>(read_beginning(path));
  record::RunDirectory directory = record::RunDirectory::open(path);
  Beginning beginning = read_beginning(directory.path());
  if (!beginning.analyses_of.empty()) {
    throw Error::environment(
        fmt::format("'{}' holds analyses of the run '{}', and no run to go on with", path,
                    beginning.analyses_of),
        fmt::format("sandglass analyse {}", beginning.analyses_of));
  }
  if (std::filesystem::exists(directory.file("result.json"))) {
    const report::Result result = report::read_result(directory.path());
    const auto code = static_cast<ExitCode>(result.exit_code);
    if (code == ExitCode::done || code == ExitCode::mismatch) {
      // It may have been killed while it was described.
      if (!std::filesystem::exists(directory.file(record::kCrateFile))) {
        write_report(directory.path(), home);
        record::write_crate(directory.path());
      }
      return {code, result.error, directory.path(), directory.file("report.html"), true};
    }
  }
  const workflow::Workflow workflow = load_again(beginning, home, directory.path());
  require_unchanged(beginning, workflow, home);
  clear_unfinished(directory);
  go_on(beginning, directory);
  return Run(workflow, home, options, status, std::move(directory), Part::rest,
             std::move(beginning))
      .execute();
}

Ended analyse(const std::string& path, const Home& home, const Options& options, Status& status) {
  namespace fs = std::filesystem;
  Interrupt::install();
  const fs::path run = path;
  const Beginning beginning = read_beginning(path);
  const workflow::Workflow workflow = load_again(beginning, home, path);
  const std::string record = run / "record.h5";
  const std::int64_t windows = record::windows_of(record);
  if (workflow.coupling && windows == 0) {
    throw Error::environment(fmt::format("'{}' has no recorded window", path), "wait for it");
  }
  record::RunDirectory directory =
      record::RunDirectory::create(options.out, options.runs, workflow.name + "-analysed");
  write_file(directory.file("workflow.yaml"), read_file(run / "workflow.yaml"));
  begin_analyses(beginning, path, directory);
  for (const workflow::Stage& stage : workflow.stages) {
    const std::string made = run / "stages" / stage.name;
    const auto what = made_in(made);
    if (what && !stage.analysis) copy_made(*what, made, directory.folder("stages/" + stage.name));
  }
  if (windows > 0) record::copy_windows(record, directory.file("record.h5"), windows);
  return Run(workflow, home, options, status, std::move(directory), Part::analyses, beginning)
      .execute();
}

std::vector<RenderedScript> dry_run(const workflow::Workflow& workflow, const Home& home) {
  report::check_references(workflow, home.data());
  Scripts scripts(home.templates(), "");
  std::vector<RenderedScript> rendered;
  const auto render = [&](const std::string& whose, const std::string& path,
                          const workflow::GivenMap& given, bool whole) {
    if (path.empty()) return;
    const Template& parsed = scripts.get(path);
    Value::Map values = values_of(given, "RUN", home.data());
    if (!whole)
      std::erase_if(values, [&](const auto& one) { return !parsed.names().contains(one.first); });
    if (parsed.names().contains("window") && !values.contains("window")) {
      values["window"] =
          Value::Map{{"index", 1}, {"begin", 0.0}, {"end", workflow.coupling->window}};
    }
    rendered.push_back({whose, path, parsed.render(values).size()});
  };
  for (const workflow::Stage& stage : workflow.stages) {
    render(stage.name, stage.template_path, stage.given, true);
  }
  for (const workflow::Participant& one : workflow.participants) {
    render(one.name, one.template_path, one.given, false);
    render(one.name, one.window_template_path, one.given, false);
  }
  return rendered;
}

}  // namespace sandglass::run
