#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/file.hpp"
#include "workflow/comparisons.hpp"
#include "workflow/context.hpp"
#include "workflow/coupling.hpp"
#include "workflow/keys.hpp"
#include "workflow/model.hpp"
#include "workflow/parameters.hpp"
#include "workflow/participants.hpp"
#include "workflow/stages.hpp"
#include "workflow/structure.hpp"
#include "workflow/study.hpp"
#include "workflow/yaml.hpp"

namespace sandglass::workflow {
namespace {

/// A file of another version is not checked against this one's keys.
void check_version(const Node& root, const std::string& file) {
  const Node* version = root.find("sandglass");
  if (!version || version->kind != Node::Kind::scalar) return;
  if (version->text == std::to_string(format_version)) return;
  throw Error::refused({file, version->line, version->column},
                       fmt::format("format version {}", in_quotes(version->text)),
                       fmt::format("this program reads version {}", format_version));
}

/// The names under --no-prune must be those of something that can be left out.
void check_kept_names(const Node& root, const LoadOptions& options) {
  std::vector<std::string> valid;
  const auto collect = [&](const Node* map) {
    if (!map || map->kind != Node::Kind::map) return;
    for (const Node::Key& key : map->keys) valid.push_back(key.text);
  };
  collect(root.find("left_out"));
  if (const Node* coupling = root.find("coupling")) collect(coupling->find("fields"));
  const Node* stages = root.find("stages");
  for (std::size_t i = 0; stages && stages->kind == Node::Kind::map && i < stages->keys.size(); ++i)
    if (stages->items[i].find("reuse")) valid.push_back(stages->keys[i].text);
  for (const std::string& name : options.keep) {
    if (std::find(valid.begin(), valid.end(), name) != valid.end()) continue;
    throw Error::usage(fmt::format("nothing called {} can be left out", in_quotes(name)),
                       suggest(name, valid));
  }
}

}  // namespace

Workflow load(const std::string& path, const LoadOptions& options) {
  std::error_code unknown;
  if (std::filesystem::file_size(path, unknown) > largest_yaml && !unknown) {
    return load_text(std::string(largest_yaml + 1, ' '), path, options);  // refused, but not read
  }
  require_regular_file(path);
  return load_text(read_file(path), path, options);
}

Workflow load_text(const std::string& text, const std::string& path, const LoadOptions& options) {
  Problems problems;
  const Node root = parse_yaml(text, path, problems);
  if (root.kind == Node::Kind::broken) problems.raise_if_any();
  if (root.kind != Node::Kind::map) {
    throw Error::refused({path, std::max(root.line, 1), std::max(root.column, 1)},
                         "a workflow is a map", "begin with 'sandglass: 1'");
  }
  check_version(root, path);
  check_kept_names(root, options);

  Workflow workflow;
  workflow.path = path;
  workflow.changes = options;
  workflow.parameters = read_parameters(root, path, options.settings, problems);
  const Scope scope(path, workflow.parameters, &problems);
  check_structure(root, objects().front(), {path, 1, 1}, false, scope);

  const Section section(root, objects().front(), scope);
  workflow.name = section.text("name");
  workflow.title = section.text("title", workflow.name);
  workflow.description = section.text("description");
  TemplateShelf templates(options.templates_root);
  const Context context{root, options, path, problems, scope, templates};
  read_left_out(context, workflow);
  read_participants(context, workflow);
  read_coupling(context, workflow);
  read_stages(context, workflow);
  read_comparisons(context, workflow);
  read_study(context, workflow);
  if (workflow.coupling) {
    const std::string windows = std::to_string(workflow.coupling->windows);
    for (LeftOut& item : workflow.left_out) {
      for (size_t at = item.what.find("{windows}"); at != std::string::npos;
           at = item.what.find("{windows}", at + windows.size())) {
        item.what.replace(at, std::string("{windows}").size(), windows);
      }
    }
  }
  problems.raise_if_any();
  return workflow;
}

}  // namespace sandglass::workflow
