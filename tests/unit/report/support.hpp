#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "base/file.hpp"
#include "report/analysis.hpp"

namespace sandglass::report {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// A folder that is gone when the test is over.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sandglass-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~Folder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Writes a file, and the folders above it.
  std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = std::filesystem::path(path_) / name;
    std::filesystem::create_directories(path.parent_path());
    write_file(path.string(), text);
    return path.string();
  }

 private:
  std::string path_;
};

/// The error's code and text, of something that must throw Error.
template <typename Action>
std::pair<ExitCode, std::string> error_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return {error.code(), error.what()};
  }
  return {ExitCode::done, "nothing was thrown"};
}

inline Curve curve_of(std::vector<double> x, std::vector<double> y) {
  Curve curve;
  curve.stage = "analyse";
  curve.x = {"time", "s", std::move(x), {}};
  curve.y = {"velocity", "m/s", std::move(y), {}};
  return curve;
}

}  // namespace sandglass::report
