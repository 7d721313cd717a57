#include "process/process.hpp"

#include <fmt/format.h>

#include <fstream>
#include <string>

#include "base/error.hpp"
#include "process/child.hpp"

namespace sandglass {

Exit run_to_end(const std::string& who, const Command& command, double deadline) {
  Child child(who, command, false);
  Watch watch;
  watch.add(&child);
  const Watch::Outcome outcome = watch.wait(-1, deadline);
  if (outcome.event == Watch::Event::late) {
    child.kill();
    throw Error::participant(
        fmt::format("{} did not end within its deadline of {} s", who, deadline),
        "give it a longer deadline in the workflow, or less to do", end_of_log(command.log));
  }
  const Exit ended = child.poll_exit().value_or(Exit{true, 9, 0});
  if (!ended.good()) {
    throw Error::participant(fmt::format("{} failed: {}", who, ended.text()), {},
                             end_of_log(command.log));
  }
  return ended;
}

std::string last_lines(const std::string& path, int count) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return {};
  // Logs can be huge; the end of one is all that is wanted.
  constexpr std::streamoff most = 16384;
  const std::streamoff size = file.tellg();
  file.seekg(std::max<std::streamoff>(0, size - most));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  while (!text.empty() && text.back() == '\n') text.pop_back();
  size_t from = text.size();
  for (int line = 0; line < count && from != std::string::npos && from > 0; ++line) {
    from = text.rfind('\n', from - 1);
  }
  if (from == std::string::npos) from = 0;
  if (from < text.size() && text[from] == '\n') ++from;
  return text.substr(from);
}

std::string end_of_log(const std::string& path) {
  const std::string lines = last_lines(path);
  return lines.empty() ? lines : fmt::format("last lines of {}:\n{}", path, lines);
}

}  // namespace sandglass
