#include "workflow/yaml.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "render/utf8.hpp"

namespace sandglass::workflow {
namespace {

constexpr std::size_t most_values = 20'000;
constexpr std::size_t most_items = 1000;
constexpr std::size_t deepest = 50;

/// Ends the parsing; what is wrong was already reported.
struct Stop {};

/// Where the lines begin, to turn the bytes that yaml-cpp counts into characters.
class Lines {
 public:
  explicit Lines(const std::string& text) : text_(text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') begins_.push_back(i + 1);
    }
  }
  /// The place of a byte; line and byte column count from 0.
  [[nodiscard]] std::pair<int, int> place(int line, int byte_column) const {
    const auto index = static_cast<std::size_t>(std::max(line, 0));
    if (index >= begins_.size()) return {line + 1, byte_column + 1};
    int column = 1;
    const std::size_t end =
        std::min(text_.size(), begins_[index] + static_cast<std::size_t>(std::max(byte_column, 0)));
    for (std::size_t i = begins_[index]; i < end; ++i) {
      if ((static_cast<unsigned char>(text_[i]) & 0xC0U) != 0x80U) ++column;
    }
    return {line + 1, column};
  }
  [[nodiscard]] std::pair<int, int> place_of_byte(std::size_t byte) const {
    const auto after = std::upper_bound(begins_.begin(), begins_.end(), byte);
    const auto line = after - begins_.begin() - 1;
    return place(static_cast<int>(line),
                 static_cast<int>(byte - begins_[static_cast<std::size_t>(line)]));
  }

 private:
  const std::string& text_;
  std::vector<std::size_t> begins_{0};
};

bool control(char32_t code) {
  return (code < 0x20U && code != '\n' && code != '\t') || (code >= 0x7FU && code < 0xA0U);
}

/// Reports the first character that has no business in a workflow. False when there is one.
bool characters_are_good(const std::string& text, const std::string& file, Problems& problems) {
  const auto report = [&](std::size_t at, std::string what, std::string remedy) {
    const auto [line, column] = Lines(text).place_of_byte(at);
    problems.add({file, line, column}, std::move(what), std::move(remedy));
    return false;
  };
  bool indenting = true;
  bool tabbed = false;
  std::int64_t brackets = 0;
  for (std::size_t i = 0, next = 0; i < text.size(); i = next) {
    const char32_t code = utf8::decode(text, next);
    if (code == utf8::invalid) return report(i, "this is not UTF-8", "save the file as UTF-8 text");
    if (control(code)) {
      return report(i, fmt::format("control character U+{:04X}", static_cast<std::uint32_t>(code)),
                    "remove it");
    }
    // yaml-cpp takes an indenting tab as part of the key that follows it.
    if (code == '\n') {
      indenting = true;
      tabbed = false;
    } else if (indenting && code == '\t') {
      tabbed = true;
    } else if (code != ' ') {
      if (indenting && tabbed && code != '#')
        return report(i, "a tab in the indentation", "indent with spaces");
      indenting = false;
    }
    // A bound on what the scanner looks ahead over; the exact depth is watched while the tree
    // grows.
    if (code == '[' || code == '{') ++brackets;
    if (code == ']' || code == '}') brackets = std::max<std::int64_t>(0, brackets - 1);
    if (brackets > 1000) return report(i, "nested too deeply", "at most 50 levels");
  }
  return true;
}

/// Builds the tree from yaml-cpp's events.
class Builder : public YAML::EventHandler {
 public:
  Builder(const std::string& file, const Lines& lines, Problems& problems)
      : file_(file), lines_(lines), problems_(problems) {}

  Node take() { return std::move(root_); }
  [[nodiscard]] bool has_document() const { return documents_ > 0; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ < 2) return;
    report(mark, "a second document", "a workflow is one document: remove '---' and what follows");
    throw Stop();
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    check(mark, {}, anchor);
    place(make(Node::Kind::nothing, mark));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    report(mark, "an alias", "version 1 has no anchors and aliases: write the value out");
    place(make(Node::Kind::broken, mark));
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check(mark, tag, anchor);
    Node node = make(Node::Kind::scalar, mark);
    node.text = value;
    node.quoted = tag == "!";
    if (!is_clean_text(value)) {
      report(mark, "a control character in a text", "only line feeds and tabs may be escaped");
      node.kind = Node::Kind::broken;
    }
    place(std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    check(mark, tag, anchor);
    open(make(Node::Kind::list, mark));
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    check(mark, tag, anchor);
    open(make(Node::Kind::map, mark));
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    Node node;
    std::optional<Node::Key> key;  ///< of a map: read, and waiting for its value
    bool drop = false;             ///< the value that follows is not kept
    std::unordered_map<std::string, Node::Key> seen;
  };

  void report(const YAML::Mark& mark, std::string what, std::string remedy) {
    const auto [line, column] = lines_.place(mark.line, mark.column);
    problems_.add({file_, line, column}, std::move(what), std::move(remedy));
  }

  Node make(Node::Kind kind, const YAML::Mark& mark) {
    if (++values_ > most_values) {
      report(mark, fmt::format("more than {} values", most_values),
             "large arrays belong in a file under data/");
      throw Stop();
    }
    Node node;
    node.kind = kind;
    std::tie(node.line, node.column) = lines_.place(mark.line, mark.column);
    return node;
  }

  void check(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (anchor != 0) report(mark, "an anchor", "version 1 has no anchors: remove it");
    if (!tag.empty() && tag != "?" && tag != "!") {
      report(mark, "a tag", "version 1 has no tags: remove it");
    }
  }

  void open(Node node) {
    if (open_.size() >= deepest) {
      problems_.add({file_, node.line, node.column}, "nested too deeply",
                    fmt::format("at most {} levels", deepest));
      throw Stop();
    }
    open_.push_back({std::move(node), std::nullopt, false, {}});
  }

  void close() {
    Node done = std::move(open_.back().node);
    open_.pop_back();
    if (done.items.size() > most_items) {
      problems_.add({file_, done.line, done.column},
                    fmt::format("a list or map of more than {} items", most_items),
                    "large arrays belong in a file under data/");
      throw Stop();
    }
    place(std::move(done));
  }

  /// Puts a finished value where it belongs: as the next key, as a key's value, as an item.
  void place(Node node) {
    if (open_.empty()) {
      root_ = std::move(node);
    } else if (open_.back().node.kind == Node::Kind::list) {
      open_.back().node.items.push_back(std::move(node));
    } else if (!open_.back().key) {
      take_key(open_.back(), node);
    } else {
      take_value(open_.back(), std::move(node));
    }
  }

  void take_key(Open& map, const Node& node) {
    const Place here{file_, node.line, node.column};
    map.key = Node::Key{node.text, node.line, node.column};
    map.drop = true;
    if (node.kind == Node::Kind::broken) return;
    if (node.kind != Node::Kind::scalar) {
      problems_.add(here, "a key must be a plain word", "write it in one word before the colon");
      return;
    }
    if (node.text == "<<" && !node.quoted) {
      problems_.add(here, "a merge key", "version 1 has no merge keys: write the keys out");
      return;
    }
    const auto [first, fresh] = map.seen.try_emplace(node.text, *map.key);
    if (!fresh) {
      problems_.add(here, fmt::format("duplicate key {}", in_quotes(node.text)),
                    fmt::format("it is already at line {}, column {}", first->second.line,
                                first->second.column));
      return;
    }
    map.drop = false;
  }

  static void take_value(Open& map, Node node) {
    if (node.kind == Node::Kind::nothing) {
      // yaml-cpp places a missing value at whatever follows it, maybe lines below.
      node.line = map.key->line;
      node.column = map.key->column;
    }
    if (!map.drop) {
      map.node.keys.push_back(std::move(*map.key));
      map.node.items.push_back(std::move(node));
    }
    map.key.reset();
  }

  const std::string& file_;
  const Lines& lines_;
  Problems& problems_;
  std::vector<Open> open_;
  Node root_;
  int documents_ = 0;
  std::size_t values_ = 0;
};

/// Windows line ends and a byte order mark say nothing.
std::string normalized(const std::string& text) {
  std::string result;
  result.reserve(text.size());
  const std::size_t begin = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  for (std::size_t i = begin; i < text.size(); ++i) {
    if (text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n') continue;
    result += text[i];
  }
  return result;
}

Node broken() {
  Node node;
  node.kind = Node::Kind::broken;
  return node;
}

}  // namespace

const Node* Node::find(const std::string& key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].text == key) return &items[i];
  }
  return nullptr;
}

bool is_clean_text(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const char32_t code = utf8::decode(text, at);
    if (code == utf8::invalid || control(code)) return false;
  }
  return true;
}

Node parse_yaml(const std::string& raw, const std::string& file, Problems& problems) {
  if (raw.size() > largest_yaml) {
    problems.add({file, 0, 0}, "the file is larger than 1 MiB",
                 "large arrays belong in a file under data/");
    return broken();
  }
  const std::string text = normalized(raw);
  if (!characters_are_good(text, file, problems)) return broken();
  const Lines lines(text);
  Builder builder(file, lines, problems);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const Stop&) {
    return broken();
  } catch (const YAML::Exception& error) {
    const auto [line, column] = lines.place(error.mark.line, error.mark.column);
    problems.add({file, line, column}, fmt::format("YAML syntax: {}", error.msg),
                 "check colons, quotes, brackets and indentation here and just before");
    return broken();
  }
  if (!builder.has_document()) {
    problems.add({file, 1, 1}, "the file is empty", "begin with 'sandglass: 1'");
    return broken();
  }
  return builder.take();
}

}  // namespace sandglass::workflow
