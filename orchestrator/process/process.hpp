#pragma once

#include <sys/types.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace sandglass {

/// How to start a program: always an argument vector, never a shell.
struct Command {
  std::vector<std::string>
      arguments;          ///< the program first; looked up on PATH when it has no slash
  std::string directory;  ///< working directory
  std::map<std::string, std::string> environment;  ///< added to ours
  std::string log;  ///< file that receives output and errors (appended)
};

/// How a program ended.
struct Exit {
  bool by_signal = false;
  int number = 0;  ///< exit status, or the signal's number
  double peak_memory_bytes = 0;
  [[nodiscard]] bool good() const { return !by_signal && number == 0; }
  /// "exit status 3", "killed by signal 9 (SIGKILL)"
  [[nodiscard]] std::string text() const;
};

/// Runs a program to its end, in a process group of its own that is killed with us. Throws
/// Error::participant (`who`, how it ended, the last lines of its log) when it does not end well
/// within `deadline` seconds; Error::environment when it cannot be started; Error::interrupted when
/// the user interrupts us (the group is ended first).
Exit run_to_end(const std::string& who, const Command& command, double deadline);

/// The last lines of a text file. Empty when there is none.
std::string last_lines(const std::string& path, int count = 15);

/// The same with a heading, as the detail of an error. Empty when there is none.
std::string end_of_log(const std::string& path);

}  // namespace sandglass
