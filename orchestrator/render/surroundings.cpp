#include "render/surroundings.hpp"

#include <cctype>
#include <utility>

namespace sandglass::render {
namespace {

struct Syntax {
  std::string_view quotes;     // characters that begin and end a string
  std::string_view escaping;   // those strings in which a backslash escapes
  std::string_view triple;     // those that may come in threes
  bool string_ends_with_line;  // unless it came in threes
  char comment;                // begins a comment to the end of the line; '/' means //
};

Syntax syntax_of(Language language) {
  switch (language) {
    case Language::python:
      return {"'\"", "'\"", "'\"", true, '#'};
    case Language::freefem:
      return {"\"", "\"", "", true, '/'};
    case Language::gmsh:
      return {"'\"", "", "", false, '/'};
    case Language::lammps:
      return {"'\"", "", "\"", true, '#'};
    case Language::shell:
      return {"'\"`", "\"`", "", false, '#'};
    case Language::json:
      return {"\"", "\"", "", true, 0};
    case Language::html:
    case Language::text:
      break;
  }
  return {"", "", "", false, 0};
}

bool contains(std::string_view text, char c) { return text.find(c) != text.npos; }
int lower(char c) { return std::tolower(static_cast<unsigned char>(c)); }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

}  // namespace

Surroundings::Kind Surroundings::kind() const {
  // Behind two quotes nobody knows yet whether a third comes.
  return kind_ == Kind::code && (quotes_ == 2 || word_comes_) ? Kind::string : kind_;
}

std::string_view Surroundings::name() const {
  switch (kind()) {
    case Kind::code:
      return "code";
    case Kind::comment:
    case Kind::block_comment:
      return "a comment";
    case Kind::string:
      return "a string";
    case Kind::markup:
      return "an HTML tag";
    case Kind::raw:
      return "<script> or <style>";
  }
  return {};
}

bool Surroundings::same(const Surroundings& other) const {
  if (kind() != other.kind()) return false;
  return kind() == Kind::code ||
         (quote_ == other.quote_ && quotes_ == other.quotes_ && escaped_ == other.escaped_ &&
          open_ == other.open_ && tangled_ == other.tangled_ && word_ == other.word_);
}

void Surroundings::read(std::string_view text) {
  if (language_ == Language::text) return;
  for (const char c : text) {
    const Kind before = kind_;
    if (language_ == Language::html) {
      read_html(c);
    } else {
      read_script(c);
    }
    // The sign that begins or ends a block comment is no part of another one: /*/, *//.
    const bool used =
        kind_ != before && (kind_ == Kind::block_comment || before == Kind::block_comment);
    last_ = used ? '0' : c;
  }
}

void Surroundings::read_value() {
  quotes_ = kind_ == Kind::code ? 0 : quotes_;
  escaped_ = false;
  last_ = '0';
}

void Surroundings::read_script(char c) {
  if (language_ == Language::shell && read_here_document(c)) return;
  switch (kind_) {
    case Kind::comment:
      if (c == '\n') kind_ = Kind::code;
      return;
    case Kind::block_comment:
      if (c == '/' && last_ == '*') kind_ = Kind::code;
      return;
    case Kind::string:
      return read_string(c);
    default:
      return read_code(c);
  }
}

void Surroundings::begin_string(char quote) {
  kind_ = Kind::string;
  quote_ = quote;
  quotes_ = 1;
  closing_ = 0;
  escaped_ = false;
  open_.clear();
  const bool dollar = language_ == Language::shell && quote == '\'' && last_ == '$';  // $'it\'s'
  escapes_ = dollar || contains(syntax_of(language_).escaping, quote);
}

void Surroundings::read_code(char c) {
  const Syntax syntax = syntax_of(language_);
  if (quotes_ == 2 && c == quote_) {  // the third one
    begin_string(c);
    quotes_ = 3;
    return;
  }
  quotes_ = 0;
  if (language_ == Language::shell && std::exchange(escaped_, c == '\\' && !escaped_)) return;
  if (contains(syntax.quotes, c)) return begin_string(c);
  if (syntax.comment == '/') {
    if (last_ == '/' && c == '/') kind_ = Kind::comment;
    if (last_ == '/' && c == '*') kind_ = Kind::block_comment;
  } else if (c == '#' && syntax.comment == '#') {
    // For a shell, # begins a comment only at the begin of a word.
    const bool word =
        language_ == Language::shell && last_ != 0 && !is_blank(last_) && !contains(";&|()", last_);
    if (!word) kind_ = Kind::comment;
  }
}

void Surroundings::read_string(char c) {
  const Syntax syntax = syntax_of(language_);
  if (std::exchange(escaped_, false)) {
    closing_ = 0;
    return;
  }
  if (c == '\\' && escapes_ && !open_.ends_with('\'')) {
    escaped_ = true;
    closing_ = 0;
  } else if (language_ == Language::shell && quote_ == '"' && read_substitution(c)) {
    return;
  } else if (c == quote_) {
    if (quotes_ == 3 && ++closing_ < 3) return;
    const bool empty = quotes_ == 1 && last_ == quote_ && contains(syntax.triple, quote_);
    kind_ = Kind::code;
    quotes_ = empty ? 2 : 0;
  } else {
    closing_ = 0;
    if (c == '\n' && syntax.string_ends_with_line && quotes_ == 1) kind_ = Kind::code;
  }
}

/// "$(command "with strings")", "`command`", "${name:-"value"}": all of it counts as the string.
/// Where only a shell could tell where it ends, nothing behind it counts as code any more.
bool Surroundings::read_substitution(char c) {
  if (tangled_) return true;
  const char innermost = open_.empty() ? '"' : open_.back();
  const bool inside = !open_.empty();
  if (innermost == '\'') {
    if (c == '\'') open_.pop_back();
    return true;
  }
  if (inside) {
    substitution_ += c;
    tangled_ = (c == '\'' && (innermost == '}' || last_ == '$')) || (c == '#' && is_blank(last_)) ||
               substitution_.ends_with("case") || substitution_.ends_with("<<");
  }
  if (c == '`') {
    const std::size_t begun = open_.find('`');
    if (begun == open_.npos) {
      open_ += '`';
    } else {
      open_.resize(begun);
    }
  } else if (c == '(' && (last_ == '$' || innermost == ')')) {
    open_ += ')';
  } else if (c == '{' && last_ == '$') {
    open_ += '}';
  } else if (inside && c == innermost) {  // a bracket or a string ends
    open_.pop_back();
  } else if (inside && innermost != '"' && (c == '"' || c == '\'')) {
    open_ += c;
  }
  if (open_.empty()) substitution_.clear();
  return inside || !open_.empty();
}

/// <<WORD, <<-WORD, <<'WORD': from the next line on until a line that is the word alone, behind
/// tabs after <<- only.
bool Surroundings::read_here_document(char c) {
  if (kind_ == Kind::string && quote_ == '\n') {
    if (c != '\n') {
      line_ += c;
      return true;
    }
    const std::size_t begin = tabs_ ? line_.find_first_not_of('\t') : 0;
    if (begin != line_.npos && line_.substr(begin) == word_) kind_ = Kind::code;
    line_.clear();
    return true;
  }
  if (kind_ != Kind::code) return false;
  if (c == '(' && last_ == '(') arithmetic_ = true;
  if (c == ')' && last_ == ')' && std::exchange(arithmetic_, false)) {
    word_comes_ = document_comes_ = false;  // $((1 << 2)) was a shift
  }
  if (word_comes_) {
    tabs_ = tabs_ || (word_.empty() && c == '-');
    if (contains("'\"\\", c) || (word_.empty() && contains("- \t", c))) return true;
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
      word_ += c;
      return true;
    }
    word_comes_ = false;
    document_comes_ = !word_.empty();  // not after <<<
  } else if (c == '<' && last_ == '<') {
    word_comes_ = true;
    tabs_ = false;
    word_.clear();
    return true;
  }
  if (c == '\n') arithmetic_ = false;
  if (c == '\n' && document_comes_) {
    document_comes_ = false;
    begin_string('\n');
    line_.clear();
    return true;
  }
  return false;
}

void Surroundings::read_html(char c) {
  switch (kind_) {
    case Kind::code:
      if (c == '<') {
        kind_ = Kind::markup;
        word_.clear();
        word_comes_ = true;
      }
      return;
    case Kind::markup:
      if (c == '>') {
        word_comes_ = false;
        kind_ = word_ == "script" || word_ == "style" ? Kind::raw : Kind::code;
      } else if (word_.empty() && std::isalpha(lower(c)) == 0 && !contains("/!?", c)) {
        word_comes_ = false;
        kind_ = Kind::code;  // "a < b"
      } else if ((c == '"' || c == '\'') && (last_ == '=' || is_blank(last_))) {
        kind_ = Kind::string;
        quote_ = c;
      } else if (is_blank(c)) {
        word_comes_ = false;
      } else if (word_comes_) {
        word_ += static_cast<char>(lower(c));
        if (word_ == "!--") {
          word_comes_ = false;
          kind_ = Kind::comment;
        }
      }
      line_.clear();
      return;
    case Kind::string:
      if (c == quote_) kind_ = Kind::markup;
      return;
    case Kind::comment:
      line_ += c;
      if (line_.ends_with("-->")) kind_ = Kind::code;
      return;
    default:  // raw
      line_ += static_cast<char>(lower(c));
      if (line_.ends_with(word_) &&
          std::string_view(line_).substr(0, line_.size() - word_.size()).ends_with("</")) {
        kind_ = Kind::markup;
        word_comes_ = false;
        word_.assign(1, '/');
      }
      return;
  }
}

}  // namespace sandglass::render
