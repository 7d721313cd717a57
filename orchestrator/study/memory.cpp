#include "study/memory.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::study {
namespace {

using nlohmann::json;

/// All zero where there is no such file.
FileMemory::Looks looks_of(const std::string& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return {};
  const auto nanoseconds = [](const timespec& time) {
    constexpr std::int64_t second = 1'000'000'000;
    return static_cast<std::int64_t>(time.tv_sec) * second + time.tv_nsec;
  };
  return {static_cast<std::uint64_t>(found.st_size),
          std::max(nanoseconds(found.st_mtim), nanoseconds(found.st_ctim)),
          static_cast<std::uint64_t>(found.st_ino)};
}

}  // namespace

FileMemory::FileMemory(std::string path) : path_(std::move(path)) {
  try {
    const json kept = json::parse(read_file(path_));
    for (const auto& [file, one] : kept.at("files").items()) {
      before_[file] = {{one.at("size"), one.at("changed_ns"), one.at("number")}, one.at("digest")};
    }
  } catch (const json::exception&) {
    before_.clear();  // it is only a memory
  } catch (const Error&) {
    before_.clear();
  }
}

std::string FileMemory::digest(const std::string& path) {
  if (const auto known = now_.find(path); known != now_.end() && !known->second.digest.empty()) {
    return known->second.digest;
  }
  Known entry{looks_of(path), {}};
  const auto remembered = before_.find(path);
  if (remembered != before_.end() && remembered->second.looks == entry.looks) {
    entry.digest = remembered->second.digest;
  }
  if (entry.digest.empty() && entry.looks != Looks{}) {
    try {
      entry.digest = digest_of_file(path);
    } catch (const Error&) {
      entry.digest.clear();  // unreadable: whoever needs the file will say so
    }
  }
  now_[path] = entry;
  return entry.digest;
}

void FileMemory::look(const std::string& path) {
  now_.try_emplace(path, Known{looks_of(path), {}});
}

bool FileMemory::all_unchanged() const {
  return !before_.empty() && std::all_of(before_.begin(), before_.end(), [](const auto& one) {
    return looks_of(one.first) == one.second.looks;
  });
}

void FileMemory::keep() const {
  json files = json::object();
  for (const auto& [file, one] : now_) {
    files[file] = {{"size", one.looks.size},
                   {"changed_ns", one.looks.changed_ns},
                   {"number", one.looks.number},
                   {"digest", one.digest}};
  }
  write_file(path_, json{{"format", 1}, {"files", files}}.dump(1) + "\n");
}

}  // namespace sandglass::study
