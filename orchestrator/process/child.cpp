#include "process/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"
#include "process/interrupt.hpp"

extern char** environ;  // NOLINT: the name is POSIX's

namespace sandglass {
namespace {

/// How long Watch::wait looks at the answer alone, in s.
constexpr double kSoon = 0.01;

/// The ends that the program gets have these numbers in it.
constexpr int kCommandsInChild = 3;
constexpr int kRepliesInChild = 4;

std::vector<std::string> environment_of(const Command& command, bool conversation) {
  std::vector<std::string> entries;
  const auto set_anew = [&](std::string_view entry) {
    const std::string name(entry.substr(0, entry.find('=')));
    return command.environment.contains(name) || name == "SANDGLASS_COMMANDS" ||
           name == "SANDGLASS_REPLIES";
  };
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!set_anew(*entry)) entries.emplace_back(*entry);
  }
  for (const auto& [name, value] : command.environment)
    entries.push_back(fmt::format("{}={}", name, value));
  if (conversation) {
    entries.push_back(fmt::format("SANDGLASS_COMMANDS={}", kCommandsInChild));
    entries.push_back(fmt::format("SANDGLASS_REPLIES={}", kRepliesInChild));
  }
  return entries;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  result.reserve(texts.size() + 1);
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

/// What the new process needs, prepared before fork: between fork and exec only calls that are
/// safe after a fork of a threaded program are made.
struct Start {
  const char* program;
  char** arguments;
  char** environment;
  const char* directory;
  int log;
  int commands;
  int replies;
  int failure;  ///< a Failure is written here when exec does not happen
  pid_t parent;
};

struct Failure {
  int number = 0;  ///< errno
  bool of_directory = false;
};

[[noreturn]] void become(const Start& start) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto give_up = [&](bool of_directory = false) {
    const Failure failure{errno, of_directory};
    [[maybe_unused]] const ssize_t written = ::write(start.failure, &failure, sizeof failure);
    ::_exit(127);
  };
  // The parent may have died before the request above: then nobody would kill us.
  if (::getppid() != start.parent) ::_exit(127);
  if (*start.directory != '\0' && ::chdir(start.directory) != 0) give_up(true);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing < 0 || ::dup2(nothing, 0) < 0) give_up();
  if (::dup2(start.log, 1) < 0 || ::dup2(start.log, 2) < 0) give_up();
  if (start.commands >= 0) {
    // All our own descriptors are above 9 (see above_the_child): no clash is possible.
    if (::dup2(start.commands, kCommandsInChild) < 0) give_up();
    if (::dup2(start.replies, kRepliesInChild) < 0) give_up();
  }
  // Ours are close-on-exec, but HDF5's and those that we have inherited are not.
  const unsigned first_unwanted = start.commands >= 0 ? kRepliesInChild + 1 : kCommandsInChild;
  ::close_range(first_unwanted, ~0U, CLOSE_RANGE_CLOEXEC);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) ::signal(number, SIG_DFL);
  ::execve(start.program, start.arguments, start.environment);
  give_up();
  ::_exit(127);
}

/// Owns one descriptor until it is released.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&&) = delete;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }
  int release() { return std::exchange(number_, -1); }
  void close() {
    if (number_ >= 0) ::close(release());
  }

 private:
  int number_;
};

/// Moves a descriptor above the numbers that the child uses.
Descriptor above_the_child(int descriptor) {
  Descriptor moved(::fcntl(descriptor, F_DUPFD_CLOEXEC, 10));
  const int number = errno;
  ::close(descriptor);
  if (moved.number() < 0) {
    throw Error::environment(fmt::format("cannot open more files: {}", std::strerror(number)),
                             "raise the limit on open files (ulimit -n)");
  }
  return moved;
}

struct Pipe {
  Descriptor read_end;
  Descriptor write_end;
};

Pipe make_pipe() {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw Error::environment(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
  }
  Descriptor write_end(ends[1]);
  Descriptor read_end = above_the_child(ends[0]);
  return {std::move(read_end), above_the_child(write_end.release())};
}

Descriptor open_log(const std::string& log) {
  const std::string path = log.empty() ? "/dev/null" : log;
  const int opened = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (opened < 0) throw_system_error("open the log", path, errno);
  return above_the_child(opened);
}

void close_if_open(int& descriptor) {
  if (descriptor >= 0) ::close(std::exchange(descriptor, -1));
}

}  // namespace

std::string Exit::text() const {
  if (!by_signal) return fmt::format("exit status {}", number);
  const char* abbreviation = ::sigabbrev_np(number);
  if (abbreviation == nullptr) return fmt::format("killed by signal {}", number);
  return fmt::format("killed by signal {} (SIG{})", number, abbreviation);
}

Child::Child(std::string name, const Command& command, bool conversation)
    : name_(std::move(name)), log_(command.log) {
  const std::string found = find_program(command.arguments.at(0));
  if (found.empty()) {
    throw Error::environment(fmt::format("{}: the program '{}' is not there or cannot be executed",
                                         name_, command.arguments.at(0)),
                             "run './sandglass doctor' to see what is missing and how to get it");
  }
  // It is executed in another directory than it was found in.
  const std::string program = std::filesystem::absolute(found).string();
  std::vector<std::string> arguments = command.arguments;
  std::vector<std::string> environment = environment_of(command, conversation);
  std::vector<char*> argument_pointers = pointers(arguments);
  std::vector<char*> environment_pointers = pointers(environment);

  const Descriptor log = open_log(command.log);
  std::optional<Pipe> commands;
  std::optional<Pipe> replies;
  if (conversation) {
    commands.emplace(make_pipe());
    replies.emplace(make_pipe());
  }
  Pipe failure = make_pipe();

  const Start start{program.c_str(),
                    argument_pointers.data(),
                    environment_pointers.data(),
                    command.directory.c_str(),
                    log.number(),
                    commands ? commands->read_end.number() : -1,
                    replies ? replies->write_end.number() : -1,
                    failure.write_end.number(),
                    ::getpid()};
  process_ = ::fork();
  if (process_ == 0) become(start);
  if (process_ < 0) {
    throw Error::environment(
        fmt::format("{}: cannot start '{}': {}", name_, program, std::strerror(errno)));
  }
  failure.write_end.close();
  // Both sides set the group, so that it exists whoever comes first.
  ::setpgid(process_, process_);

  Failure why;
  ssize_t got = 0;
  do {
    got = ::read(failure.read_end.number(), &why, sizeof why);
  } while (got < 0 && errno == EINTR);
  if (got == static_cast<ssize_t>(sizeof why)) {
    kill();
    throw Error::environment(
        why.of_directory
            ? fmt::format("{}: cannot start in the folder '{}': {}", name_, command.directory,
                          std::strerror(why.number))
            : fmt::format("{}: cannot start '{}': {}", name_, program, std::strerror(why.number)));
  }
  exit_descriptor_ = static_cast<int>(::syscall(SYS_pidfd_open, process_, 0));
  if (exit_descriptor_ < 0) {
    const int number = errno;
    kill();
    throw Error::environment(
        fmt::format("{}: cannot watch '{}': {}", name_, program, std::strerror(number)));
  }
  if (conversation) {
    commands_ = commands->write_end.release();
    replies_ = replies->read_end.release();
    ::fcntl(replies_, F_SETFL, O_NONBLOCK);
  }
}

Child::~Child() {
  if (process_ > 0 && !exit_) kill();
  close_if_open(commands_);
  close_if_open(replies_);
  close_if_open(exit_descriptor_);
}

bool Child::write_command(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(commands_, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    text.remove_prefix(static_cast<size_t>(count));
  }
  return true;
}

bool Child::read_replies(std::string& text) {
  // Once, and no more than a pipe holds: one that writes without end must not hold us here.
  std::array<char, 65536> block;
  ssize_t count = 0;
  do {
    count = ::read(replies_, block.data(), block.size());
  } while (count < 0 && errno == EINTR);
  if (count < 0) return errno == EAGAIN;
  text.append(block.data(), static_cast<size_t>(count));
  return count > 0;
}

void Child::close_commands() { close_if_open(commands_); }

std::optional<Exit> Child::reap(int flags) {
  if (exit_) return exit_;
  siginfo_t information{};
  int found = 0;
  do {
    found = ::waitid(P_PID, static_cast<id_t>(process_), &information, WEXITED | WNOWAIT | flags);
  } while (found < 0 && errno == EINTR);
  if (found != 0 || information.si_pid != process_) return std::nullopt;
  // What it started itself may still run: the group goes as a whole, and before the leader is
  // reaped, so that the number of the group is surely still its own.
  ::kill(-process_, SIGKILL);
  int status = 0;
  rusage usage{};
  if (::wait4(process_, &status, 0, &usage) != process_) return std::nullopt;
  Exit ended;
  ended.by_signal = WIFSIGNALED(status);
  ended.number = ended.by_signal ? WTERMSIG(status) : WEXITSTATUS(status);
  ended.peak_memory_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  exit_ = ended;
  return exit_;
}

std::optional<Exit> Child::poll_exit() { return reap(WNOHANG); }

Exit Child::kill() {
  ::kill(-process_, SIGKILL);
  ::kill(process_, SIGKILL);
  const auto ended = reap(0);
  return ended ? *ended : Exit{true, SIGKILL, 0};
}

void Watch::remove(Child* child) { std::erase(children_, child); }

Watch::Outcome Watch::wait(int descriptor, double seconds) {
  // The answer comes soon, nearly always; what else may have happened can wait that long. Looking
  // at one descriptor costs a fraction of looking at all.
  Interrupt::check();
  pollfd answer{descriptor, POLLIN, 0};
  const int soon = static_cast<int>(1e3 * std::min(seconds, kSoon));
  if (descriptor >= 0 && ::poll(&answer, 1, soon) > 0) return {Event::ready, nullptr};
  const SystemClock clock;
  const double end = clock.now() + seconds - 1e-3 * soon;
  for (;;) {
    Interrupt::check();
    std::vector<pollfd> wanted;
    wanted.push_back({descriptor, POLLIN, 0});
    wanted.push_back({Interrupt::descriptor(), POLLIN, 0});
    for (const Child* child : children_) wanted.push_back({child->exit_descriptor(), POLLIN, 0});
    const double left = std::max(0.0, end - clock.now());
    timespec limit{};
    limit.tv_sec = static_cast<time_t>(std::min(left, 1e6));
    limit.tv_nsec =
        static_cast<long>((std::min(left, 1e6) - std::floor(std::min(left, 1e6))) * 1e9);
    const int count = ::ppoll(wanted.data(), wanted.size(), &limit, nullptr);
    if (count < 0 && errno != EINTR) {
      throw Error::environment(fmt::format("cannot wait for programs: {}", std::strerror(errno)));
    }
    Interrupt::check();
    if (count <= 0) {
      if (clock.now() >= end) return {Event::late, nullptr};
      continue;
    }
    if (wanted[0].revents != 0) return {Event::ready, nullptr};
    for (size_t i = 0; i < children_.size(); ++i) {
      if (wanted[i + 2].revents != 0) return {Event::exited, children_[i]};
    }
  }
}

}  // namespace sandglass
