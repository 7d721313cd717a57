#include "study/directory.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/file.hpp"
#include "record/checkpoint.hpp"
#include "record/record.hpp"

namespace sandglass::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A record that cannot be read may hold something all the same.
bool has_recorded(const std::string& run) {
  try {
    return record::windows_of(run + "/record.h5") > 0;
  } catch (const Error&) {
    return true;
  }
}

}  // namespace

bool Outcome::final() const {
  if (state != State::ended) return false;
  const auto code = static_cast<ExitCode>(result->exit_code);
  return code == ExitCode::done || code == ExitCode::unstable || code == ExitCode::mismatch;
}

bool Outcome::good(const Point& point) const {
  if (!final()) return false;
  return (static_cast<ExitCode>(result->exit_code) == ExitCode::unstable) == point.unstable;
}

std::string StudyDirectory::run_of(const std::string& point) const {
  return file("points/" + point);
}

std::string StudyDirectory::log_of(const std::string& point) const {
  return file("logs/" + point + ".log");
}

MadeOf StudyDirectory::made_of(const std::string& point) const {
  const std::string path = file("made_of/" + point + ".json");
  std::error_code error;
  return fs::exists(path, error) ? made_of_from_json(read_file(path)) : MadeOf{};
}

void StudyDirectory::prepare(const std::string& point, const MadeOf& made_of) const {
  for (const char* folder : {"points", "made_of", "logs"}) make_directories(file(folder));
  // In this order: what lies in points/POINT is at every moment what made_of/POINT.json says.
  std::error_code error;
  if (has_recorded(run_of(point))) keep_replaced(point);
  for (const std::string& old : {run_of(point), log_of(point)}) {
    fs::remove_all(old, error);
    if (error) throw_system_error("remove", old, error.value());
  }
  write_file(file("made_of/" + point + ".json"), to_json(made_of));
}

void StudyDirectory::keep_replaced(const std::string& point) const {
  const std::string kept = file("replaced/" + point);
  make_directories(file("replaced"));
  std::error_code error;
  fs::remove_all(kept, error);
  if (error) throw_system_error("remove", kept, error.value());
  fs::rename(run_of(point), kept, error);
  if (error) throw_system_error("move", run_of(point), error.value());
}

Outcome StudyDirectory::outcome(const std::string& point) const {
  Outcome outcome;
  const std::string run = run_of(point);
  std::error_code error;
  if (record::in_use(run)) {
    outcome.state = Outcome::State::running;
  } else if (fs::exists(run + "/result.json", error)) {
    try {
      outcome.result = report::read_result(run);
      outcome.state = Outcome::State::ended;
    } catch (const Error&) {
      outcome.state = Outcome::State::left;  // it cannot be understood: run again
    }
  }
  return outcome;
}

bool StudyDirectory::has_checkpoint(const std::string& point) const {
  return !record::windows_with_checkpoint(run_of(point)).empty();
}

void StudyDirectory::require_own() const {
  if (is_study(path_)) return;
  for (const auto& entry : fs::directory_iterator(path_)) {
    if (entry.path().filename() == "lock") continue;
    throw Error::environment(fmt::format("the folder '{}' is not empty, and no study's", path_),
                             "choose another with --out");
  }
}

void StudyDirectory::write(const std::string& study_file, const std::vector<Entry>& entries) const {
  json points = json::array();
  for (const Entry& entry : entries) {
    points.push_back(
        {{"name", entry.point}, {"twin_of", entry.twin_of}, {"unstable", entry.unstable}});
  }
  write_file(file("study.json"),
             json{{"format", 1}, {"file", study_file}, {"points", points}}.dump(1) + "\n");
}

std::vector<StudyDirectory::Entry> StudyDirectory::read() const {
  std::vector<Entry> entries;
  try {
    const json kept = json::parse(read_file(file("study.json")));
    for (const json& point : kept.at("points")) {
      entries.push_back({point.at("name"), point.at("twin_of"), point.at("unstable")});
    }
  } catch (const json::exception& error) {
    throw Error::environment("'" + file("study.json") + "' cannot be understood: " + error.what());
  }
  return entries;
}

bool is_study(const std::string& path) {
  std::error_code error;
  return fs::exists(path + "/study.json", error);
}

}  // namespace sandglass::study
