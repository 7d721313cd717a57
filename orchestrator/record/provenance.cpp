#include "record/provenance.hpp"

#include <sys/utsname.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>

#include "base/file.hpp"

extern char** environ;  // NOLINT: the name is POSIX's

namespace sandglass::record {
namespace {

/// The value behind "key : value" in the first such line of a system file.
std::string first_value(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const size_t colon = line.find_first_of(":=");
    if (colon == std::string::npos) continue;
    const size_t first = line.find_first_not_of(" \t\"", colon + 1);
    const size_t last = line.find_last_not_of(" \t\"");
    return first == std::string::npos ? "" : line.substr(first, last - first + 1);
  }
  return {};
}

}  // namespace

std::string package_version(const std::string& package) {
  std::ifstream file("/var/lib/dpkg/status");
  const std::string wanted = "Package: " + package;
  bool here = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("Package: ", 0) == 0) here = line == wanted;
    if (here && line.rfind("Version: ", 0) == 0) return line.substr(9);
  }
  return {};
}

UsedProgram identify(const std::string& name, const std::string& program,
                     const std::string& package, const std::vector<std::string>& parts,
                     const DigestOf& digest) {
  UsedProgram used{name, find_program(program), package_version(package), {}, {}};
  if (!used.path.empty()) used.digest = digest(used.path);
  for (const std::string& part : parts) {
    std::error_code error;
    if (std::filesystem::is_regular_file(part, error)) {
      used.parts.push_back({part, digest(part)});
    }
  }
  return used;
}

nlohmann::json describe_machine() {
  utsname system{};
  ::uname(&system);
  double load = 0;
  ::getloadavg(&load, 1);
  return {{"name", system.nodename},
          {"system", first_value("/etc/os-release", "PRETTY_NAME") + ", " + system.sysname + " " +
                         system.release + " " + system.machine},
          {"processor", first_value("/proc/cpuinfo", "model name")},
          {"load", load},
          {"cores", ::sysconf(_SC_NPROCESSORS_ONLN)},
          {"memory_bytes", static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                               static_cast<double>(::sysconf(_SC_PAGE_SIZE))}};
}

nlohmann::json describe_environment() {
  constexpr std::array<std::string_view, 7> telling = {
      "OMP_", "FF_", "PYTHON", "LANG", "LC_", "SANDGLASS_", "LD_LIBRARY_PATH"};
  nlohmann::json result = nlohmann::json::object();
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const size_t equals = text.find('=');
    if (equals == std::string_view::npos) continue;
    if (text.rfind("SANDGLASS_HOME=", 0) == 0) continue;  // a place, not an influence
    for (const std::string_view start : telling) {
      if (text.rfind(start, 0) == 0) {
        result[std::string(text.substr(0, equals))] = std::string(text.substr(equals + 1));
      }
    }
  }
  return result;
}

nlohmann::json to_json(const std::vector<UsedFile>& files) {
  nlohmann::json list = nlohmann::json::array();
  for (const UsedFile& file : files) list.push_back({{"path", file.path}, {"digest", file.digest}});
  return list;
}

nlohmann::json to_json(const UsedProgram& program) {
  return {{"name", program.name},
          {"path", program.path},
          {"version", program.version},
          {"digest", program.digest},
          {"parts", to_json(program.parts)}};
}

}  // namespace sandglass::record
