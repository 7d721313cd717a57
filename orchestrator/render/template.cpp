#include "render/template.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include "render/parser.hpp"
#include "render/renderer.hpp"

namespace sandglass {
namespace {

/// Reads root/path; when there is no such file, names the nearest one of the same folder.
std::string read_template(const std::string& root, const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path whole = fs::path(root) / path;
  std::error_code failed;
  if (!fs::is_regular_file(whole, failed)) {
    std::vector<std::string> others;
    const fs::path folder = fs::path(path).parent_path();
    for (fs::directory_iterator file(fs::path(root) / folder, failed), end; !failed && file != end;
         file.increment(failed)) {
      if (file->is_regular_file(failed))
        others.push_back((folder / file->path().filename()).generic_string());
    }
    std::sort(others.begin(), others.end());
    throw Error::refused(Place{}, fmt::format("there is no template '{}'", path),
                         suggestion(path, others));
  }
  std::ifstream file(whole, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) throw Error::environment(fmt::format("'{}' cannot be read", whole.string()));
  return text;
}

}  // namespace

Language language_of(const std::string& path) {
  static constexpr std::array<std::pair<std::string_view, Language>, 10> endings{{
      {".py", Language::python},
      {".edp", Language::freefem},
      {".idp", Language::freefem},
      {".geo", Language::gmsh},
      {".in", Language::lammps},
      {".lmp", Language::lammps},
      {".sh", Language::shell},
      {".sbatch", Language::shell},
      {".json", Language::json},
      {".html", Language::html},
  }};
  for (const auto& [ending, language] : endings) {
    if (path.ends_with(ending)) return language;
  }
  return Language::text;
}

Template Template::load(const std::string& root, const std::string& path) {
  return parse(read_template(root, path), path, language_of(path),
               [&](const std::string& block) { return read_template(root, block); });
}

Template Template::parse(const std::string& text, const std::string& path, Language language,
                         const std::function<std::string(const std::string&)>& read) {
  Template made;
  made.parsed_ = render::Parser(path, language, read).parse(text);
  return made;
}

std::string Template::render(const Value::Map& values) const {
  render::Renderer renderer(*parsed_, values);
  renderer.run();
  std::vector<Problem> problems = renderer.problems();
  if (!problems.empty()) throw Error::refused(std::move(problems));
  return std::move(renderer.out());
}

std::vector<Problem> Template::check(
    const Value::Map& values, const std::function<Place(const std::string& name)>& given_at) const {
  render::Renderer renderer(*parsed_, values);
  renderer.run();
  std::vector<Problem> problems = renderer.problems();
  const std::vector<std::string> used(parsed_->names.begin(), parsed_->names.end());
  for (const auto& [name, value] : values) {
    if (renderer.used().contains(name)) continue;
    problems.push_back({given_at ? given_at(name) : Place{},
                        fmt::format("'{}' is given to {} and never used there", name, path()),
                        used.empty() ? "the template uses no names" : suggestion(name, used)});
  }
  return problems;
}

const std::set<std::string>& Template::names() const { return parsed_->names; }
const std::vector<std::string>& Template::files() const { return parsed_->files; }
const std::string& Template::path() const { return parsed_->path; }
Language Template::language() const { return parsed_->language; }

}  // namespace sandglass
