#include "report/profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>

#include "base/error.hpp"
#include "base/file.hpp"
#include "hdf5/hdf5.hpp"

namespace sandglass::report {
namespace {

using Json = nlohmann::json;

/// The orchestrator's own columns of the record, and what they are called here.
struct Own {
  std::string_view column;
  const char* shown;
};
constexpr std::array<Own, 4> kOwn = {{{"exchange", "exchange"},
                                      {"render", "render"},
                                      {"record", "record"},
                                      {"orchestrator", "waiting"}}};
constexpr std::int64_t kMostSlices = 20'000;

/// The columns of all complete windows.
struct Columns {
  struct Column {
    std::string name;
    std::vector<double> seconds;
  };
  std::int64_t windows = 0;
  bool at_once = false;  ///< participants work at the same time
  std::vector<Column> participants;
  std::vector<Column> own;
};

Json read_json(const std::string& path) {
  std::error_code unseen;
  if (!std::filesystem::is_regular_file(path, unseen)) return Json::object();
  Json json = Json::parse(read_file(path), nullptr, false);
  return json.is_object() ? json : Json::object();
}

Columns read_columns(const std::string& run_directory) {
  const std::string path = run_directory + "/record.h5";
  std::error_code unseen;
  if (!std::filesystem::is_regular_file(path, unseen)) {
    throw Error::environment("'" + run_directory + "' holds no record.h5",
                             "name the directory of a run that came to its coupling");
  }
  const hdf5::File record(path, hdf5::File::Mode::read);
  Columns columns;
  columns.windows = record.read_counts("/windows").at(0);
  const auto read = [&](const std::string& name) {
    return record.read_numbers("/timings/" + name, columns.windows);
  };
  const std::vector<std::string> names = record.list("/timings");
  for (const Own& own : kOwn) {
    if (std::find(names.begin(), names.end(), own.column) == names.end()) continue;
    columns.own.push_back({own.shown, read(std::string(own.column))});
  }
  const Json coupling =
      read_json(run_directory + "/workflow.json").value("coupling", Json::object());
  columns.at_once = coupling.value("scheme", "") == "parallel-explicit";
  for (const std::string& name : coupling.value("order", std::vector<std::string>{})) {
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    columns.participants.push_back({name, read(name)});
  }
  return columns;
}

double sum(const std::vector<double>& seconds, std::int64_t begin, std::int64_t end) {
  return std::accumulate(seconds.begin() + begin, seconds.begin() + end, 0.0);
}

class Trace {
 public:
  explicit Trace(const Columns& columns) : columns_(columns) {
    name_line(0, "orchestrator");
    for (std::size_t p = 0; p < columns.participants.size(); ++p) {
      name_line(p + 1, columns.participants[p].name);
    }
    const std::int64_t share = std::max<std::int64_t>(1, columns.windows / kMostSlices);
    for (std::int64_t begin = 0; begin < columns.windows; begin += share) {
      add_windows(begin, std::min(columns.windows, begin + share));
    }
  }

  [[nodiscard]] std::string text() const {
    return "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n" + events_ + "\n]}\n";
  }

 private:
  void add(const Json& event) {
    if (!events_.empty()) events_ += ",\n";
    events_ += event.dump(-1, ' ', false, Json::error_handler_t::replace);
  }

  void name_line(std::size_t line, const std::string& name) {
    add({{"name", "thread_name"},
         {"ph", "M"},
         {"pid", 1},
         {"tid", line},
         {"args", {{"name", name}}}});
  }

  /// A slice of `seconds` that begins at `at`.
  void add_slice(std::size_t line, const std::string& name, double at, double seconds,
                 const std::string& windows) {
    if (seconds <= 0) return;
    add({{"name", name},
         {"ph", "X"},
         {"pid", 1},
         {"tid", line},
         {"ts", 1e6 * at},
         {"dur", 1e6 * seconds},
         {"args", {{"windows", windows}}}});
  }

  void add_windows(std::int64_t begin, std::int64_t end) {
    const std::string windows =
        end == begin + 1 ? fmt::format("{}", end) : fmt::format("{} to {}", begin + 1, end);
    const double start = now_;
    double longest = 0;
    for (std::size_t p = 0; p < columns_.participants.size(); ++p) {
      const auto& [name, all] = columns_.participants[p];
      const double seconds = sum(all, begin, end);
      add_slice(p + 1, name, columns_.at_once ? start : now_, seconds, windows);
      longest = std::max(longest, seconds);
      if (!columns_.at_once) now_ += seconds;
    }
    if (columns_.at_once) now_ += longest;
    for (const auto& [name, all] : columns_.own) {
      const double seconds = sum(all, begin, end);
      add_slice(0, name, now_, seconds, windows);
      now_ += seconds;
    }
  }

  const Columns& columns_;
  std::string events_;
  double now_ = 0;
};

/// What provenance.json says of the time beside the windows.
void add_aside(const Json& timings, const std::string& coupling_stage, Profile& profile) {
  const auto add = [&](const std::string& name, const Json& value) {
    if (value.is_number() && value.get<double>() > 0) {
      profile.rows.push_back({name, value.get<double>(), true});
    }
  };
  add("start", timings.value("start", Json()));
  add("checkpoints", timings.value("checkpoints", Json()));
  const Json stages = timings.value("stages", Json::object());
  for (const auto& [name, seconds] : stages.items()) {
    if (name != coupling_stage) add("stage " + name, seconds);
  }
  add("report", timings.value("report", Json()));
}

}  // namespace

Profile read_profile(const std::string& run_directory) {
  const Columns columns = read_columns(run_directory);
  Profile profile;
  profile.windows = columns.windows;
  std::vector<double> longest(static_cast<std::size_t>(columns.windows));
  for (const auto& [name, seconds] : columns.participants) {
    profile.rows.push_back({name, sum(seconds, 0, columns.windows)});
    for (std::size_t k = 0; k < longest.size(); ++k) {
      longest[k] = columns.at_once ? std::max(longest[k], seconds[k]) : longest[k] + seconds[k];
    }
  }
  profile.loop_seconds = sum(longest, 0, columns.windows);
  for (const auto& [name, seconds] : columns.own) {
    profile.rows.push_back({name, sum(seconds, 0, columns.windows)});
    profile.loop_seconds += profile.rows.back().seconds;
  }
  std::string coupling_stage;
  for (const Json& stage :
       read_json(run_directory + "/workflow.json").value("stages", Json::array())) {
    if (stage.value("run", "") == "coupling") coupling_stage = stage.value("name", "");
  }
  add_aside(read_json(run_directory + "/provenance.json").value("timings", Json::object()),
            coupling_stage, profile);
  return profile;
}

void write_trace(const std::string& run_directory, const std::string& path) {
  write_file(path, Trace(read_columns(run_directory)).text());
}

}  // namespace sandglass::report
