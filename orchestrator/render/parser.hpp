#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "render/parsed.hpp"
#include "render/surroundings.hpp"

namespace sandglass::render {

/// Turns a template's text into nodes, building blocks included, and collects every problem.
class Parser {
 public:
  using Read = std::function<std::string(const std::string&)>;

  Parser(std::string path, Language language, const Read& read);

  /// Throws Error::refused with every problem of the template.
  std::shared_ptr<const Template::Parsed> parse(const std::string& text);

 private:
  struct Open {  // a section that waits for its end
    std::size_t node;
    Surroundings surroundings;
  };
  struct Source {  // the file being read
    std::string_view text;
    std::size_t file;
    std::string indent;  // of a building block: that of its tag
    std::size_t at = 0;
    std::size_t line_begin = 0;
    int line = 1;
    int column = 1;
    std::vector<Open> open;
  };
  struct Tag {
    char sign = 0;  // one of #^/>! or 0
    std::string name;
    std::size_t begin = 0, end = 0;  // the braces included
    std::size_t content = 0;         // behind the opening braces and the sign
    int line = 0, column = 0;        // of the braces
    int name_column = 0;
    bool valid = true;  // false: refused already
    bool alone = false;
  };

  void read_source(Source& source);
  void advance(Source& source, std::size_t to) const;
  Tag read_tag(Source& source, std::size_t begin);
  bool find_tag_end(const Source& source, Tag& tag, std::size_t& content_end) const;
  bool stands_alone(const Source& source, const Tag& tag, std::size_t& line_begin,
                    std::size_t& line_end) const;
  void take_tag(Source& source, const Tag& tag);
  void add_value(const Source& source, const Tag& tag);
  void open_section(Source& source, const Tag& tag);
  void close_section(Source& source, const Tag& tag);
  void include(Source& source, const Tag& tag, const std::string& indent);
  void add_text(const Source& source, std::string_view text);
  void begin_line(const Source& source);
  void append(std::string_view text);
  Node& add_node(const Source& source, const Tag& tag, Node::Kind kind);
  bool check_name(const Source& source, const Tag& tag);
  void problem(const Source& source, int line, int column, std::string what,
               std::string remedy = {});

  std::shared_ptr<Template::Parsed> parsed_;
  const Read& read_;
  Surroundings surroundings_;
  std::vector<std::string> including_;  // the files on the way to this one
  std::vector<Problem> problems_;
  std::size_t depth_ = 0;  // sections open, over all files
  std::size_t blocks_ = 0;
  bool text_is_closed_ = false;  // a section ended behind the last node
  bool line_begins_ = true;      // nothing is written to the current line yet
};

}  // namespace sandglass::render
