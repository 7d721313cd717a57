#include "participant/participant.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::participant {
namespace {

/// A state may be a file or a folder.
void copy_state(const std::string& from, const std::string& to) {
  std::error_code error;
  std::filesystem::copy(from, to, std::filesystem::copy_options::recursive, error);
  if (error) throw_system_error("copy the state to", to, error.value());
}

/// One that has done its service; nothing depends on its being gone.
void remove_file(const std::string& path) {
  std::error_code ignored;
  std::filesystem::remove_all(path, ignored);
}

/// What a program that has gone gave as the reason, in a line of its own; empty when it said
/// nothing.
std::string reason_given(Child& child) {
  constexpr std::string_view mark = "error ";
  std::string said;
  child.read_replies(said);
  for (size_t begin = 0; begin < said.size();) {
    const size_t end = std::min(said.find('\n', begin), said.size());
    const std::string_view line = std::string_view(said).substr(begin, end - begin);
    if (line.starts_with(mark)) return std::string(line.substr(mark.size()));
    begin = end + 1;
  }
  return {};
}

}  // namespace

Participant::Participant(Description description, Watch& watch)
    : description_(std::move(description)),
      watch_(watch),
      slot_(description_.slot, description_.name, description_.inputs, description_.outputs,
            description_.mapped) {
  auto& environment = description_.command.environment;
  environment["SANDGLASS_SLOT"] = description_.slot;
  if (!description_.script.empty()) environment["SANDGLASS_SCRIPT"] = description_.script;
}

Participant::~Participant() {
  if (child_) watch_.remove(child_.get());
}

Error Participant::failure(const std::string& what, const std::string& remedy) const {
  const exchange::Window window = slot_.window();
  std::string where = description_.name;
  if (window.index > 0) where += fmt::format(", window {}", window.index);
  return Error::participant(fmt::format("participant {} {}", where, what), remedy,
                            end_of_log(description_.command.log));
}

void Participant::start() {
  child_ = std::make_unique<Child>(description_.name, description_.command, true);
  watch_.add(child_.get());
  replies_.clear();
  asked_.clear();
}

void Participant::wait_until_ready() {
  const std::string line = hear();
  if (line == "error" || line.starts_with("error ")) {
    throw failure("could not be set up: " + line.substr(std::min<size_t>(6, line.size())));
  }
  slot_.require_whole();
  const auto abilities = abilities_in(line);
  if (!abilities) {
    throw failure(fmt::format("answered '{}' where 'ready 1' was expected", line),
                  "see the participant protocol in templates/README.md");
  }
  abilities_ = *abilities;
  if (!description_.window_script.empty()) use_window_script(description_.window_script);
}

void Participant::use_window_script(const std::string& path) {
  description_.window_script = path;
  if (!child_) return;
  say("script " + path);
  hear_ok("script");
}

void Participant::begin(const exchange::Window& window) {
  slot_.set_window(window);
  slot_.clear_outputs();
  if (description_.fresh) {
    if (!child_) start();
    wait_until_ready();
    const bool stateless = abilities_.contains("stateless");
    if (!stateless && !abilities_.contains("disk")) {
      throw failure(
          "is to be fresh in every window but can neither write its state nor is stateless",
          "use 'process: resident'");
    }
    if (window.index > 1 && !stateless) read_state(state_path(window.index - 1));
  }
  if (description_.mapped) {
    say("advance");
    return;
  }
  const std::string stem = fmt::format("{}/window-{:06}-{:03}", description_.work_directory,
                                       window.index, window.iteration);
  input_file_ = stem + ".in.h5";
  output_file_ = stem + ".out.h5";
  slot_.write_fresh(input_file_);
  say(fmt::format("advance {} {}", input_file_, output_file_));
}

void Participant::finish() {
  hear_ok("advance");
  const std::int64_t index = slot_.window().index;
  if (!description_.mapped) {
    try {
      slot_.read_fresh(output_file_);
    } catch (const Error& error) {
      throw failure(fmt::format("left no readable file of its fields: {}", error.what()));
    }
    remove_file(input_file_);
    remove_file(output_file_);
  }
  window_seconds_ = slot_.seconds();
  if (description_.fresh) {
    if (!abilities_.contains("stateless")) write_state(state_path(index));
    stop();
    if (index > 1) remove_file(state_path(index - 1));
  }
}

void Participant::save() {
  if (abilities_.contains("stateless")) return;
  say("save");
  hear_ok("save");
}

void Participant::restore() {
  if (abilities_.contains("stateless")) return;
  say("restore");
  hear_ok("restore");
}

void Participant::checkpoint(const std::string& path) {
  if (abilities_.contains("stateless")) return;
  if (description_.fresh) {
    copy_state(state_path(slot_.window().index), path);
  } else {
    write_state(path);
  }
}

void Participant::go_on_from(const std::string& path, std::int64_t window) {
  const bool there = std::filesystem::exists(path);
  if (description_.fresh) {
    // Whether one is needed is known when it has started.
    if (there) copy_state(path, state_path(window));
  } else if (there) {
    read_state(path);
  } else if (!abilities_.contains("stateless")) {
    throw failure(fmt::format("has no state to go on from: there is no '{}'", path), "run anew");
  }
}

void Participant::write_state(const std::string& path) {
  say("checkpoint " + path);
  hear_ok("checkpoint");
  if (std::filesystem::exists(path)) return;
  throw failure(fmt::format("answered 'checkpoint' but left nothing at '{}'", path),
                "its script must write its state there, or not say that it has the ability 'disk'");
}

void Participant::read_state(const std::string& path) {
  say("load " + path);
  hear_ok("load");
}

void Participant::stop() {
  if (!child_) return;
  say("stop");
  hear_ok("stop");
  const Watch::Outcome outcome = [&] {
    // Only this one may exit now; another's death is found at its own next answer.
    Watch alone;
    alone.add(child_.get());
    return alone.wait(-1, description_.deadline);
  }();
  if (outcome.event == Watch::Event::late) {
    throw failure(
        fmt::format("answered 'stop' but did not exit within {} s", description_.deadline));
  }
  const auto ended = child_->poll_exit();
  end_process();
  if (ended && !ended->good()) throw failure("ended with " + ended->text());
}

void Participant::end_process() {
  watch_.remove(child_.get());
  if (const auto ended = child_->poll_exit()) {
    peak_memory_bytes_ = std::max(peak_memory_bytes_, ended->peak_memory_bytes);
  }
  child_.reset();
}

std::string Participant::state_path(std::int64_t window) const {
  return fmt::format("{}/state-{:06}", description_.work_directory, window);
}

void Participant::say(const std::string& line) {
  // One answer too many would be taken for the answer to this.
  child_->read_replies(replies_.unread());
  if (const auto unasked = replies_.next_answer()) {
    throw failure(fmt::format("said '{}' without being asked", *unasked),
                  "see the participant protocol in templates/README.md");
  }
  asked_ = line;
  // A participant that has gone is found, with its exit status, while waiting for the answer.
  static_cast<void>(child_->write_command(line + "\n"));
}

std::string Participant::hear() {
  const SystemClock clock;
  const double end = clock.now() + description_.deadline;
  bool open = true;
  for (;;) {
    if (auto answer = replies_.next_answer()) return *std::move(answer);
    if (replies_.endless()) throw failure("sent a line without end");
    // However much it talks: the deadline is for the answer.
    const double left = end - clock.now();
    const Watch::Outcome outcome = left > 0
                                       ? watch_.wait(open ? child_->reply_descriptor() : -1, left)
                                       : Watch::Outcome{Watch::Event::late, nullptr};
    if (outcome.event == Watch::Event::ready) {
      open = child_->read_replies(replies_.unread());
      continue;
    }
    if (outcome.event == Watch::Event::late) {
      throw failure(asked_.empty() ? fmt::format("did not get ready within its deadline of {} s",
                                                 description_.deadline)
                                   : fmt::format("did not answer '{}' within its deadline of {} s",
                                                 asked_, description_.deadline),
                    "raise its 'deadline' in the workflow, or see its log for what holds it up");
    }
    if (outcome.child == child_.get()) {
      // What it said before it went may still be in the pipe.
      if (open) open = child_->read_replies(replies_.unread());
      if (replies_.holds_line()) continue;
      const auto ended = child_->poll_exit();
      const std::string how = ended ? ended->text() : "unknown status";
      if (asked_.empty()) throw failure(fmt::format("did not get ready: it ended with {}", how));
      throw failure(fmt::format("ended by itself ({}) when asked '{}'", how, asked_));
    }
    const std::string reason = reason_given(*outcome.child);
    const auto ended = outcome.child->poll_exit();
    const std::int64_t window = slot_.window().index;
    throw Error::participant(
        fmt::format("participant {} ended by itself ({}) {}{}", outcome.child->name(),
                    ended ? ended->text() : "unknown status",
                    window > 0 ? fmt::format("in window {}, while {} was at work", window,
                                             description_.name)
                               : "before all were ready",
                    reason.empty() ? "" : ": " + reason),
        {}, end_of_log(outcome.child->log()));
  }
}

void Participant::hear_ok(const std::string& asked) {
  const std::string line = hear();
  slot_.require_whole();
  if (line == "ok") return;
  if (line.rfind("error", 0) == 0) {
    throw failure(fmt::format("failed at '{}': {}", asked,
                              line.size() > 6 ? line.substr(6) : "no reason given"));
  }
  throw failure(fmt::format("answered '{}' to '{}'", line, asked),
                "see the participant protocol in templates/README.md");
}

}  // namespace sandglass::participant
