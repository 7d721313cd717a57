#pragma once

#include <functional>
#include <string>
#include <vector>

#include "run/home.hpp"

namespace sandglass::run {

/// What was found of one thing that runs need.
struct Finding {
  std::string name;
  std::string role;
  bool good = false;
  bool optional = false;
  std::string version;
  std::string text;    ///< what it did in its trial, or what is wrong
  std::string remedy;  ///< the command that mends it
  double seconds = 0;  ///< its trial took
};

/// Runs every solver once on a trivial case and checks the file system; each finding is handed over
/// as it comes.
void examine(const Home& home, const std::function<void(const Finding&)>& found);

}  // namespace sandglass::run
