#pragma once

#include <string>

#include "run/status.hpp"

namespace sandglass::run {

/// Keeps status.json of a run directory up to date (at most every half second), for `sandglass
/// status` of a running run, and hands everything on to the terminal's status.
class StatusFile final : public Status {
 public:
  StatusFile(std::string path, Status& next);
  void begin(const Progress& progress) override;
  void window(const Progress& progress) override;
  void say(const std::string& text) override;

 private:
  void write(const Progress& progress);
  std::string path_;
  Status& next_;
  double written_at_ = -1e9;
};

/// status.json as it was last written. Throws Error::environment.
Progress read_status(const std::string& path);

}  // namespace sandglass::run
