#include "record/crate_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <string_view>

#include "base/file.hpp"
#include "record/crate.hpp"

namespace sandglass::record {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kOtherFiles = {"lock", "status.json", "reserve",
                                                         kCrateFile};
constexpr std::array<std::string_view, 4> kOtherFolders = {"exchange", "work", "tmp", "replay"};

template <typename Names>
bool is_one_of(const std::string& name, const Names& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::vector<std::string> files_of_crate(const std::string& run_directory) {
  std::vector<std::string> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(run_directory, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const std::string path = entry->path().lexically_relative(run_directory).string();
    if (entry.depth() == 0 && is_one_of(path, kOtherFolders)) {
      entry.disable_recursion_pending();
    } else if (entry->is_regular_file(error) &&
               !(entry.depth() == 0 && is_one_of(path, kOtherFiles)) &&
               entry->path().extension() != ".part") {
      files.push_back(path);
    }
  }
  if (error) throw_system_error("read the folder", run_directory, error.value());
  std::sort(files.begin(), files.end());
  return files;
}

std::string id_of_path(const std::string& path) {
  constexpr std::string_view safe = "-._~/";
  std::string id;
  for (const char character : path) {
    const bool plain =
        (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z') ||
        (character >= '0' && character <= '9') || safe.find(character) != std::string_view::npos;
    if (plain) {
      id += character;
    } else {
      id += fmt::format("%{:02X}", static_cast<unsigned char>(character));
    }
  }
  return id;
}

std::string path_of_id(const std::string& id) {
  std::string path;
  for (std::size_t i = 0; i < id.size(); ++i) {
    unsigned code = 0;
    if (id[i] == '%' && i + 2 < id.size() &&
        std::from_chars(&id[i] + 1, &id[i] + 3, code, 16).ptr == &id[i] + 3) {
      path += static_cast<char>(code);
      i += 2;
    } else {
      path += id[i];
    }
  }
  return path;
}

}  // namespace sandglass::record
