#include "render/parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "render/utf8.hpp"

namespace sandglass::render {
namespace {

constexpr std::size_t deepest_section = 100;
constexpr std::size_t most_problems = 100;
constexpr std::size_t most_blocks = 1000;
constexpr std::size_t most_text = 16'000'000;

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The name between its dots; empty when it is not a name.
std::vector<std::string> split_name(const std::string& name) {
  std::vector<std::string> parts(1);
  for (const char c : name) {
    if (c == '.') {
      if (parts.back().empty()) return {};
      parts.emplace_back();
    } else if (is_letter(c) || (is_digit(c) && !(parts.size() == 1 && parts.back().empty())) ||
               (c == '-' && !parts.back().empty())) {
      parts.back() += c;  // a member may begin with a digit: the choice 3 of `dimension`
    } else {
      return {};
    }
  }
  return parts.back().empty() ? std::vector<std::string>{} : parts;
}

/// A path below the root, and no way out of it.
bool is_plain_path(const std::string& path) {
  if (path.front() == '/' || path.find("..") != path.npos) return false;
  return std::all_of(path.begin(), path.end(), [](char c) {
    return is_letter(c) || is_digit(c) || c == '.' || c == '/' || c == '-';
  });
}

std::string ending_of(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  return dot == path.npos || path[dot] == '/' ? "" : path.substr(dot);
}

}  // namespace

Parser::Parser(std::string path, Language language, const Read& read)
    : parsed_(std::make_shared<Template::Parsed>()), read_(read), surroundings_(language) {
  parsed_->path = std::move(path);
  parsed_->language = language;
}

std::shared_ptr<const Template::Parsed> Parser::parse(const std::string& text) {
  parsed_->files = {parsed_->path};
  including_ = {parsed_->path};
  Source source{.text = text, .file = 0, .indent = {}, .open = {}};
  read_source(source);
  if (!problems_.empty()) throw Error::refused(std::move(problems_));
  return std::move(parsed_);
}

void Parser::problem(const Source& source, int line, int column, std::string what,
                     std::string remedy) {
  if (problems_.size() >= most_problems) return;
  Place place{parsed_->files[source.file], line, column};
  // A building block that is used twice has each of its problems once.
  const bool known = std::any_of(problems_.begin(), problems_.end(), [&](const Problem& other) {
    return other.what == what && other.place.text() == place.text();
  });
  if (!known) problems_.push_back({std::move(place), std::move(what), std::move(remedy)});
}

void Parser::advance(Source& source, std::size_t to) const {
  for (; source.at < to; ++source.at) {
    const char c = source.text[source.at];
    if (c == '\n') {
      ++source.line;
      source.line_begin = source.at + 1;
      source.column = 1;
    } else if (!utf8::continues(c)) {
      ++source.column;
    }
  }
}

void Parser::read_source(Source& source) {
  while (source.at < source.text.size()) {
    const std::size_t begin = std::min(source.text.find("{{", source.at), source.text.size());
    const std::string_view before = source.text.substr(source.at, begin - source.at);
    advance(source, begin);
    if (begin == source.text.size()) {
      add_text(source, before);
      break;
    }
    Tag tag = read_tag(source, begin);
    std::size_t line_begin = 0;
    std::size_t line_end = 0;
    tag.alone = stands_alone(source, tag, line_begin, line_end);
    if (tag.alone) {
      add_text(source, before.substr(0, before.size() - (begin - line_begin)));
      advance(source, line_end);
    } else {
      add_text(source, before);
      advance(source, tag.end);
    }
    if (!tag.valid) continue;
    if (tag.sign == '>') {
      const std::string_view indent =
          tag.alone ? source.text.substr(line_begin, begin - line_begin) : std::string_view();
      include(source, tag, source.indent + std::string(indent));
    } else {
      take_tag(source, tag);
    }
  }
  for (const Open& open : source.open) {
    const Node& node = parsed_->nodes[open.node];
    problem(source, node.line, node.column,
            fmt::format("the section '{}' is not closed", shown(node.text)),
            fmt::format("end it with {{{{/{}}}}}", shown(node.text)));
    --depth_;
  }
}

/// Finds where the tag's content ends. A comment may be of several lines; any other tag is on one,
/// and tags do not nest: else what follows is read as usual.
bool Parser::find_tag_end(const Source& source, Tag& tag, std::size_t& content_end) const {
  std::string_view text = source.text;
  if (tag.sign != '!') {
    text = text.substr(0, text.find("{{", tag.content));
    const std::string_view line = text.substr(tag.content);
    text = text.substr(0, tag.content + std::min(line.find('\n'), line.size()));
  }
  content_end = text.find("}}", tag.content);
  const bool closed = content_end != text.npos;
  tag.end = closed ? content_end + 2 : text.size();
  return closed;
}

Parser::Tag Parser::read_tag(Source& source, std::size_t begin) {
  const std::string_view text = source.text;
  Tag tag;
  tag.begin = begin;
  tag.line = source.line;
  tag.column = source.column;
  const auto refuse = [&](std::string what, std::string remedy) {
    problem(source, tag.line, tag.column, std::move(what), std::move(remedy));
    tag.valid = false;
  };
  tag.content = std::min(text.find_first_not_of(" \t", begin + 2), text.size());
  const char sign = tag.content < text.size() ? text[tag.content] : '\0';
  if (sign == '{' && tag.content == begin + 2) {
    tag.content = std::min(text.find_first_not_of('{', tag.content), text.size());
    refuse("there is no unescaped output ('{{{')",
           "put a blank between the brace and the tag: '{ {{name}} }'");
  } else if (sign != '\0' && std::string_view("#^/>!&=").find(sign) != std::string_view::npos) {
    tag.sign = sign;
    ++tag.content;
  }
  std::size_t content_end = 0;
  if (!find_tag_end(source, tag, content_end)) {
    if (tag.valid) refuse("this tag is not closed", "end it with '}}'");
    return tag;
  }
  if (tag.sign == '&') {
    refuse("there is no unescaped output ('&'): a value is always quoted", "leave out the '&'");
  } else if (tag.sign == '=') {
    refuse("the braces cannot be changed ('=')", "write tags as {{name}}");
  }
  if (tag.sign == '!' || !tag.valid) return tag;
  std::string_view name = text.substr(tag.content, content_end - tag.content);
  name.remove_prefix(std::min(name.find_first_not_of(" \t"), name.size()));
  const std::string_view before = text.substr(begin, content_end - name.size() - begin);
  tag.name_column = tag.column + static_cast<int>(utf8::length(before));
  tag.name = name.substr(0, name.find_last_not_of(" \t") + 1);
  tag.valid = check_name(source, tag);
  return tag;
}

bool Parser::check_name(const Source& source, const Tag& tag) {
  if (tag.name.empty()) {
    problem(source, tag.line, tag.column, "this tag has no name", "write {{name}}");
    return false;
  }
  const bool good =
      tag.sign == '>' ? is_plain_path(tag.name) : tag.name == "." || !split_name(tag.name).empty();
  if (good) return true;
  if (tag.sign == '>') {
    problem(source, tag.line, tag.name_column,
            fmt::format("'{}' is not a path of a template", shown(tag.name)),
            "write it from the templates' root: folder/file");
  } else {
    problem(
        source, tag.line, tag.name_column, fmt::format("'{}' is not a name", shown(tag.name)),
        "names are letters, digits, '_' and '-', and begin with a letter; members follow a dot");
  }
  return false;
}

/// A section, comment or building block alone in its line takes the line with it.
bool Parser::stands_alone(const Source& source, const Tag& tag, std::size_t& line_begin,
                          std::size_t& line_end) const {
  if (tag.sign == 0 || !tag.valid) return false;
  const std::string_view text = source.text;
  line_begin = source.line_begin;
  for (std::size_t i = line_begin; i < tag.begin; ++i) {
    if (!is_blank(text[i])) return false;
  }
  line_end = tag.end;
  while (line_end < text.size() && is_blank(text[line_end])) ++line_end;
  if (line_end < text.size() && text[line_end] == '\r') ++line_end;
  if (line_end == text.size()) return true;
  return text[line_end++] == '\n';
}

void Parser::take_tag(Source& source, const Tag& tag) {
  if (tag.sign == '!') return;
  if (!tag.alone) begin_line(source);
  switch (tag.sign) {
    case '#':
    case '^':
      return open_section(source, tag);
    case '/':
      return close_section(source, tag);
    default:
      return add_value(source, tag);
  }
}

Node& Parser::add_node(const Source& source, const Tag& tag, Node::Kind kind) {
  Node& node = parsed_->nodes.emplace_back();
  node.kind = kind;
  node.text = tag.name;
  if (tag.name != ".") {
    node.parts = split_name(tag.name);
    parsed_->names.insert(node.parts.front());
  }
  node.file = source.file;
  node.line = tag.line;
  node.column = tag.column;
  return node;
}

void Parser::add_value(const Source& source, const Tag& tag) {
  Node& node = add_node(source, tag, Node::Kind::value);
  using Kind = Surroundings::Kind;
  const Kind kind = surroundings_.kind();
  const bool html = parsed_->language == Language::html;
  const auto refuse = [&](std::string remedy) {
    problem(source, tag.line, tag.column,
            fmt::format("'{{{{{}}}}}' stands inside {}", shown(tag.name), surroundings_.name()),
            std::move(remedy));
  };
  if (kind == Kind::string && !html) {
    refuse("remove the quotes: values bring their own");
  } else if (kind == Kind::markup) {
    refuse("put quotes around it: attribute=\"{{name}}\"");
  } else if (kind == Kind::block_comment) {
    refuse("a value could end this comment: use // at the begin of the line");
  }
  node.raw = kind == Kind::raw;
  surroundings_.read_value();
}

void Parser::open_section(Source& source, const Tag& tag) {
  add_node(source, tag, tag.sign == '#' ? Node::Kind::section : Node::Kind::inverted);
  source.open.push_back({parsed_->nodes.size() - 1, surroundings_});
  if (++depth_ == deepest_section + 1) {
    problem(source, tag.line, tag.column,
            fmt::format("sections are nested deeper than {}", deepest_section));
  }
}

void Parser::close_section(Source& source, const Tag& tag) {
  const auto opened = std::find_if(source.open.rbegin(), source.open.rend(), [&](const Open& open) {
    return parsed_->nodes[open.node].text == tag.name;
  });
  if (opened == source.open.rend()) {
    const std::string name = shown(tag.name);
    if (source.open.empty()) {
      problem(source, tag.line, tag.column, fmt::format("'{{{{/{}}}}}' closes nothing", name),
              "no section is open here");
    } else {
      const Node& node = parsed_->nodes[source.open.back().node];
      problem(source, tag.line, tag.column,
              fmt::format("'{{{{/{}}}}}' does not close the section '{}' of {}:{}", name,
                          shown(node.text), node.line, node.column),
              fmt::format("write {{{{/{}}}}}", shown(node.text)));
    }
    return;
  }
  for (bool found = false; !found; source.open.pop_back(), --depth_) {
    const Open& open = source.open.back();
    Node& node = parsed_->nodes[open.node];
    found = node.text == tag.name;
    node.end = parsed_->nodes.size();
    text_is_closed_ = true;
    if (!found) {
      problem(source, node.line, node.column,
              fmt::format("the section '{}' is not closed before '{{{{/{}}}}}' at {}:{}",
                          shown(node.text), shown(tag.name), tag.line, tag.column),
              fmt::format("end it with {{{{/{}}}}}", shown(node.text)));
    } else if (!surroundings_.same(open.surroundings)) {
      // Else it would depend on the values whether what follows is code.
      problem(source, node.line, node.column,
              fmt::format("the section '{}' begins inside {} and ends inside {}", shown(node.text),
                          open.surroundings.name(), surroundings_.name()),
              "begin and end strings and comments on the same side of a section's tags");
    }
  }
}

void Parser::include(Source& source, const Tag& tag, const std::string& indent) {
  const auto refuse = [&](std::string what, std::string remedy = {}) {
    problem(source, tag.line, tag.column, std::move(what), std::move(remedy));
  };
  std::string path = tag.name;
  if (ending_of(path).empty()) path += ending_of(parsed_->path);
  if (!read_) return refuse("building blocks are not allowed here");
  if (std::find(including_.begin(), including_.end(), path) != including_.end()) {
    std::string way;
    for (const std::string& file : including_) way += file + " -> ";
    return refuse(fmt::format("'{}' contains itself: {}{}", path, way, path));
  }
  const Language language = language_of(path);
  if (language != parsed_->language && language != Language::text) {
    return refuse(fmt::format("'{}' is written in another language than '{}'", path, parsed_->path),
                  "a building block has the ending of the template that uses it");
  }
  if (++blocks_ > most_blocks || parsed_->text_size > most_text) {
    if (blocks_ <= most_blocks + 1) refuse("building blocks make the template too large");
    return;
  }
  std::string text;
  try {
    text = read_(path);
  } catch (const Error& error) {
    const Problem& first = error.problems().front();
    return refuse(first.what, first.remedy);
  }
  const auto known = std::find(parsed_->files.begin(), parsed_->files.end(), path);
  Source block{.text = text,
               .file = static_cast<std::size_t>(known - parsed_->files.begin()),
               .indent = indent,
               .open = {}};
  if (known == parsed_->files.end()) parsed_->files.push_back(path);
  including_.push_back(path);
  read_source(block);
  including_.pop_back();
}

/// Appends literal text, with the indent of a building block at the begin of its lines.
void Parser::add_text(const Source& source, std::string_view text) {
  while (!text.empty()) {
    const std::size_t line_end = text.find('\n');
    const std::string_view line = text.substr(0, line_end == text.npos ? text.npos : line_end + 1);
    if (line != "\n" && line != "\r\n") begin_line(source);
    append(line);
    line_begins_ = line.back() == '\n';
    text.remove_prefix(line.size());
  }
}

void Parser::begin_line(const Source& source) {
  if (line_begins_ && !source.indent.empty()) append(source.indent);
  line_begins_ = false;
}

void Parser::append(std::string_view text) {
  surroundings_.read(text);
  parsed_->text_size += text.size();
  std::vector<Node>& nodes = parsed_->nodes;
  // A section that ended here ends before this text: then it needs a node of its own.
  const bool joined = !nodes.empty() && nodes.back().kind == Node::Kind::text && !text_is_closed_;
  if (!joined) nodes.emplace_back();
  text_is_closed_ = false;
  nodes.back().text += text;
}

}  // namespace sandglass::render
