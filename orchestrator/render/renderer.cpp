#include "render/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "render/quote.hpp"

namespace sandglass::render {
namespace {

const Value switched_on(true);
const Value switched_off(false);

std::vector<std::string> keys(const Value::Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

bool is_text(const Value& value) {
  return value.as<std::string>() != nullptr || value.as<Value::Choice>() != nullptr;
}

/// True where text becomes a literal between quotes that must stand apart from its neighbours.
bool writes_literals(Language language) {
  return language == Language::python || language == Language::freefem ||
         language == Language::gmsh || language == Language::json;
}

/// Behind these a string literal would read as something else: f'..', ''..', 2"..".
bool joins_text(const std::string& out, Language language) {
  if (!writes_literals(language) || out.empty()) return false;
  const auto last = static_cast<unsigned char>(out.back());
  return std::isalnum(last) != 0 || last == '_' || last == '\'' || last == '"' || last >= 0x80;
}

}  // namespace

Renderer::Renderer(const Template::Parsed& parsed, const Value::Map& values)
    : parsed_(parsed), values_(values) {
  constexpr std::size_t per_value = 24;
  out_.reserve(parsed.text_size + per_value * parsed.nodes.size());
}

void Renderer::run() { walk(0, parsed_.nodes.size(), true); }

std::vector<Problem> Renderer::problems() const {
  std::vector<Problem> all;
  for (const Finding& finding : findings_) {
    Problem problem = finding.problem;
    if (finding.count > 1) problem.what += fmt::format(" (used {} times)", finding.count);
    all.push_back(std::move(problem));
  }
  return all;
}

void Renderer::problem(std::size_t index, std::string what, std::string remedy) {
  if (!blamed_.insert(index).second) return;
  const auto [known, added] = finding_of_.try_emplace(what, findings_.size());
  if (added) {
    findings_.push_back(
        {{parsed_.place(parsed_.nodes[index]), std::move(what), std::move(remedy)}});
  } else {
    ++findings_[known->second].count;
  }
}

void Renderer::walk(std::size_t begin, std::size_t end, bool taken) {
  for (std::size_t index = begin; index < end;) {
    const Node& node = parsed_.nodes[index];
    switch (node.kind) {
      case Node::Kind::text:
        if (taken) write_text(node);
        ++index;
        break;
      case Node::Kind::value:
        if (taken) {
          write(index);
        } else {
          find(index);
        }
        ++index;
        break;
      case Node::Kind::section:
      case Node::Kind::inverted:
        enter(index, taken);
        index = node.end;
        break;
    }
  }
}

void Renderer::write_text(const Node& node) {
  // An empty text and a quote behind it could be three quotes: the begin of a long string.
  const bool quoted = node.text.starts_with('\'') || node.text.starts_with('"');
  if (quoted && out_.size() == text_end_ && writes_literals(parsed_.language)) {
    problem(text_index_,
            fmt::format("a quote stands directly behind the text '{}'",
                        shown(parsed_.nodes[text_index_].text)),
            "a value brings its own quotes: put a blank or an operator behind it");
  }
  out_ += node.text;
}

void Renderer::write(std::size_t index) {
  const Value* value = find(index);
  if (!value) return;
  const Node& node = parsed_.nodes[index];
  const std::string name = shown(node.text);
  if (value->absent()) return problem(index, fmt::format("'{}' has no value", name));
  if (is_text(*value)) {
    if (node.raw) {
      return problem(index,
                     fmt::format("the text '{}' would be code inside <script> or <style>", name));
    }
    if (joins_text(out_, parsed_.language)) {
      return problem(
          index, fmt::format("the text '{}' stands directly behind a letter, digit or quote", name),
          "a value brings its own quotes: put a blank or an operator before it");
    }
  }
  try {
    append_quoted(out_, *value, parsed_.language);
    if (is_text(*value)) {
      text_end_ = out_.size();
      text_index_ = index;
    }
  } catch (const Error& error) {
    const Problem& first = error.problems().front();
    problem(index, fmt::format("'{}' cannot be written: {}", name, first.what), first.remedy);
  }
}

void Renderer::enter(std::size_t index, bool taken) {
  const Node& node = parsed_.nodes[index];
  const bool inverted = node.kind == Node::Kind::inverted;
  const Value* value = find(index);
  if (!value) return walk_body(index, {.unknown = true}, false);
  if (const bool* flag = value->as<bool>())
    return walk(index + 1, node.end, taken && *flag != inverted);
  if (const auto* list = value->as<Value::List>()) return enter_list(index, *list, taken);
  if (value->as<Value::Map>()) {
    if (inverted) return walk(index + 1, node.end, false);
    return walk_body(index, {.item = value}, taken);
  }
  if (value->absent()) {
    if (inverted) return walk(index + 1, node.end, taken);
    return walk_body(index, {.unknown = true}, false);
  }
  const std::string name = shown(node.text);
  if (const auto* choice = value->as<Value::Choice>()) {
    problem(index, fmt::format("the choice '{}' stands in a section without a name", name),
            fmt::format("ask for one of its names: {{{{{}{}.{}}}}}", inverted ? '^' : '#', name,
                        choice->choices.empty() ? choice->name : choice->choices.front()));
  } else {
    problem(index, fmt::format("'{}' is a {}: a section needs a switch, a list, or a choice", name,
                               value->type_name()));
  }
  walk_body(index, {.unknown = true}, false);
}

void Renderer::enter_list(std::size_t index, const Value::List& list, bool taken) {
  const Node& node = parsed_.nodes[index];
  if (node.kind == Node::Kind::inverted) return walk(index + 1, node.end, taken && list.empty());
  if (list.empty()) return walk_body(index, {.unknown = true}, false);
  std::size_t number = 0;
  for (const Value& item : list) {
    walk_body(index, {.item = &item, .section = &node, .number = ++number}, taken);
  }
}

void Renderer::walk_body(std::size_t index, Frame frame, bool taken) {
  frames_.push_back(frame);
  walk(index + 1, parsed_.nodes[index].end, taken);
  frames_.pop_back();
}

/// The value of a tag's name; nullptr when there is none (then that is a problem already) or when
/// it may belong to an item of a list that has none.
const Value* Renderer::find(std::size_t index) {
  const Node& node = parsed_.nodes[index];
  if (node.parts.empty()) {
    if (frames_.empty()) {
      problem(index, "'{{.}}' stands outside of a list", "{{.}} is the item of the list around it");
      return nullptr;
    }
    for (auto frame = frames_.rbegin(); frame != frames_.rend(); ++frame) {
      if (frame->unknown) return nullptr;
      if (frame->item) return frame->item;
    }
    return nullptr;
  }
  const Value* value = find_outermost(index, node.parts.front());
  for (std::size_t part = 1; value && part < node.parts.size(); ++part) {
    if (value->absent()) return value;
    value = find_member(index, *value, part);
  }
  return value;
}

const Value* Renderer::find_outermost(std::size_t index, const std::string& name) {
  bool unknown = false;
  const Frame* item = nullptr;  // the innermost item of a list
  for (auto frame = frames_.rbegin(); frame != frames_.rend(); ++frame) {
    unknown = unknown || frame->unknown;
    if (!item && frame->number > 0) item = &*frame;
    const auto* map = frame->item ? frame->item->as<Value::Map>() : nullptr;
    if (!map) continue;
    if (const auto found = map->find(name); found != map->end()) return &found->second;
  }
  if (const auto found = values_.find(name); found != values_.end()) {
    used_.insert(name);
    return &found->second;
  }
  if (unknown) return nullptr;
  std::vector<std::string> candidates = keys(values_);
  for (const Frame& frame : frames_) {
    const auto* map = frame.item ? frame.item->as<Value::Map>() : nullptr;
    if (!map) continue;
    for (std::string& key : keys(*map)) candidates.push_back(std::move(key));
  }
  std::string what = fmt::format("'{}' is not given", shown(name));
  if (item)
    what += fmt::format(", nor has item {} of '{}' such a member", item->number,
                        shown(item->section->text));
  problem(index, std::move(what), suggestion(name, candidates));
  return nullptr;
}

const Value* Renderer::find_member(std::size_t index, const Value& value, std::size_t part) {
  const Node& node = parsed_.nodes[index];
  const std::string& member = node.parts[part];
  std::string whole = node.parts.front();
  for (std::size_t i = 1; i < part; ++i) whole += '.' + node.parts[i];
  whole = shown(whole);
  if (const auto* map = value.as<Value::Map>()) {
    if (const auto found = map->find(member); found != map->end()) return &found->second;
    problem(index, fmt::format("'{}' has no member '{}'", whole, shown(member)),
            suggestion(member, keys(*map)));
  } else if (const auto* choice = value.as<Value::Choice>()) {
    if (choice->name == member) return &switched_on;
    const std::vector<std::string>& all = choice->choices;
    if (std::find(all.begin(), all.end(), member) != all.end()) return &switched_off;
    problem(index, fmt::format("'{}' is not a choice of '{}'", shown(member), whole),
            suggestion(member, all));
  } else {
    problem(index, fmt::format("'{}' is a {} and has no members, so no '{}'", whole,
                               value.type_name(), shown(member)));
  }
  return nullptr;
}

}  // namespace sandglass::render
