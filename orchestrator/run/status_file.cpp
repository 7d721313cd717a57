#include "run/status_file.hpp"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::run {
namespace {
constexpr double kEvery = 0.5;  // s
}

StatusFile::StatusFile(std::string path, Status& next) : path_(std::move(path)), next_(next) {}

void StatusFile::begin(const Progress& progress) {
  write(progress);
  next_.begin(progress);
}

void StatusFile::window(const Progress& progress) {
  if (progress.elapsed - written_at_ > kEvery) write(progress);
  next_.window(progress);
}

void StatusFile::say(const std::string& text) { next_.say(text); }

void StatusFile::write(const Progress& progress) {
  written_at_ = progress.elapsed;
  const nlohmann::json json = {{"format", 1},
                               {"name", progress.name},
                               {"stage", progress.stage},
                               {"window", progress.window},
                               {"windows", progress.windows},
                               {"time", progress.time},
                               {"end", progress.end},
                               {"elapsed_s", progress.elapsed},
                               {"windows_per_s", progress.rate},
                               {"left_s", progress.left}};
  // Not flushed to the disk: it is worth nothing after a power cut, and it is written often.
  const std::string temporary = path_ + ".part";
  std::ofstream file(temporary);
  file << json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  file.close();
  if (!file) return;  // a full disk: the last status stays
  static_cast<void>(std::rename(temporary.c_str(), path_.c_str()));
}

Progress read_status(const std::string& path) {
  const nlohmann::json json = nlohmann::json::parse(read_file(path), nullptr, false);
  if (!json.is_object()) throw Error::environment("'" + path + "' cannot be understood");
  Progress progress;
  progress.name = json.value("name", "");
  progress.stage = json.value("stage", "");
  progress.window = json.value("window", std::int64_t{0});
  progress.windows = json.value("windows", std::int64_t{0});
  progress.time = json.value("time", 0.0);
  progress.end = json.value("end", 0.0);
  progress.elapsed = json.value("elapsed_s", 0.0);
  progress.rate = json.value("windows_per_s", 0.0);
  progress.left = json.value("left_s", 0.0);
  return progress;
}

}  // namespace sandglass::run
