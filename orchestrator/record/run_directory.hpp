#pragma once

#include <string>

namespace sandglass::record {

/// The folder that one run owns, locked against other processes while this object lives.
///
/// | inside | what |
/// | --- | --- |
/// | workflow.yaml, workflow.json | the workflow as given, and as resolved |
/// | scripts/ | every rendered script once, named by its digest |
/// | logs/ | output and errors of every program |
/// | exchange/, work/ | slots; participants' work directories |
/// | stages/NAME/ | what stages made |
/// | record.h5, checkpoints/ | the history of all windows; from where it can be gone on with |
/// | run.json | what the run began with |
/// | provenance.json, status.json, result.json | what was used; how it stands; how it ended |
/// | figures/, report.html | what to look at |
class RunDirectory {
 public:
  /// Makes `path`, or with an empty `path` the next numbered folder "NAME-0001" below `runs`.
  /// Throws Error::environment when it is in use by another process, was used already, or cannot be
  /// written.
  static RunDirectory create(const std::string& path, const std::string& runs,
                             const std::string& name);
  /// Locks a folder that a run has left, to change something in it (a report drawn again).
  static RunDirectory open(const std::string& path);

  RunDirectory(RunDirectory&& other) noexcept;
  RunDirectory& operator=(RunDirectory&&) = delete;
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;
  ~RunDirectory();

  /// Absolute.
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }
  /// Makes the folder `name` inside and returns its absolute path.
  [[nodiscard]] std::string folder(const std::string& name) const;

 private:
  explicit RunDirectory(const std::string& path);
  void lock();

  std::string path_;
  int lock_ = -1;
};

/// True while a process holds the lock of the run directory `path`.
bool in_use(const std::string& path);

}  // namespace sandglass::record
