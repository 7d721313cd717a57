#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <string_view>

#include "render/quote.hpp"
#include "render/utf8.hpp"

// How text becomes a literal. What the solvers' own lexers do was found out by asking them
// (FreeFEM 4.11, gmsh 4.8.4) and is kept by tests/unit/render/hostile_values_test.cpp.
namespace sandglass::render {
namespace {

[[noreturn]] void refuse(std::string what, std::string remedy = {}) {
  throw Error::refused(Place{}, std::move(what), std::move(remedy));
}

std::string shown(char32_t character) {
  if (character > 0x20 && character < 0x7F)
    return fmt::format("'{}'", static_cast<char>(character));
  if (character == '\n') return "a line end";
  if (character == ' ') return "a blank";
  return fmt::format("the character U+{:04X}", static_cast<unsigned>(character));
}

/// Calls `each(character, bytes)` for every character; refuses what is not UTF-8.
template <typename Each>
void for_each_character(const std::string& text, Each each) {
  const std::string_view all(text);
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t begin = at;
    const char32_t character = utf8::decode(all, at);
    if (character == utf8::invalid) refuse("the text is not valid UTF-8");
    each(character, all.substr(begin, at - begin));
  }
}

/// Quotes, backslashes and braces are escaped by number, not as \' and \\: then the literal holds
/// even as r'..' or f'..', and its text cannot end a string around it.
void append_python(std::string& out, const std::string& text) {
  constexpr std::string_view escaped = "'\"\\{}";
  out += '\'';
  const std::size_t begin = out.size();
  for_each_character(text, [&](char32_t c, std::string_view bytes) {
    // In a comment on the first two lines, "coding: utf-7" would change how the file is read.
    const bool declares_encoding = (c == ':' || c == '=') && out.size() - begin >= 6 &&
                                   std::string_view(out).ends_with("coding");
    if (c < 0x80 && (escaped.find(static_cast<char>(c)) != escaped.npos || declares_encoding)) {
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned>(c));
    } else if (!utf8::hidden(c)) {
      out += bytes;
    } else {
      const auto number = static_cast<unsigned>(c);
      const char* form = c < 0x100 ? "\\x{:02x}" : c < 0x10000 ? "\\u{:04x}" : "\\U{:08x}";
      fmt::format_to(std::back_inserter(out), fmt::runtime(form), number);
    }
  });
  out += '\'';
}

/// FreeFEM's lexer takes ASCII only, at most 255 characters, and knows \" and \n. But macros read
/// and write string literals anew, and there a backslash can end the string; IFMACRO and NewMacro
/// look for their end inside strings, and `macro` ends at // even there.
void append_freefem(std::string& out, const std::string& text) {
  for (const std::string_view word : {"IFMACRO", "EndMacro", "NewMacro"}) {
    if (text.find(word) != text.npos)
      refuse(fmt::format("FreeFEM takes '{}' for its own word even inside a string", word));
  }
  constexpr std::size_t longest = 255;
  const bool split = text.size() > longest;  // ("first part"+"second part")
  if (split) out += '(';
  out += '"';
  std::size_t count = 0;
  char before = 0;
  for_each_character(text, [&](char32_t c, std::string_view) {
    const bool printable = c >= 0x20 && c < 0x7F;
    if (c == '\\')
      refuse("FreeFEM cannot keep a backslash in a string that passes through a macro");
    if (!printable && c != '\n' && c != '\t') {
      refuse(fmt::format("FreeFEM cannot hold {} in a string", shown(c)),
             "use plain ASCII letters, digits and signs");
    }
    if (count == longest) {
      out += "\"+\"";
      count = 0;
    }
    const char letter = static_cast<char>(c);
    if (letter == '"' || (letter == '/' && before == '/')) out += '\\';
    if (letter == '\n') {
      out += "\\n";
    } else {
      out += letter;
    }
    before = letter;
    ++count;
  });
  out += split ? "\")" : "\"";
}

/// gmsh has no escapes, two kinds of quotes, at most 1023 bytes, and looks for EndIf and the like
/// inside strings of a branch that is not taken: what follows such a word would be run.
void append_gmsh(std::string& out, const std::string& text) {
  constexpr std::size_t longest = 1023;
  if (text.size() > longest) {
    refuse(fmt::format("gmsh holds at most {} bytes in a string, this text has {}", longest,
                       text.size()));
  }
  for_each_character(text, [](char32_t c, std::string_view) {
    if (c < 0x20 || c == 0x7F) refuse(fmt::format("gmsh cannot hold {} in a string", shown(c)));
  });
  const char quote = text.find('"') == text.npos ? '"' : '\'';
  if (text.find(quote) != text.npos) {
    refuse("gmsh cannot hold both kinds of quotes in a string", "leave out ' or \"");
  }
  if (text.find("/*") != text.npos) refuse("gmsh may take '/*' for a comment even inside a string");
  constexpr std::array<std::string_view, 10> words{"If",     "ElseIf", "Else",  "EndIf",    "For",
                                                   "EndFor", "Return", "Macro", "Function", "Call"};
  const auto is_letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  for (std::size_t at = 0; at < text.size();) {
    const auto end = static_cast<std::size_t>(
        std::find_if_not(text.begin() + static_cast<std::ptrdiff_t>(at), text.end(), is_letter) -
        text.begin());
    const std::string_view word(text.data() + at, end - at);
    // A digit behind the word does not protect it: gmsh reads "EndIf1" as EndIf.
    const std::string_view bare = word.substr(0, word.find_first_of("0123456789"));
    if (std::find(words.begin(), words.end(), bare) != words.end())
      refuse(fmt::format("gmsh may take '{}' for its own word even inside a string", bare));
    at = end + 1;
  }
  out += quote;
  out += text;
  out += quote;
}

/// LAMMPS splits lines into words, replaces $x, and continues at &: only a plain word is safe.
void append_lammps(std::string& out, const std::string& text) {
  if (text.empty()) refuse("LAMMPS has no empty word");
  constexpr std::string_view signs = "_./+-:=,@%~*";
  for_each_character(text, [&](char32_t c, std::string_view) {
    const bool plain = c < 0x80 && (std::isalnum(static_cast<int>(c)) != 0 ||
                                    signs.find(static_cast<char>(c)) != signs.npos);
    if (!plain) {
      refuse(fmt::format("LAMMPS cannot hold {} in a word", shown(c)),
             fmt::format("use ASCII letters, digits and {}", signs));
    }
  });
  out += text;
}

void append_shell(std::string& out, const std::string& text) {
  out += '\'';
  for_each_character(text, [&](char32_t c, std::string_view bytes) {
    if ((c < 0x20 && c != '\t') || c == 0x7F)
      refuse(fmt::format("a shell script is not given {}", shown(c)));
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += bytes;
    }
  });
  out += '\'';
}

void append_json(std::string& out, const std::string& text) {
  out += '"';
  for_each_character(text, [&](char32_t c, std::string_view bytes) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += bytes;
    } else if (c < 0x20 || c == 0x7F || c == 0x2028 || c == 0x2029) {
      fmt::format_to(std::back_inserter(out), "\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += bytes;
    }
  });
  out += '"';
}

void append_html(std::string& out, const std::string& text) {
  for_each_character(text, [&](char32_t c, std::string_view bytes) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case 0:
        refuse("HTML cannot hold the character U+0000");
      default:
        out += bytes;
    }
  });
}

}  // namespace

void append_text(std::string& out, const std::string& text, Language language) {
  switch (language) {
    case Language::python:
      return append_python(out, text);
    case Language::freefem:
      return append_freefem(out, text);
    case Language::gmsh:
      return append_gmsh(out, text);
    case Language::lammps:
      return append_lammps(out, text);
    case Language::shell:
      return append_shell(out, text);
    case Language::json:
      return append_json(out, text);
    case Language::html:
      return append_html(out, text);
    case Language::text:
      out += text;
      return;
  }
}

}  // namespace sandglass::render
