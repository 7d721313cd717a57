#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "base/error.hpp"

namespace sandglass::test {

/// True while the process runs. One that has ended and waits to be reaped by init has gone.
inline bool alive(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const size_t name_end = text.rfind(')');
  if (name_end == std::string::npos || name_end + 2 >= text.size()) return false;
  return text[name_end + 2] != 'Z' && text[name_end + 2] != 'X';
}

/// Waits until `condition` holds; false when it does not in 20 s.
template <typename Condition>
bool comes_true(Condition condition) {
  for (int look = 0; look < 2000; ++look) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return condition();
}

inline bool gone(pid_t process) {
  return comes_true([&] { return !alive(process); });
}

/// The number that a program has written into a file, once it has.
inline pid_t process_written_to(const std::string& path) {
  pid_t process = 0;
  comes_true([&] {
    std::ifstream file(path);
    std::string line;
    // A whole line only: the file may be read while it is written.
    if (!std::getline(file, line) || file.eof()) return false;
    process = static_cast<pid_t>(std::stol(line));
    return true;
  });
  return process;
}

/// Starts `work` in another process, a copy of this one; it ends with the status that `work`
/// returns, or with an Error's exit code.
template <typename Work>
pid_t start_elsewhere(Work work) {
  const pid_t process = ::fork();
  if (process != 0) return process;
  int status = 99;
  try {
    status = work();
  } catch (const Error& error) {
    status = static_cast<int>(error.code());
  } catch (...) {
    status = 98;
  }
  ::_exit(status);
}

/// Waits for the end: its exit status, or -signal.
inline int end_of(pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

template <typename Work>
int run_elsewhere(Work work) {
  return end_of(start_elsewhere(work));
}

/// In a process of its own: no file may grow beyond `bytes`, as on a full disk.
inline void limit_file_size(size_t bytes) {
  const rlimit limit{bytes, bytes};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  ::signal(SIGXFSZ, SIG_IGN);
}

/// In a process of its own: give up root's right to write everywhere.
inline void become_ordinary_user() {
  constexpr uid_t nobody = 65534;
  if (::geteuid() == 0 && (::setgid(nobody) != 0 || ::setuid(nobody) != 0)) ::_exit(97);
}

/// Number of descriptors that this process has open.
inline int open_descriptors() {
  int count = 0;
  for (int number = 0; number < 1024; ++number) {
    if (::fcntl(number, F_GETFD) >= 0) ++count;
  }
  return count;
}

}  // namespace sandglass::test
