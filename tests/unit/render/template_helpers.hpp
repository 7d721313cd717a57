#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "render/template.hpp"

namespace sandglass {

using Blocks = std::map<std::string, std::string>;

/// A template "t.txt" with these building blocks.
inline Template parsed(const std::string& text, Language language = Language::text,
                       const Blocks& blocks = {}) {
  if (blocks.empty()) return Template::parse(text, "t.txt", language);
  return Template::parse(text, "t.txt", language, [&](const std::string& path) {
    const auto found = blocks.find(path);
    if (found == blocks.end()) throw Error::refused(Place{}, "no '" + path + "'");
    return found->second;
  });
}

inline std::vector<std::string> texts(const std::vector<Problem>& problems) {
  std::vector<std::string> all;
  all.reserve(problems.size());
  for (const Problem& problem : problems) all.push_back(problem.text());
  return all;
}

/// What the parser has against the text.
inline std::vector<std::string> parse_problems(const std::string& text,
                                               Language language = Language::text,
                                               const Blocks& blocks = {}) {
  try {
    (void)parsed(text, language, blocks);
    return {};
  } catch (const Error& error) {
    return texts(error.problems());
  }
}

/// The message of the refusal that `action` must end with; empty when it did not.
template <typename Action>
std::string refusal(Action action) {
  try {
    action();
    return {};
  } catch (const Error& error) {
    return error.code() == ExitCode::refused ? error.what() : "wrong exit code";
  }
}

inline void write_file(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace sandglass
