#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/file.hpp"

namespace sandglass::record {

/// A file that a run used, by digest (SHA-256).
struct UsedFile {
  std::string path;
  std::string digest;
};

/// A program that a run used.
struct UsedProgram {
  std::string name;
  std::string path;
  std::string version;  ///< of its Debian package; empty when it comes from elsewhere
  std::string digest;
  std::vector<UsedFile> parts;  ///< libraries and helpers that decide what it computes
};

/// The digest of the file at a path: digest_of_file, or something that remembers.
using DigestOf = std::function<std::string(const std::string& path)>;

/// Looks the program up on PATH, with its package's version and digests of itself and of `parts`
/// (paths; those that are not there are passed over).
UsedProgram identify(const std::string& name, const std::string& program,
                     const std::string& package, const std::vector<std::string>& parts = {},
                     const DigestOf& digest = digest_of_file);

/// Version of an installed Debian package; empty when it is not installed.
std::string package_version(const std::string& package);

/// Name, system, processor, cores, memory and load (average of a minute) of this machine.
nlohmann::json describe_machine();

/// The environment variables that can change what a solver computes (OMP_*, FF_*, PYTHON*, LANG,
/// LC_*, LD_LIBRARY_PATH, SANDGLASS_*), and no others: the rest may hold secrets.
nlohmann::json describe_environment();

nlohmann::json to_json(const UsedProgram& program);
nlohmann::json to_json(const std::vector<UsedFile>& files);

}  // namespace sandglass::record
