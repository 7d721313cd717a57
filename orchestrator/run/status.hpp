#pragma once

#include <cstdint>
#include <string>

namespace sandglass::run {

/// How far a run is.
struct Progress {
  std::string name;   ///< of the run directory
  std::string stage;  ///< what is being done
  std::int64_t window = 0;
  std::int64_t windows = 0;  ///< 0: not in the coupling
  double time = 0;           ///< physical time reached, s
  double end = 0;            ///< physical time wanted, s
  double elapsed = 0;        ///< s since the run began
  double rate = 0;           ///< windows per second, recently
  double left = 0;           ///< s of the coupling still to come, at this rate
};

/// Who wants to know; the only way in which a run speaks while it runs.
class Status {
 public:
  virtual ~Status() = default;
  /// Something was begun: "prepare", a stage's name, "report".
  virtual void begin(const Progress& progress) = 0;
  /// A window was done. Called often: must be cheap.
  virtual void window(const Progress& progress) = 0;
  /// One sentence worth keeping on the screen.
  virtual void say(const std::string& text) = 0;
};

/// Nobody wants to know.
class Silence final : public Status {
 public:
  void begin(const Progress&) override {}
  void window(const Progress&) override {}
  void say(const std::string&) override {}
};

}  // namespace sandglass::run
