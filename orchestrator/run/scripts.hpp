#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "record/provenance.hpp"
#include "render/template.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// Templates rendered for one run. Each text is stored once, under the name of its template
/// and its digest, in scripts/.
class Scripts {
 public:
  /// `folder` is the run's scripts/; empty: render without storing (a dry run).
  Scripts(std::string templates_root, std::string folder);

  /// Renders the template with these values and returns the path of the stored script. `whose` is
  /// the stage or participant, for the provenance; so is `window`, where the text is of one window
  /// only, in rising order.
  std::string render(const std::string& whose, const std::string& template_path,
                     const Value::Map& values, std::int64_t window = 0);
  /// The parsed template; each is read once.
  const Template& get(const std::string& template_path);

  struct Stored {
    std::string whose;
    std::string template_path;
    std::string path;
    std::string digest;
    /// First and last of the windows it was used in; empty: in all of them.
    std::vector<std::pair<std::int64_t, std::int64_t>> windows;
  };
  [[nodiscard]] const std::vector<Stored>& stored() const { return stored_; }
  /// The template files that were read, with digests.
  [[nodiscard]] std::vector<record::UsedFile> template_files() const;
  /// Seconds spent rendering and storing so far.
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  std::string root_;
  std::string folder_;
  std::map<std::string, Template> templates_;
  std::map<std::string, std::string> path_of_name_;  ///< by template and digest
  std::vector<Stored> stored_;                       ///< once for everybody who uses it
  std::map<std::pair<std::string, std::string>, std::size_t> used_;  ///< whose, name: in stored_
  double seconds_ = 0;
};

/// The values that a template is given: parameters and literals as they are, files as absolute
/// paths (`run_directory`/stages/STAGE/FILE, or `data_root`/FILE).
Value::Map values_of(const workflow::GivenMap& given, const std::string& run_directory,
                     const std::string& data_root);

}  // namespace sandglass::run
