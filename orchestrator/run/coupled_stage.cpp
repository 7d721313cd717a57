#include "run/coupled_stage.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/unit.hpp"
#include "coupling/engine.hpp"
#include "hdf5/hdf5.hpp"
#include "record/checkpoint.hpp"
#include "record/record.hpp"
#include "run/coupling_plan.hpp"
#include "run/participant_partner.hpp"
#include "run/solvers.hpp"

namespace sandglass::run {
namespace {

using participant::Participant;

/// The script of one participant's windows. Where it uses nothing of the window, its text is the
/// same every time: rendered and stored once.
class WindowScript {
 public:
  WindowScript(const workflow::Participant& participant, Value::Map values, Scripts& scripts)
      : participant_(participant), values_(std::move(values)), scripts_(scripts) {
    changes_ = scripts_.get(participant_.window_template_path).names().contains("window");
  }
  [[nodiscard]] bool changes() const { return changes_; }
  std::string render(std::int64_t index, double begin, double end) {
    if (changes_) {
      values_["window"] = Value::Map{{"index", index}, {"begin", begin}, {"end", end}};
    }
    return scripts_.render(participant_.name, participant_.window_template_path, values_,
                           changes_ ? index : 0);
  }

 private:
  const workflow::Participant& participant_;
  Value::Map values_;
  Scripts& scripts_;
  bool changes_ = false;
};

/// The values of `all` that one of two templates uses: a participant's names are given to its
/// script and its window script together.
Value::Map used_by(const Template& parsed, const Value::Map& all) {
  Value::Map values;
  for (const auto& [name, value] : all) {
    if (parsed.names().contains(name)) values[name] = value;
  }
  return values;
}

/// The coupling of one run: participants in the order of the workflow, their scripts, the record.
class CoupledRun {
 public:
  CoupledRun(const workflow::Workflow& workflow, const Home& home,
             const record::RunDirectory& directory, Scripts& scripts, const Span& span,
             CoupledOutcome& outcome)
      : workflow_(workflow),
        coupling_(*workflow.coupling),
        home_(home),
        directory_(directory),
        scripts_(scripts),
        span_(span),
        until_(span.until > 0 ? span.until : coupling_.windows),
        checkpoints_(directory),
        outcome_(outcome) {}

  void run(const std::function<void(std::int64_t, double)>& progress) {
    const double rendered_before = scripts_.seconds();
    try {
      start();
      loop(progress);
      for (auto& participant : participants_) participant->stop();
    } catch (const Error& error) {
      finish_after(error, rendered_before);
      throw;
    } catch (...) {
      finish(rendered_before);
      throw;
    }
    finish(rendered_before);
  }

 private:
  void start() {
    const double start = clock_.now();
    outcome_.windows = outcome_.windows_taken = span_.behind;
    outcome_.time = static_cast<double>(span_.behind) * coupling_.window;
    for (const std::string& name : coupling_.order) add(name);
    // One that is there already keeps its place until all participants are there.
    if (!std::filesystem::exists(directory_.file("record.h5"))) open_record();
    for (std::size_t p = 0; p < participants_.size(); ++p) {
      if (!fresh_[p]) participants_[p]->start();
    }
    for (std::size_t p = 0; p < participants_.size(); ++p) {
      if (!fresh_[p]) participants_[p]->wait_until_ready();
    }
    require_abilities();
    require_stateless(false);
    if (span_.behind > 0) go_on();
    if (!record_) open_record();
    outcome_.start_seconds = clock_.now() - start;
  }

  /// Takes up the participants' states behind the window of a checkpoint.
  void go_on() {
    const record::Checkpoints checkpoints(*span_.checkpoints);
    for (auto& participant : participants_) {
      participant->go_on_from(checkpoints.state_of(span_.behind, participant->name()),
                              span_.behind);
    }
    record::CouplingState state = checkpoints.coupling_state(span_.behind);
    memory_ = std::move(state.arrays);
    if (span_.keeps_record) {
      outcome_ = outcome_of_record(coupling_, directory_.file("record.h5"), span_.behind);
    }
    outcome_.elapsed_before = state.elapsed;  // with what lies between windows
  }

  [[nodiscard]] bool has(const Participant& participant, const char* ability) const {
    return participant.abilities().contains(ability) ||
           participant.abilities().contains("stateless");
  }

  /// A checkpoint needs participants that can write their state, a scheme that repeats windows ones
  /// that can go back.
  void require_abilities() const {
    for (std::size_t p = 0; coupling_.checkpoint_every > 0 && p < participants_.size(); ++p) {
      if (fresh_[p] || has(*participants_[p], "disk")) continue;
      throw Error::refused(
          coupling_.place,
          fmt::format("checkpoints are asked for, but participant '{}' cannot write its state",
                      participants_[p]->name()),
          "set checkpoint_every of 'record' to 0, or give it the ability 'disk'");
    }
    if (coupling_.scheme != workflow::Scheme::serial_implicit) return;
    for (std::size_t p = 0; p < participants_.size(); ++p) {
      if (!fresh_[p] && has(*participants_[p], "memory")) continue;
      throw Error::refused(
          coupling_.place,
          fmt::format("scheme serial-implicit repeats windows, but participant '{}' {}",
                      participants_[p]->name(),
                      fresh_[p] ? "is fresh in every window" : "cannot save and restore its state"),
          "use an explicit scheme, or a resident participant with the ability 'memory'");
    }
  }

  [[nodiscard]] std::size_t number_of(const std::string& participant) const {
    const auto& order = coupling_.order;
    return static_cast<std::size_t>(std::find(order.begin(), order.end(), participant) -
                                    order.begin());
  }

  /// Only one that keeps nothing between windows may be spared a window. Of fresh ones that is
  /// known when the first window is done.
  void require_stateless(bool fresh) const {
    for (const workflow::LeftOut& one : workflow_.left_out) {
      if (!one.unchanged_inputs || !one.active) continue;
      const std::size_t p = number_of(one.of);
      if (fresh_[p] != fresh || participants_[p]->abilities().contains("stateless")) continue;
      throw Error::refused(one.place,
                           fmt::format("'{}' leaves out windows of '{}', which is not stateless: "
                                       "it may answer the same values in another way",
                                       one.name, one.of),
                           "remove it, or have the participant say that it is stateless");
    }
  }

  void add(const std::string& name) {
    const auto found =
        std::find_if(workflow_.participants.begin(), workflow_.participants.end(),
                     [&](const workflow::Participant& one) { return one.name == name; });
    const workflow::Participant& one = *found;
    const Value::Map values = values_of(one.given, directory_.path(), home_.data());
    const Sides sides = sides_of(coupling_, name);

    participant::Description description;
    description.name = name;
    if (!one.template_path.empty()) {
      description.script = scripts_.render(name, one.template_path,
                                           used_by(scripts_.get(one.template_path), values));
    }
    window_scripts_.push_back(nullptr);
    if (!one.window_template_path.empty()) {
      auto script = std::make_unique<WindowScript>(
          one, used_by(scripts_.get(one.window_template_path), values), scripts_);
      // Which script an earlier part of the run used in which window is known to nobody else.
      for (std::int64_t index = 1; script->changes() && span_.keeps_record && index <= span_.behind;
           ++index) {
        static_cast<void>(render_for(*script, index));
      }
      description.window_script = render_for(*script, span_.behind + 1);
      if (script->changes()) window_scripts_.back() = std::move(script);
    }
    description.command = participant_command(home_, one, description.script);
    description.work_directory = directory_.folder("work/" + name);
    description.command.directory = description.work_directory;
    description.command.log = directory_.folder("logs") + "/" + name + ".log";
    description.slot = directory_.folder("exchange") + "/" + name + ".h5";
    description.inputs = layouts(coupling_, sides.inputs, true);
    description.outputs = layouts(coupling_, sides.outputs, false);
    description.fresh = one.lifetime == workflow::Lifetime::fresh;
    description.mapped = coupling_.transport == workflow::Transport::mapped;
    description.deadline = one.deadline;
    fresh_.push_back(description.fresh);
    participants_.push_back(std::make_unique<Participant>(std::move(description), watch_));
    partners_.push_back(std::make_unique<ParticipantPartner>(*participants_.back(), sides));
  }

  void open_record() {
    std::vector<record::RecordedField> fields;
    for (std::size_t f = 0; f < coupling_.fields.size(); ++f) {
      const workflow::Field& field = coupling_.fields[f];
      if (!field.recorded) continue;
      recorded_.push_back(f);
      fields.push_back({field.name, field.unit, field.from, field.to, field.shape, field.variable});
    }
    std::vector<std::string> columns = coupling_.order;
    columns.insert(columns.end(),
                   {"exchange", "render", "record", "orchestrator", "began", "ended"});
    record_ = std::make_unique<record::Record>(directory_.file("record.h5"), coupling_.windows,
                                               std::move(fields), std::move(columns),
                                               span_.keeps_record ? span_.behind : 0);
  }

  void loop(const std::function<void(std::int64_t, double)>& progress) {
    std::vector<coupling::Partner*> partners;
    for (auto& partner : partners_) partners.push_back(partner.get());
    const double start = clock_.now();
    const coupling::Plan plan = plan_of(workflow_);
    coupling::Engine engine(plan, partners, clock_);
    if (span_.behind > 0) {
      coupling::Memory memory(std::move(memory_));
      engine.remember(memory);
    }
    // One that was resumed may have been ended behind its last window.
    bool rests = came_to_rest(engine, span_.behind);
    for (std::int64_t index = span_.behind + 1; !rests && index <= until_; ++index) {
      if (index > span_.behind + 1) use_scripts(index);
      const double began = seconds_since_1970();
      const coupling::Done done = engine.window(index);
      append(done, began);
      if (index == span_.behind + 1) require_stateless(true);
      const bool due = coupling_.checkpoint_every > 0 && index % coupling_.checkpoint_every == 0;
      if (due && index < coupling_.windows) checkpoint(engine, index);
      outcome_.loop_seconds = clock_.now() - start;
      progress(done.window, done.end);
      rests = came_to_rest(engine, index);
    }
    for (const workflow::LeftOut& one : workflow_.left_out) {
      if (!one.unchanged_inputs || !one.active) continue;
      outcome_.savings.push_back({one.name, engine.spared(number_of(one.of)).seconds});
    }
    note_oscillations(engine.oscillations());
  }

  /// One note for all, with the one that lasts longest.
  void note_oscillations(const std::vector<coupling::Oscillation>& all) {
    if (all.empty()) return;
    const auto worst = std::max_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
      return a.finding.growth < b.finding.growth;
    });
    std::vector<std::string> names;
    for (const coupling::Oscillation& one : all) names.push_back(one.field);
    const bool many = names.size() > 1;
    outcome_.notes.push_back(fmt::format(
        "coupling: {} '{}' oscillate{} from window to window: {}its change {}; a shorter window or "
        "under-relaxation removes this, unless it is a solver's own noise",
        many ? "fields" : "field", fmt::join(names, "', '"), many ? "" : "s",
        many ? fmt::format("that of '{}' lasts longest, ", worst->field) : "",
        worst->finding.text()));
  }

  /// Whether the run ends behind this window, before its time; a note says so.
  bool came_to_rest(const coupling::Engine& engine, std::int64_t window) {
    if (window >= until_ || span_.until > 0 || !engine.at_rest()) return false;
    const coupling::RestLimits& rest = coupling_.rest;
    outcome_.notes.push_back(fmt::format(
        "coupling: field '{}' {} in {} windows one after the other: nothing is left to compute, "
        "the run ended at {} s of {} s",
        rest.field, rest.at_most > 0 ? fmt::format("was at most {}", rest.at_most) : "was 0",
        rest.windows, shortest(static_cast<double>(window) * coupling_.window),
        shortest(coupling_.end)));
    return true;
  }

  [[nodiscard]] std::string render_for(WindowScript& script, std::int64_t index) const {
    return script.render(index, static_cast<double>(index - 1) * coupling_.window,
                         static_cast<double>(index) * coupling_.window);
  }

  /// By count and not by the clock: a checkpoint may touch a solver's trajectory.
  void checkpoint(coupling::Engine& engine, std::int64_t window) {
    const double start = clock_.now();
    const std::string folder = checkpoints_.begin(window);
    for (auto& participant : participants_) {
      participant->checkpoint(folder + "/" + participant->name());
    }
    coupling::Memory memory;
    engine.remember(memory);
    record_->flush();
    const double elapsed = outcome_.elapsed_before + clock_.now() - span_.began;
    checkpoints_.complete(window, {elapsed, memory.arrays()});
    if (coupling_.checkpoints_kept > 0) checkpoints_.keep(coupling_.checkpoints_kept);
    outcome_.checkpoint_seconds += clock_.now() - start;
  }

  void use_scripts(std::int64_t index) {
    const double start = clock_.now();
    for (std::size_t p = 0; p < participants_.size(); ++p) {
      if (!window_scripts_[p]) continue;
      participants_[p]->use_window_script(render_for(*window_scripts_[p], index));
    }
    render_of_window_ = clock_.now() - start;
  }

  /// `began` by seconds_since_1970.
  void append(const coupling::Done& done, double began) {
    record::Row row;
    row.begin = done.begin;
    row.end = done.end;
    row.iterations = done.iterations;
    for (const std::size_t f : recorded_) {
      row.fields.push_back(
          {done.fields[f].values, done.fields[f].shape.empty() ? 1 : done.fields[f].shape[0]});
    }
    row.timings = done.timing.partners;
    outcome_.working_seconds += done.timing.working;
    for (std::size_t p = 0; p < partners_.size(); ++p) {
      outcome_.participant_seconds[partners_[p]->name()] += done.timing.partners[p];
    }
    row.timings.push_back(done.timing.exchange);
    row.timings.push_back(render_of_window_);
    // This one's own is not known yet.
    row.timings.push_back(record_of_last_);
    row.timings.push_back(
        std::max(0.0, done.timing.total - done.timing.working - done.timing.exchange));
    row.timings.push_back(began);
    row.timings.push_back(seconds_since_1970());
    const double start = clock_.now();
    record_->append(row);
    record_of_last_ = clock_.now() - start;
    outcome_.record_seconds += record_of_last_;
    outcome_.exchange_seconds += done.timing.exchange;
    outcome_.windows = done.window;
    outcome_.time = done.end;
  }

  /// Whatever happened: no process is left, and what was recorded is on the disk.
  void finish(double rendered_before) {
    outcome_.render_seconds = scripts_.seconds() - rendered_before;
    for (auto& participant : participants_) {
      for (const std::string& note : participant->notes()) {
        outcome_.notes.push_back(participant->name() + ": " + note);
      }
      const auto& savings = participant->savings();
      outcome_.savings.insert(outcome_.savings.end(), savings.begin(), savings.end());
      outcome_.peak_memory_bytes[participant->name()] = participant->peak_memory_bytes();
    }
    partners_.clear();
    participants_.clear();
    if (record_) close_record();
  }

  /// What else goes wrong does not hide the error, but is said with it.
  void finish_after(const Error& error, double rendered_before) {
    try {
      finish(rendered_before);
    } catch (const Error& late) {
      std::vector<Problem> problems = error.problems();
      problems.insert(problems.end(), late.problems().begin(), late.problems().end());
      throw Error(error.code(), std::move(problems));
    }
  }

  /// What could not be written was not done: the outcome counts what is in the record.
  void close_record() {
    const auto count = [&] {
      outcome_.windows = record_->windows();
      outcome_.time = static_cast<double>(outcome_.windows) * coupling_.window;
    };
    try {
      record_->close();
    } catch (...) {
      count();
      throw;
    }
    count();
  }

  const workflow::Workflow& workflow_;
  const workflow::Coupling& coupling_;
  const Home& home_;
  const record::RunDirectory& directory_;
  Scripts& scripts_;
  const Span& span_;
  std::int64_t until_;
  record::Checkpoints checkpoints_;
  coupling::Memory::Arrays memory_;
  CoupledOutcome& outcome_;
  SystemClock clock_;
  Watch watch_;
  std::vector<std::unique_ptr<Participant>> participants_;
  std::vector<std::unique_ptr<ParticipantPartner>> partners_;
  std::vector<std::unique_ptr<WindowScript>> window_scripts_;
  std::vector<bool> fresh_;
  std::vector<std::size_t> recorded_;
  std::unique_ptr<record::Record> record_;
  double render_of_window_ = 0;
  double record_of_last_ = 0;  ///< s that handing over the window before took
};

}  // namespace

double CoupledOutcome::overhead_per_window() const {
  if (windows == windows_taken) return 0;
  return std::max(0.0, loop_seconds - working_seconds - checkpoint_seconds) /
         static_cast<double>(windows - windows_taken);
}

CoupledOutcome outcome_of_record(const workflow::Coupling& coupling, const std::string& path,
                                 std::int64_t windows) {
  const hdf5::File record(path, hdf5::File::Mode::read);
  const auto sum = [&](const std::string& column) {
    const auto seconds = record.read_numbers("/timings/" + column, windows);
    return std::accumulate(seconds.begin(), seconds.end(), 0.0);
  };
  CoupledOutcome outcome;
  outcome.windows = windows;
  outcome.windows_taken = windows;
  outcome.time = static_cast<double>(windows) * coupling.window;
  for (const std::string& participant : coupling.order) {
    outcome.participant_seconds[participant] = sum(participant);
  }
  outcome.exchange_seconds = sum("exchange");
  outcome.record_seconds = sum("record");
  outcome.elapsed_before = sum("ended") - sum("began");
  return outcome;
}

void run_coupling(const workflow::Workflow& workflow, const Home& home,
                  const record::RunDirectory& directory, Scripts& scripts, const Span& span,
                  CoupledOutcome& outcome,
                  const std::function<void(std::int64_t window, double time)>& progress) {
  CoupledRun(workflow, home, directory, scripts, span, outcome).run(progress);
}

}  // namespace sandglass::run
