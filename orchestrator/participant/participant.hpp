#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "exchange/slot.hpp"
#include "participant/replies.hpp"
#include "process/child.hpp"

namespace sandglass::participant {

/// Everything needed to start one participant and to talk to it.
struct Description {
  std::string name;
  Command command;             ///< its environment is completed with the protocol's variables
  std::string script;          ///< path of the rendered script; may be empty
  std::string window_script;   ///< path of the script executed at every window; may be empty
  std::string slot;            ///< path of the slot to create
  std::string work_directory;  ///< where fresh files and state files go
  std::vector<exchange::FieldLayout> inputs;
  std::vector<exchange::FieldLayout> outputs;
  bool fresh = false;    ///< a new process for every window
  bool mapped = true;    ///< false: fields cross as fresh files
  double deadline = 60;  ///< seconds that one answer may take
};

/// One external solver in a coupled stage, by the participant protocol (templates/README.md).
/// Everything that goes wrong with it is Error::participant with its name, the window, and the last
/// lines of its log.
class Participant {
 public:
  Participant(Description description, Watch& watch);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  [[nodiscard]] const std::string& log() const { return description_.command.log; }
  [[nodiscard]] const std::string& name() const { return description_.name; }
  [[nodiscard]] exchange::Slot& slot() { return slot_; }

  /// Starts the process; returns at once, so that several start at the same time.
  void start();
  /// Waits until it is set up.
  void wait_until_ready();
  /// Asks it to go on to the end of the window; returns at once, but where every window has a
  /// process of its own, when that has been started.
  void begin(const exchange::Window& window);
  /// Waits for that.
  void finish();
  /// Keeps or brings back its state in memory (iterated schemes).
  void save();
  void restore();
  /// Writes its state behind the window that was done last, and goes on from what a reader of it
  /// would have. A participant without a state writes nothing.
  void checkpoint(const std::string& path);
  /// Takes the state that `checkpoint` wrote behind this window; nothing where there is no state to
  /// have.
  void go_on_from(const std::string& path, std::int64_t window);
  /// Executes this script from the next window on.
  void use_window_script(const std::string& path);
  /// Ends it in good order and waits for its exit.
  void stop();

  /// "memory", "disk", "stateless"; known once it is ready.
  [[nodiscard]] const std::set<std::string>& abilities() const { return abilities_; }
  /// Seconds that its last window took by its own account.
  [[nodiscard]] double seconds() const { return window_seconds_; }
  [[nodiscard]] double peak_memory_bytes() const { return peak_memory_bytes_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return replies_.notes(); }
  /// The newest of every name.
  [[nodiscard]] const std::vector<Saving>& savings() const { return replies_.savings(); }

 private:
  void write_state(const std::string& path);
  void read_state(const std::string& path);
  void say(const std::string& line);
  /// Waits for the next line that is an answer.
  std::string hear();
  void hear_ok(const std::string& asked);
  void end_process();
  [[nodiscard]] std::string state_path(std::int64_t window) const;
  [[nodiscard]] Error failure(const std::string& what, const std::string& remedy = {}) const;

  Description description_;
  Watch& watch_;
  exchange::Slot slot_;
  std::unique_ptr<Child> child_;
  Replies replies_;
  std::string asked_;       ///< the command being answered, for messages
  std::string input_file_;  ///< of this window, where fields cross as fresh files
  std::string output_file_;
  std::set<std::string> abilities_;
  double peak_memory_bytes_ = 0;
  double window_seconds_ = 0;
};

}  // namespace sandglass::participant
