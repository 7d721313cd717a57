#include "run/home.hpp"

#include <cstdlib>
#include <filesystem>

#include "base/error.hpp"

namespace sandglass::run {

Home Home::find() {
  namespace fs = std::filesystem;
  const auto complete = [](const fs::path& folder) {
    return fs::is_directory(folder / "templates") && fs::is_directory(folder / "data");
  };
  const fs::path program = fs::read_symlink("/proc/self/exe");
  Home home;
  home.build = program.parent_path().string();
  if (const char* set = std::getenv("SANDGLASS_HOME"); set != nullptr && *set != '\0') {
    if (!complete(set)) {
      throw Error::environment(
          "SANDGLASS_HOME is '" + std::string(set) + "', which has no templates/ and data/",
          "unset it, or set it to the folder of the checkout");
    }
    home.root = fs::absolute(set).lexically_normal().string();
    return home;
  }
  for (fs::path folder = program.parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    if (complete(folder)) {
      home.root = folder.string();
      return home;
    }
  }
  throw Error::environment("the project's templates/ and data/ are not above " + program.string(),
                           "set SANDGLASS_HOME to the folder of the checkout");
}

}  // namespace sandglass::run
