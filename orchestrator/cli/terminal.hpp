#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

#include "run/status.hpp"

namespace sandglass::cli {

/// Writes to standard error. That it has gone, a terminal closed or a disk full, is no reason to
/// end what runs.
template <typename... Values>
void tell(fmt::format_string<Values...> text, Values&&... values) {
  const std::string all = fmt::format(text, std::forward<Values>(values)...);
  static_cast<void>(std::fwrite(all.data(), 1, all.size(), stderr));
}

/// Shows a run's progress: one live line on a terminal, plain lines otherwise.
class TerminalStatus final : public run::Status {
 public:
  TerminalStatus();
  ~TerminalStatus() override;
  TerminalStatus(const TerminalStatus&) = delete;
  TerminalStatus& operator=(const TerminalStatus&) = delete;

  void begin(const run::Progress& progress) override;
  void window(const run::Progress& progress) override;
  void say(const std::string& text) override;

 private:
  void erase();
  bool terminal_;
  bool line_open_ = false;
  double shown_at_ = 0;
  double every_;  ///< s between two lines
};

/// "1.5 s", "3 min 20 s", "2 h 5 min"
std::string duration_text(double seconds);
/// A time with a unit that suits it: "30 ms", "1.5 us".
std::string time_text(double seconds);
/// "window 12 of 30, 12 ms of 30 ms, 2500 windows/s, 0.1 s left"
std::string progress_text(const run::Progress& progress);

}  // namespace sandglass::cli
