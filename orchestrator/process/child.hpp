#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "process/process.hpp"

namespace sandglass {

/// A program that is running: its own process group, ended with us whatever happens (the kernel
/// kills it when we die; the destructor kills the group and reaps it).
class Child {
 public:
  /// Starts it. With `conversation`, two pipes are opened for it and their numbers are put into its
  /// environment as SANDGLASS_COMMANDS and SANDGLASS_REPLIES. Throws Error::environment.
  Child(std::string name, const Command& command, bool conversation);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& log() const { return log_; }
  [[nodiscard]] pid_t process_id() const { return process_; }
  /// Readable when the process has ended.
  [[nodiscard]] int exit_descriptor() const { return exit_descriptor_; }
  [[nodiscard]] int reply_descriptor() const { return replies_; }

  /// Writes the whole text to the command pipe. False when nobody reads it any more (once
  /// Interrupt::install() has made that an error instead of our end).
  bool write_command(std::string_view text);
  /// Appends what is there to `text`, at most a pipe's worth, without waiting. False at the end of
  /// the replies.
  bool read_replies(std::string& text);
  /// Closes the command pipe: the program sees the end of its commands.
  void close_commands();

  /// How it ended, if it has; reaps it. Does not wait.
  std::optional<Exit> poll_exit();
  /// Kills the whole group and reaps.
  Exit kill();

 private:
  std::optional<Exit> reap(int flags);

  std::string name_;
  std::string log_;
  pid_t process_ = -1;
  int exit_descriptor_ = -1;
  int commands_ = -1;
  int replies_ = -1;
  std::optional<Exit> exit_;
};

/// Waits for one of several children without overlooking that another has died, that a deadline has
/// passed, or that the user wants to stop.
class Watch {
 public:
  enum class Event { ready, exited, late };
  struct Outcome {
    Event event;
    Child* child;  ///< the one that exited, for Event::exited
  };

  void add(Child* child) { children_.push_back(child); }
  void remove(Child* child);
  /// Until `descriptor` is readable (ready; -1: never), a child has exited, or `seconds` are over.
  /// A reply that was written before the exit counts as ready. Throws Error::interrupted.
  Outcome wait(int descriptor, double seconds);

 private:
  std::vector<Child*> children_;
};

}  // namespace sandglass
