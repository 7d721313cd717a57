#include "record/run_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
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
constexpr int kHighestNumber = 1'000'000'000;

/// A lock of an open file, not of a process: gone when the last descriptor of it is.
struct flock whole_file(short type) {
  struct flock all {};
  all.l_type = type;
  all.l_whence = SEEK_SET;
  return all;
}

/// The number of "NAME-0007", or 0.
int number_of(const std::string& folder, const std::string& name) {
  if (folder.size() <= name.size() + 1 || folder.compare(0, name.size() + 1, name + "-") != 0)
    return 0;
  int number = 0;
  const char* end = folder.data() + folder.size();
  const auto [rest, error] = std::from_chars(folder.data() + name.size() + 1, end, number);
  const bool counts = error == std::errc() && rest == end && number < kHighestNumber;
  return counts ? number : 0;
}

/// Calls `use` with the name of everything in the folder.
template <typename Use>
void each_entry(const std::string& folder, Use use) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    use(entry->path().filename().string());
  }
  if (error) throw_system_error("read the folder", folder, error.value());
}

std::string next_numbered(const std::string& runs, const std::string& name) {
  make_directories(runs);
  int highest = 0;
  each_entry(
      runs, [&](const std::string& entry) { highest = std::max(highest, number_of(entry, name)); });
  // Another process may take the same number at the same moment: making the folder decides.
  for (int number = highest + 1;; ++number) {
    std::string path = fmt::format("{}/{}-{:04}", runs, name, number);
    std::error_code error;
    if (std::filesystem::create_directory(path, error)) return path;
    if (error) throw_system_error("make the folder", path, error.value());
  }
}

}  // namespace

RunDirectory::RunDirectory(const std::string& path)
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
  struct flock all = whole_file(F_WRLCK);
  if (::fcntl(lock_, F_OFD_SETLK, &all) == 0) return;
  if (errno != EAGAIN && errno != EACCES) throw_system_error("lock the run directory", path, errno);
  throw Error::environment(
      fmt::format("the run directory '{}' is in use by another process", path_),
      "wait for it ('sandglass status' shows it) or choose another with --out");
}

RunDirectory RunDirectory::create(const std::string& path, const std::string& runs,
                                  const std::string& name) {
  RunDirectory directory(path.empty() ? next_numbered(runs, name) : path);
  make_directories(directory.path_);
  const auto used = [&] {
    bool other_things = false;
    each_entry(directory.path_,
               [&](const std::string& entry) { other_things |= "/" + entry != kLockFile; });
    return other_things;
  };
  // A folder with other things and no lock is no run directory: not even a lock is put there.
  std::error_code unseen;
  const bool has_lock = std::filesystem::exists(directory.path_ + kLockFile, unseen);
  if (has_lock || !used()) directory.lock();
  // Asked again: between the question and the lock another process may have used it and ended.
  if (used()) {
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
  // Asked, not tried: a lock held for a moment would turn away whoever wants the directory then.
  struct flock all = whole_file(F_RDLCK);
  const bool busy = ::fcntl(descriptor, F_OFD_GETLK, &all) == 0 && all.l_type != F_UNLCK;
  ::close(descriptor);
  return busy;
}

}  // namespace sandglass::record
