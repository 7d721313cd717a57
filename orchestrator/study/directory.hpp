#pragma once

#include <optional>
#include <string>
#include <vector>

#include "record/run_directory.hpp"
#include "report/result.hpp"
#include "study/made_of.hpp"
#include "study/points.hpp"

namespace sandglass::study {

/// How a point stands.
struct Outcome {
  enum class State {
    left,     ///< nothing there, or its run ended without a result
    running,  ///< a process works in its directory
    ended     ///< with `result`
  };
  State state = State::left;
  std::optional<report::Result> result;

  /// A result that another run would only repeat: done, unstable, or out of tolerance.
  [[nodiscard]] bool final() const;
  /// It ended as the study expects.
  [[nodiscard]] bool good(const Point& point) const;
};

/// The folder that a study owns.
///
/// | inside | what |
/// | --- | --- |
/// | study.json | its points, for `status` and `compare` |
/// | points/POINT/ | run directories |
/// | replaced/POINT/ | the run before, whose place that one has taken |
/// | made_of/POINT.json | what the run in points/ was started from |
/// | logs/POINT.log | what the run said |
/// | memory.json, seen.json | how files looked; what the last complete call found |
/// | summary/ | the report of the study, a run directory itself: points.json, points.csv, ... |
class StudyDirectory {
 public:
  explicit StudyDirectory(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }
  [[nodiscard]] std::string run_of(const std::string& point) const;
  [[nodiscard]] std::string log_of(const std::string& point) const;
  [[nodiscard]] std::string summary() const { return file("summary"); }

  /// What the point's run was started from; empty when it never was.
  [[nodiscard]] MadeOf made_of(const std::string& point) const;
  /// Takes away what an earlier run of the point has left, to replaced/ where it has recorded
  /// anything, and notes what the next one is made of.
  void prepare(const std::string& point, const MadeOf& made_of) const;
  [[nodiscard]] Outcome outcome(const std::string& point) const;
  /// The point's run left a checkpoint to go on behind.
  [[nodiscard]] bool has_checkpoint(const std::string& point) const;

  /// study.json: the points in order and, where a point is another one's twin, whose.
  struct Entry {
    std::string point;
    std::string twin_of;  ///< the point whose run is this one's too; empty: its own
    bool unstable = false;
  };
  void write(const std::string& study_file, const std::vector<Entry>& entries) const;
  /// Throws Error::environment when there are other things in the folder, and no study.
  void require_own() const;
  /// Throws Error::environment when the folder is no study's.
  [[nodiscard]] std::vector<Entry> read() const;

 private:
  void keep_replaced(const std::string& point) const;

  std::string path_;
};

/// True for a folder that holds a study.
bool is_study(const std::string& path);

}  // namespace sandglass::study
