#include "record/checkpoint.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>

#include "base/error.hpp"
#include "base/file.hpp"
#include "hdf5/hdf5.hpp"

namespace sandglass::record {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnfinished = ".part";
constexpr const char* kCoupling = "/coupling.h5";
constexpr const char* kElapsed = "/elapsed";
constexpr const char* kArrays = "/memory";

void flush(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw_system_error("flush", path, errno);
  const bool flushed = ::fsync(descriptor) == 0;
  const int number = errno;
  ::close(descriptor);
  if (!flushed) throw_system_error("flush", path, number);
}

/// A folder counts as flushed when all that is in it is.
void flush_all(const std::string& path) {
  if (fs::is_directory(path)) {
    for (const auto& entry : fs::directory_iterator(path)) flush_all(entry.path().string());
  }
  flush(path);
}

void remove_all(const std::string& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) throw_system_error("remove", path, error.value());
}

/// First its name, then its content: half of a checkpoint is never taken for one.
void discard(const std::string& path) {
  if (path.ends_with(kUnfinished)) return remove_all(path);
  const std::string unfinished = path + kUnfinished;
  remove_all(unfinished);
  std::error_code error;
  fs::rename(path, unfinished, error);
  if (error) throw_system_error("rename", path, error.value());
  remove_all(unfinished);
}

std::optional<std::int64_t> window_of(const std::string& name) {
  std::int64_t window = 0;
  const char* end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data(), end, window);
  if (error != std::errc() || rest != end) return std::nullopt;
  return window;
}

std::vector<std::int64_t> windows_in(const std::string& folder) {
  std::vector<std::int64_t> found;
  if (!fs::is_directory(folder)) return found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (const auto window = window_of(entry.path().filename().string())) found.push_back(*window);
  }
  std::sort(found.begin(), found.end());
  return found;
}

constexpr const char* kFolder = "checkpoints";

}  // namespace

std::vector<std::int64_t> windows_with_checkpoint(const std::string& run_directory) {
  return windows_in(run_directory + "/" + kFolder);
}

Checkpoints::Checkpoints(const RunDirectory& directory) : folder_(directory.file(kFolder)) {}

std::string Checkpoints::path(std::int64_t window) const {
  return fmt::format("{}/{:09}", folder_, window);
}

std::vector<std::int64_t> Checkpoints::windows() const { return windows_in(folder_); }

std::optional<std::int64_t> Checkpoints::newest(std::int64_t until) const {
  std::optional<std::int64_t> best;
  for (const std::int64_t window : windows()) {
    if (window <= until) best = window;
  }
  return best;
}

std::string Checkpoints::state_of(std::int64_t window, const std::string& participant) const {
  return path(window) + "/" + participant;
}

CouplingState Checkpoints::coupling_state(std::int64_t window) const {
  const hdf5::File file(path(window) + kCoupling, hdf5::File::Mode::read);
  CouplingState state;
  state.elapsed = file.read_numbers(kElapsed).at(0);
  for (const std::string& name : file.list(kArrays)) {
    state.arrays[name] = file.read_numbers(std::string(kArrays) + "/" + name);
  }
  return state;
}

std::string Checkpoints::begin(std::int64_t window) const {
  std::string unfinished = path(window) + kUnfinished;
  remove_all(unfinished);
  make_directories(unfinished);
  return unfinished;
}

void Checkpoints::complete(std::int64_t window, const CouplingState& state) const {
  const std::string unfinished = path(window) + kUnfinished;
  {
    hdf5::File file(unfinished + kCoupling, hdf5::File::Mode::create);
    file.set_attribute("/", "filetype", "sandglass checkpoint");
    file.set_attribute("/", "version", std::vector<std::int64_t>{1, 0});
    file.write("/window", {1}, std::vector<std::int64_t>{window});
    file.write(kElapsed, {1}, std::vector<double>{state.elapsed});
    for (const auto& [name, values] : state.arrays) {
      file.write(std::string(kArrays) + "/" + name, {static_cast<std::int64_t>(values.size())},
                 values);
    }
    file.close();
  }
  flush_all(unfinished);
  std::error_code error;
  fs::rename(unfinished, path(window), error);
  if (error) throw_system_error("rename", unfinished, error.value());
  flush(folder_);
}

void Checkpoints::keep(std::int64_t count) const {
  const std::vector<std::int64_t> all = windows();
  for (std::size_t i = 0; i + static_cast<std::size_t>(count) < all.size(); ++i) {
    discard(path(all[i]));
  }
}

void Checkpoints::drop_behind(std::int64_t window) const {
  if (!fs::is_directory(folder_)) return;
  std::vector<std::string> dropped;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const auto number = window_of(entry.path().filename().string());
    if (!number || *number > window) dropped.push_back(entry.path().string());
  }
  for (const std::string& one : dropped) {
    if (fs::exists(one)) discard(one);
  }
}

}  // namespace sandglass::record
