#pragma once

#include <string>

namespace sandglass::run {

/// Where the project's files are: the folder with templates/ and data/, and the folder of the
/// running program with what was built beside it.
struct Home {
  std::string root;   ///< of the checkout
  std::string build;  ///< of the running program

  [[nodiscard]] std::string templates() const { return root + "/templates"; }
  [[nodiscard]] std::string data() const { return root + "/data"; }
  /// Where `setup` puts an optional solver: a private Python environment.
  [[nodiscard]] std::string solver_folder(const std::string& name) const {
    return root + "/.build/solvers/" + name;
  }
  /// The FreeFEM plugin `sandglass`.
  [[nodiscard]] std::string plugin_folder() const { return build + "/freefem"; }

  /// SANDGLASS_HOME when it is set; else the nearest folder above the program that has templates/.
  /// Throws Error::environment when there is none.
  static Home find();
};

}  // namespace sandglass::run
