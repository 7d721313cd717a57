#include "record/run_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <filesystem>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::record {
namespace {

constexpr const char* kLockFile = "/lock";

/// The number of "NAME-0007", or 0.
int number_of(const std::string& folder, const std::string& name) {
  if (folder.size() <= name.size() + 1 || folder.compare(0, name.size() + 1, name + "-") != 0) return 0;
  int number = 0;
  const char* end = folder.data() + folder.size();
  const auto [rest, error] = std::from_chars(folder.data() + name.size() + 1, end, number);
  return error == std::errc() && rest == end ? number : 0;
}

std::string next_numbered(const std::string& runs, const std::string& name) {
  make_directories(runs);
  int highest = 0;
  for (const auto& entry : std::filesystem::directory_iterator(runs)) {
    highest = std::max(highest, number_of(entry.path().filename().string(), name));
  }
  // Another process may take the same number at the same moment: making the folder decides.
  for (int number = highest + 1;; ++number) {
    const std::string path = fmt::format("{}/{}-{:04}", runs, name, number);
    std::error_code error;
    if (std::filesystem::create_directory(path, error)) return path;
    if (error) throw_system_error("make the folder", path, error.value());
  }
}

}  // namespace

RunDirectory::RunDirectory(std::string path)
    : path_(std::filesystem::absolute(path).lexically_normal().string()) {
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
}

RunDirectory::RunDirectory(RunDirectory&& other) noexcept
    : path_(std::move(other.path_)), lock_(std::exchange(other.lock_, -1)) {}

RunDirectory::~RunDirectory() {
  if (lock_ >= 0) ::close(lock_);
}

void RunDirectory::lock() {
  const std::string path = path_ + kLockFile;
  lock_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0) throw_system_error("lock the run directory", path, errno);
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    throw Error::environment(
        fmt::format("the run directory '{}' is in use by another process", path_),
        "wait for it ('sandglass status' shows it) or choose another with --out");
  }
}

RunDirectory RunDirectory::create(const std::string& path, const std::string& runs,
                                  const std::string& name) {
  RunDirectory directory(path.empty() ? next_numbered(runs, name) : path);
  make_directories(directory.path_);
  const bool was_there = std::filesystem::exists(directory.path_ + kLockFile);
  bool other_things = false;
  for (const auto& entry : std::filesystem::directory_iterator(directory.path_)) {
    if (entry.path().filename() != "lock") other_things = true;
  }
  if (was_there || !other_things) directory.lock();
  if (other_things) {
    throw Error::environment(
        fmt::format("the run directory '{}' was already used: it is not empty", directory.path_),
        "choose another with --out, or leave --out away to get a new numbered one");
  }
  return directory;
}

RunDirectory RunDirectory::open(const std::string& path) {
  RunDirectory directory(path);
  if (!std::filesystem::is_directory(directory.path_)) {
    throw Error::environment(fmt::format("there is no run directory '{}'", path));
  }
  directory.lock();
  return directory;
}

std::string RunDirectory::folder(const std::string& name) const {
  std::string path = file(name);
  make_directories(path);
  return path;
}

bool in_use(const std::string& path) {
  const int descriptor = ::open((path + kLockFile).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool busy = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return busy;
}

}  // namespace sandglass::record
