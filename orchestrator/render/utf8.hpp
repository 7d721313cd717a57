#pragma once

#include <cstddef>
#include <string_view>

namespace sandglass::utf8 {

/// What decode() gives for bytes that are not UTF-8.
inline constexpr char32_t invalid = 0xFFFFFFFF;

/// The character at `at`, which moves behind it; `invalid` (and one byte on) where the bytes are
/// not UTF-8: overlong forms, surrogates and numbers above U+10FFFF included.
char32_t decode(std::string_view text, std::size_t& at);

/// True for a byte that continues a character.
inline bool continues(char byte) { return (byte & 0xC0) == 0x80; }

/// Characters in the text; bytes that continue a character do not count.
std::size_t length(std::string_view text);

/// True for characters that an editor may not show as themselves: controls, invisible and
/// direction-changing marks, private and unassigned planes.
bool hidden(char32_t character);

}  // namespace sandglass::utf8
