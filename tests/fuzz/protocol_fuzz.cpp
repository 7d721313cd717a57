// A participant may say any lines, and write anything into its slot: the first byte says how much
// of the rest is lines.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "exchange/slot.hpp"
#include "participant/replies.hpp"

namespace {

using namespace sandglass;

/// A slot with fields of different ranks, and its file as the participant has it.
struct SlotUnderTest {
  std::string path =
      (std::filesystem::temp_directory_path() / ("fuzzed-slot-" + std::to_string(::getpid())))
          .string();
  exchange::Slot slot{
      path, "fuzzed", {{"force", "N", {3}}}, {{"motion", "m", {4, 3}}, {"mass", "kg", {1}}}, true};
  int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  off_t bytes = ::lseek(file, 0, SEEK_END);

  SlotUnderTest() = default;
  ~SlotUnderTest() {
    ::close(file);
    std::filesystem::remove(path);
  }
  SlotUnderTest(const SlotUnderTest&) = delete;
  SlotUnderTest& operator=(const SlotUnderTest&) = delete;
};

void lines(const std::string& text) {
  participant::Replies replies;
  // In two parts, as a pipe may bring them.
  for (const std::string& part : {text.substr(0, text.size() / 3), text.substr(text.size() / 3)}) {
    replies.unread() += part;
    while (const auto answer = replies.next_answer()) (void)participant::abilities_in(*answer);
  }
  if (replies.notes().size() > 1000 || replies.savings().size() > 1000) std::abort();
}

void slot(const std::uint8_t* data, std::size_t size) {
  static SlotUnderTest one;
  // Behind the header, where the datasets are; always the same slot, so that inputs can build on
  // each other.
  const off_t place = size > 1 ? (256 * data[0] + data[1]) % one.bytes : 0;
  const auto count = std::min<std::size_t>(size, static_cast<std::size_t>(one.bytes - place));
  if (::pwrite(one.file, data, count, place) != static_cast<ssize_t>(count)) std::abort();
  one.slot.require_whole();
  for (const std::size_t output : {std::size_t{0}, std::size_t{1}}) {
    const auto taken = one.slot.take(output);
    if (taken.values.size() > 12) std::abort();
    volatile double sum = one.slot.seconds();
    for (const double value : taken.values) sum = sum + value;
  }
  one.slot.clear_outputs();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t said = std::min<std::size_t>(data[0] * (size - 1) / 255, size - 1);
  lines(std::string(reinterpret_cast<const char*>(data) + 1, said));
  slot(data + 1 + said, size - 1 - said);
  return 0;
}
