#include "process/interrupt.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>

#include "base/error.hpp"

namespace sandglass {
namespace {

volatile std::sig_atomic_t requested_signal = 0;
std::array<int, 2> wake_pipe{-1, -1};

void on_signal(int number) {
  const int saved = errno;
  requested_signal = number;
  const char byte = 1;
  // Nothing can be done here about a full pipe, and nothing needs to: it is readable already.
  [[maybe_unused]] const ssize_t written = ::write(wake_pipe[1], &byte, 1);
  errno = saved;
}

}  // namespace

void Interrupt::install() {
  if (wake_pipe[0] >= 0) return;
  if (::pipe2(wake_pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) {
    throw Error::environment("cannot make a pipe for signals");
  }
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  for (const int number : {SIGINT, SIGTERM}) ::sigaction(number, &action, nullptr);
  // Under nohup a terminal that goes away ends nothing.
  struct sigaction before {};
  ::sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
  // A participant that has gone, or a file at its size limit, must show as an error of write(), not
  // end us.
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
}

int Interrupt::descriptor() { return wake_pipe[0]; }

bool Interrupt::requested() { return requested_signal != 0; }

void Interrupt::check() {
  if (requested()) throw Error::interrupted("interrupted");
}

}  // namespace sandglass
