#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/template.hpp"
#include "workflow/model.hpp"
#include "workflow/scope.hpp"
#include "workflow/structure.hpp"
#include "workflow/values.hpp"

namespace sandglass::workflow {

/// The templates that a workflow names, each read once.
class TemplateShelf {
 public:
  explicit TemplateShelf(std::string root) : root_(std::move(root)) {}

  /// Null, and reported, when there is none or it does not parse.
  const Template* get(const std::string& path, const Place& used_at, Problems& problems);

 private:
  struct Entry {
    bool exists = false;
    std::optional<Template> parsed;
  };
  std::string root_;
  std::map<std::string, Entry> shelf_;
};

/// What the readers of the sections share while one workflow is loaded.
struct Context {
  const Node& root;
  const LoadOptions& options;
  std::string file;
  Problems& problems;
  Scope scope;
  TemplateShelf& templates;

  /// --no-prune asks that what has this name is not left out.
  [[nodiscard]] bool puts_back(const std::string& name) const;
};

/// A named map of a section, such as one stage.
struct Declared {
  std::string name;
  Place place;  ///< of the name
  const Node* node = nullptr;
};

/// So many stages and so many participants at most: with the cases of up to 50 choices each, a file
/// could ask for any amount of checking.
constexpr size_t most_declared = 100;

/// The maps of a section, by name; what is not a map is passed over.
std::vector<Declared> declared_in(const Context& context, const std::string& section);
std::vector<std::string> names_of(const std::vector<Declared>& declared);

/// A stage or participant with one of its cases joined in, and the scope in which that case holds.
struct Variant {
  Scope scope;
  Node node;
};

/// Every variant, the selected one first; just the thing itself when it does not choose. Reports
/// what is wrong with `choose` and `cases`.
std::vector<Variant> variants_of(const Scope& scope, const Declared& declared);

/// The thing as it is in this scope.
Node effective(const Node& node, const Scope& scope);
/// Whether its `when` (if any) holds.
bool applies(const Node& node, const Scope& scope);

/// Whether there is such a file below the folder.
bool is_file_below(const std::string& root, const std::string& path);
/// The files below a folder, relative to it, for suggestions.
std::vector<std::string> files_below(const std::string& root);

}  // namespace sandglass::workflow
