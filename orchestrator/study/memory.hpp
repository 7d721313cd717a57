#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace sandglass::study {

/// Digests of files, remembered from call to call as long as a file's size, time of change and
/// number stay what they were: reading whole solvers takes far longer than looking at them.
class FileMemory {
 public:
  /// What a look at a file says of it.
  struct Looks {
    std::uint64_t size = 0;
    std::int64_t changed_ns = 0;  ///< time of the last change of its content or its place
    std::uint64_t number = 0;     ///< inode
    bool operator==(const Looks&) const = default;
  };

  /// `path` is where it is kept; nothing there, or nothing legible, is an empty memory.
  explicit FileMemory(std::string path);

  /// The digest of the file; empty when it cannot be read. The file is one of those looked at now.
  std::string digest(const std::string& path);
  /// Remembers how the file looks, without a digest: it matters when it changes.
  void look(const std::string& path);
  /// True when all files that the kept memory knew look as they did. Reads none.
  [[nodiscard]] bool all_unchanged() const;
  /// Keeps the files looked at since the start, and no others.
  void keep() const;

 private:
  struct Known {
    Looks looks;
    std::string digest;
  };
  std::string path_;
  std::map<std::string, Known> before_;
  std::map<std::string, Known> now_;
};

}  // namespace sandglass::study
