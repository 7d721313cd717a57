#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "render/parsed.hpp"

namespace sandglass::render {

/// Walks a template once with its values: writes the sections taken, checks all of them.
class Renderer {
 public:
  Renderer(const Template::Parsed& parsed, const Value::Map& values);

  void run();

  [[nodiscard]] std::string& out() { return out_; }
  [[nodiscard]] std::vector<Problem> problems() const;
  /// The given names that were looked up.
  [[nodiscard]] const std::set<std::string>& used() const { return used_; }

 private:
  /// What a section adds to the names in sight, outermost first.
  struct Frame {
    const Value* item = nullptr;    // what {{.}} is; a map's members are in sight
    bool unknown = false;           // not taken for lack of items: their members are unknown
    const Node* section = nullptr;  // the list, and
    std::size_t number = 0;         // which item of it, from 1; 0: not an item
  };

  void walk(std::size_t begin, std::size_t end, bool taken);
  void write_text(const Node& node);
  void write(std::size_t index);
  void enter(std::size_t index, bool taken);
  void enter_list(std::size_t index, const Value::List& list, bool taken);
  void walk_body(std::size_t index, Frame frame, bool taken);
  const Value* find(std::size_t index);
  const Value* find_outermost(std::size_t index, const std::string& name);
  const Value* find_member(std::size_t index, const Value& value, std::size_t part);
  void problem(std::size_t index, std::string what, std::string remedy = {});

  struct Finding {
    Problem problem;
    int count = 1;  // how often, at different places
  };

  const Template::Parsed& parsed_;
  const Value::Map& values_;
  std::vector<Frame> frames_;
  std::string out_;
  std::size_t text_end_ = std::string::npos;  // where the last text value ended, and
  std::size_t text_index_ = 0;                // its node
  std::set<std::string> used_;
  std::vector<Finding> findings_;
  std::map<std::string, std::size_t> finding_of_;  // by text
  std::set<std::size_t> blamed_;                   // nodes that have their problem already
};

}  // namespace sandglass::render
