#pragma once

#include <string>
#include <string_view>

#include "render/template.hpp"

namespace sandglass::render {

/// Follows the text of a script and knows whether the next tag would stand in code, inside a string
/// or inside a comment. A value brings its own quotes: inside other quotes it would end the string
/// and become code. Knows of each language only its strings and comments.
class Surroundings {
 public:
  enum class Kind {
    code,
    comment,        ///< to the end of the line
    block_comment,  ///< until its end mark, which a value could hold
    string,         ///< also a here-document or backticks
    markup,         ///< inside an HTML tag, outside an attribute's quotes
    raw             ///< inside <script> or <style>
  };

  explicit Surroundings(Language language) : language_(language) {}

  /// Goes on over this text.
  void read(std::string_view text);
  /// Goes on over a tag that writes a value.
  void read_value();
  [[nodiscard]] Kind kind() const;
  /// "a string", "a comment": for messages.
  [[nodiscard]] std::string_view name() const;
  /// True when both are inside the same thing, begun the same way.
  [[nodiscard]] bool same(const Surroundings& other) const;

 private:
  void read_script(char c);
  void read_html(char c);
  void read_string(char c);
  void read_code(char c);
  bool read_here_document(char c);
  bool read_substitution(char c);
  void begin_string(char quote);

  Language language_;
  Kind kind_ = Kind::code;
  char quote_ = 0;               // what ends the string
  int quotes_ = 0;               // how many of them: 3 in """..."""; 2 while that is not decided
  int closing_ = 0;              // how many of three have come
  bool escapes_ = false;         // a backslash in this string escapes
  bool escaped_ = false;         // behind such a backslash
  std::string open_;             // what ends the substitutions and strings open in a shell's string
  std::string substitution_;     // the text of these
  bool tangled_ = false;         // nobody but a shell knows where they end
  char last_ = 0;                // the character before
  std::string word_;             // of a here-document, or the name of an HTML tag
  std::string line_;             // of a here-document, so far
  bool word_comes_ = false;      // behind <<
  bool document_comes_ = false;  // at the next line
  bool tabs_ = false;            // may stand before the word that ends it
  bool arithmetic_ = false;      // behind ((
};

}  // namespace sandglass::render
