#include "render/utf8.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace sandglass::utf8 {

char32_t decode(std::string_view text, std::size_t& at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at++);
  if (first < 0x80) return first;
  const std::size_t more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
  if (first < 0xC2 || first > 0xF4 || at + more > text.size()) return invalid;
  char32_t character = first & (0x3Fu >> more);
  for (std::size_t i = 0; i < more; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return invalid;
    character = character << 6 | (byte(at + i) & 0x3Fu);
  }
  constexpr std::array<char32_t, 4> smallest{0, 0x80, 0x800, 0x10000};
  const bool surrogate = character >= 0xD800 && character <= 0xDFFF;
  if (character < smallest[more] || character > 0x10FFFF || surrogate) return invalid;
  at += more;
  return character;
}

std::size_t length(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return !continues(c); }));
}

bool hidden(char32_t character) {
  if (character < 0x7F) return character < 0x20;
  static constexpr std::array<std::pair<char32_t, char32_t>, 14> ranges{{
      {0x7F, 0xA0},
      {0xAD, 0xAD},
      {0x61C, 0x61C},
      {0x180E, 0x180E},
      {0x2000, 0x200F},
      {0x2028, 0x202F},
      {0x205F, 0x206F},
      {0x3000, 0x3000},
      {0xE000, 0xF8FF},
      {0xFE00, 0xFE0F},
      {0xFEFF, 0xFEFF},
      {0xFFF0, 0xFFFB},
      {0xFFFE, 0xFFFF},
      {0xE0000, 0x10FFFF},
  }};
  return std::any_of(ranges.begin(), ranges.end(), [&](const auto& range) {
    return character >= range.first && character <= range.second;
  });
}

}  // namespace sandglass::utf8
