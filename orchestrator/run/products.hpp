#pragma once

#include <optional>
#include <string>
#include <vector>

#include "record/provenance.hpp"
#include "record/run_directory.hpp"
#include "run/home.hpp"
#include "run/scripts.hpp"
#include "workflow/model.hpp"

namespace sandglass::run {

/// What a stage has made, kept beside its products in made.json.
struct Made {
  std::string made_of;  ///< digest of all that decides the products; empty where nobody asked
  std::vector<record::UsedFile> products;  ///< relative to the stage's folder
  double seconds = 0;                      ///< that making them took
  bool taken = false;                      ///< made by another run, and taken over
};

/// Stores what the stage made in its folder of the run.
void store_made(const workflow::Stage& stage, const record::RunDirectory& directory,
                const std::string& made_of, double seconds);
/// What lies in the folder, or nothing where made.json is missing or a product is not what it says.
std::optional<Made> made_in(const std::string& folder);

/// Copies what lies in folder `from`, and says the same of it in folder `to`.
void copy_made(const Made& made, const std::string& from, const std::string& to);

/// Products of stages with `reuse: true`, kept between runs: one folder per stage and digest of
/// all that decides them (script, input files, solver), below $SANDGLASS_KEPT, else
/// $XDG_CACHE_HOME/sandglass, else ~/.cache/sandglass.
class KeptProducts {
 public:
  KeptProducts();

  /// The digest of all that decides what the stage makes; its input files must be there.
  static std::string made_of(const workflow::Stage& stage, const Home& home,
                             const record::RunDirectory& directory, Scripts& scripts,
                             const record::UsedProgram& program);
  /// Copies what is kept into the stage's folder of the run. Nothing where nothing whole is kept.
  std::optional<Made> take(const workflow::Stage& stage, const std::string& made_of,
                           const record::RunDirectory& directory) const;
  /// Keeps what the stage has made in the run. A failure costs nothing but the next run's time.
  void keep(const workflow::Stage& stage, const std::string& made_of,
            const record::RunDirectory& directory) const;

 private:
  [[nodiscard]] std::string folder(const workflow::Stage& stage, const std::string& made_of) const;
  std::string root_;  ///< empty: nowhere
};

}  // namespace sandglass::run
