#include "run/stage.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "base/error.hpp"
#include "base/file.hpp"
#include "run/solvers.hpp"

namespace sandglass::run {
namespace {

/// FreeFEM exits with status 0 on singular matrices too: a script says when it is content.
constexpr const char* kFinished = "sandglass: finished";

/// The stored script under the stage's own name in its work directory: gmsh takes paths as relative
/// to its script, and messages name something readable.
std::string linked(const std::string& script, const std::string& directory,
                   const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path link = fs::path(directory) / (name + fs::path(script).extension().string());
  std::error_code error;
  fs::create_symlink(fs::relative(script, directory), link, error);
  if (error) throw_system_error("link the script", link.string(), error.value());
  return link.string();
}

[[noreturn]] void fail(const workflow::Stage& stage, const std::string& log,
                       const std::string& what) {
  throw Error::participant(fmt::format("stage {} {}", stage.name, what), {}, end_of_log(log));
}

}  // namespace

Exit run_stage(const workflow::Stage& stage, const Home& home,
               const record::RunDirectory& directory, Scripts& scripts) {
  const std::string work = directory.folder("stages/" + stage.name);
  std::string script;
  if (!stage.template_path.empty()) {
    script = linked(scripts.render(stage.name, stage.template_path,
                                   values_of(stage.given, directory.path(), home.data())),
                    work, stage.name);
  }
  Command command = stage_command(home, stage, script);
  command.directory = work;
  command.log = directory.folder("logs") + "/" + stage.name + ".log";
  if (stage.analysis) command.environment["SANDGLASS_RECORD"] = directory.file("record.h5");
  // A run that was resumed goes on with its log.
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(command.log, none);
  const std::size_t begin = none ? 0 : static_cast<std::size_t>(size);
  const Exit ended = run_to_end("stage " + stage.name, command, stage.deadline);
  for (const std::string& made : stage.makes) {
    if (!std::filesystem::exists(command.directory + "/" + made)) {
      fail(stage, command.log, fmt::format("ended well but did not make '{}'", made));
    }
  }
  if (stage.program == workflow::Program::freefem &&
      read_file(command.log).find(kFinished, begin) == std::string::npos) {
    fail(stage, command.log, "ended without its end marker (sandglassFinished)");
  }
  return ended;
}

}  // namespace sandglass::run
