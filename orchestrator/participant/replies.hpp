#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sandglass::participant {

/// What leaving something out has saved in this run so far, as the participant measured it.
struct Saving {
  std::string name;
  double seconds = 0;
};

/// The lines that a participant says (templates/README.md), as far as their text goes: whatever
/// comes, nothing worse happens here than an answer that makes no sense.
class Replies {
 public:
  /// Where bytes that were read are to be appended.
  [[nodiscard]] std::string& unread() { return unread_; }
  /// Forgets what a process that has gone left half said.
  void clear() { unread_.clear(); }
  /// The next answer among the lines that have come; those ahead of it are notes and savings.
  std::optional<std::string> next_answer();
  /// A line that is longer than any can be.
  [[nodiscard]] bool endless() const;
  [[nodiscard]] bool holds_line() const { return unread_.find('\n') != std::string::npos; }

  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  /// The newest of every name.
  [[nodiscard]] const std::vector<Saving>& savings() const { return savings_; }

 private:
  void keep_saving(const std::string& text);

  std::string unread_;
  std::vector<std::string> notes_;
  std::vector<Saving> savings_;
};

/// The abilities in "ready 1 memory disk"; nothing when the line is not that of this protocol.
std::optional<std::set<std::string>> abilities_in(const std::string& ready_line);

}  // namespace sandglass::participant
