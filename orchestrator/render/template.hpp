#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "render/value.hpp"

namespace sandglass {

/// The language a template is written in decides how a value is quoted.
enum class Language { python, freefem, gmsh, lammps, shell, json, html, text };

/// By the file's ending (.py .edp .idp .geo .in .lmp .sh .sbatch .json .html); others are plain
/// text.
Language language_of(const std::string& path);

/// The value as a literal of the language. Numbers always read as real numbers where the language
/// tells them apart (1.0), negative ones stand in brackets where the language has operators.
/// Throws Error::refused (without a place) for a value that the language cannot hold as data:
/// numbers that are not finite everywhere; in FreeFEM also backslashes, other characters than ASCII
/// and counts beyond 32 bits; in gmsh line ends, both kinds of quotes at once, more than 1023 bytes
/// and gmsh's own words (If, EndIf); in LAMMPS all but plain words; in a shell line ends.
std::string quote(const Value& value, Language language);

/// A strict, logic-less template: the mustache subset {{name}}, {{a.b}}, {{.}},
/// {{#name}}..{{/name}},
/// {{^name}}..{{/name}}, {{! comment}}, {{> other/file}} (a building block, read below the same
/// root; without an ending it has that of the template). {{name.choice}} is true when the choice
/// value `name` is set to `choice`. There is no unescaped output, no delimiter change, no lambda.
/// A section, comment or building block alone in its line takes the line with it; a building block
/// is indented like its tag. Sections nest at most 100 deep.
///
/// Values bring their own quotes. A tag inside a string of the language, or inside /* */, is
/// therefore refused; in a comment to the end of the line it is harmless. In HTML a tag stands in
/// text or in a quoted attribute; inside <script> and <style> no text is written.
///
/// Parsed once, rendered as often as wanted.
class Template {
 public:
  /// Reads `root`/`path`. Throws Error::refused with every syntax error at file:line:column
  /// (columns count characters), or with the nearest file when there is none of this name.
  static Template load(const std::string& root, const std::string& path);
  /// The same from memory; a building block is asked of `read` (empty function: none allowed),
  /// which throws an Error when there is none.
  static Template parse(const std::string& text, const std::string& path, Language language,
                        const std::function<std::string(const std::string&)>& read = {});

  /// Renders with these values. Throws Error::refused listing, in one pass, every name that is used
  /// but not given (with its place and the nearest given name; in sections that are not taken too)
  /// and every value of an unfit type. Names given but not used are no error here.
  [[nodiscard]] std::string render(const Value::Map& values) const;

  /// As render, without the text: the problems only, among them names given but never used
  /// (placed at `given_at` of that name where known). Empty when all is well. The members of an
  /// empty list's items are unknown, so a name in its section that is not given is not reported.
  [[nodiscard]] std::vector<Problem> check(
      const Value::Map& values,
      const std::function<Place(const std::string& name)>& given_at) const;

  /// The first part of every name the template uses, building blocks included. Which of the names
  /// inside a section are members of its items is known only with values: all of them are here.
  [[nodiscard]] const std::set<std::string>& names() const;
  /// The files it was made of: itself and its building blocks, relative to the root.
  [[nodiscard]] const std::vector<std::string>& files() const;
  [[nodiscard]] const std::string& path() const;
  [[nodiscard]] Language language() const;

  struct Parsed;

 private:
  std::shared_ptr<const Parsed> parsed_;
};

}  // namespace sandglass
