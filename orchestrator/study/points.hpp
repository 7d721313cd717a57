#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "workflow/model.hpp"

/// A workflow swept over parameters: what to run, what is there already and why not, what came out.
namespace sandglass::study {

/// One point of a study.
struct Point {
  std::string name;                         ///< unique in the study; the name of its folder
  std::string set;                          ///< name of the set of points it belongs to
  std::string label;                        ///< what it has of its own: "window=1 ms, seed=2"
  std::string sample_of;                    ///< the same without seeds and repetition
  std::vector<workflow::Setting> settings;  ///< all of them, as for --set
  std::int64_t repetition = 1;
  bool unstable = false;  ///< expected to be
};

/// The points of a study in the order of the file; settings from the command line hold for all of
/// them. Throws Error::usage for a parameter that is set there and swept, Error::refused for a
/// study of more than 10 000 points or of the same point twice.
std::vector<Point> make_points(const workflow::Study& study,
                               const std::vector<workflow::Setting>& command_line);

}  // namespace sandglass::study
