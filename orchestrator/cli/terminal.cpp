#include "cli/terminal.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace sandglass::cli {
namespace {
constexpr double kLive = 0.1;    // s between two changes of the live line
constexpr double kPlain = 10.0;  // s between two plain lines
}  // namespace

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds) || seconds > 1e9) return "unknown";
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<long long>(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string time_text(double seconds) {
  constexpr std::array<std::pair<double, const char*>, 4> units = {
      std::pair{1.0, "s"}, {1e-3, "ms"}, {1e-6, "us"}, {1e-9, "ns"}};
  for (const auto& [factor, name] : units) {
    if (std::abs(seconds) >= factor) return fmt::format("{:.4g} {}", seconds / factor, name);
  }
  return fmt::format("{:.4g} s", seconds);
}

std::string progress_text(const run::Progress& progress) {
  return fmt::format("window {} of {}, {} of {}, {:.4g} windows/s, {} left", progress.window,
                     progress.windows, time_text(progress.time), time_text(progress.end),
                     progress.rate, duration_text(progress.left));
}

TerminalStatus::TerminalStatus()
    : terminal_(::isatty(STDERR_FILENO) == 1), every_(terminal_ ? kLive : kPlain) {}

TerminalStatus::~TerminalStatus() { erase(); }

void TerminalStatus::erase() {
  if (line_open_) tell("\r\033[K");
  line_open_ = false;
}

void TerminalStatus::begin(const run::Progress& progress) {
  erase();
  tell("{:>8}  {}\n", duration_text(progress.elapsed), progress.stage);
  shown_at_ = progress.elapsed;
}

void TerminalStatus::window(const run::Progress& progress) {
  if (progress.elapsed - shown_at_ < every_ && progress.window != progress.windows) return;
  shown_at_ = progress.elapsed;
  const std::string text =
      fmt::format("{:>8}  {}", duration_text(progress.elapsed), progress_text(progress));
  if (terminal_ && progress.window != progress.windows) {
    tell("\r\033[K{}", text);
    std::fflush(stderr);
    line_open_ = true;
  } else {
    erase();
    tell("{}\n", text);
  }
}

void TerminalStatus::say(const std::string& text) {
  erase();
  tell("          {}\n", text);
}

}  // namespace sandglass::cli
