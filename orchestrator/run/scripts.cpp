#include "run/scripts.hpp"

#include <filesystem>
#include <set>
#include <utility>

#include "base/clock.hpp"
#include "base/file.hpp"

namespace sandglass::run {

Scripts::Scripts(std::string templates_root, std::string folder)
    : root_(std::move(templates_root)), folder_(std::move(folder)) {}

const Template& Scripts::get(const std::string& template_path) {
  const auto known = templates_.find(template_path);
  if (known != templates_.end()) return known->second;
  return templates_.emplace(template_path, Template::load(root_, template_path)).first->second;
}

std::string Scripts::render(const std::string& whose, const std::string& template_path,
                            const Value::Map& values, std::int64_t window) {
  const double start = SystemClock().now();
  const std::string text = get(template_path).render(values);
  std::string path;
  if (!folder_.empty()) {
    const std::string digest = digest_of_text(text);
    // The name says to a reader of messages which template it came from.
    const std::filesystem::path source(template_path);
    const std::string name =
        source.stem().string() + "-" + digest.substr(0, 16) + source.extension().string();
    std::string& stored = path_of_name_[name];
    if (stored.empty()) {
      stored = folder_ + "/" + name;
      // There already where a run goes on; files are put in their place whole.
      if (!std::filesystem::exists(stored)) write_file(stored, text);
    }
    const auto [used, is_new] = used_.emplace(std::pair(whose, name), stored_.size());
    if (is_new) stored_.push_back({whose, template_path, stored, digest, {}});
    if (window > 0) {
      auto& windows = stored_[used->second].windows;
      if (windows.empty() || windows.back().second < window - 1) {
        windows.emplace_back(window, window);
      } else {
        windows.back().second = window;
      }
    }
    path = stored;
  }
  seconds_ += SystemClock().now() - start;
  return path;
}

std::vector<record::UsedFile> Scripts::template_files() const {
  std::set<std::string> paths;
  for (const auto& [path, parsed] : templates_) {
    paths.insert(parsed.files().begin(), parsed.files().end());
  }
  std::vector<record::UsedFile> files;
  for (const std::string& path : paths) {
    files.push_back({"templates/" + path, digest_of_file(root_ + "/" + path)});
  }
  return files;
}

Value::Map values_of(const workflow::GivenMap& given, const std::string& run_directory,
                     const std::string& data_root) {
  Value::Map values;
  for (const auto& [name, one] : given) {
    if (!one.file) {
      values[name] = one.value;
    } else if (one.file->stage.empty()) {
      values[name] = data_root + "/" + one.file->file;
    } else {
      values[name] = run_directory + "/stages/" + one.file->stage + "/" + one.file->file;
    }
  }
  return values;
}

}  // namespace sandglass::run
