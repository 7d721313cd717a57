#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/file.hpp"
#include "record/crate.hpp"
#include "record/crate_files.hpp"

namespace sandglass::record {
namespace {

using Json = nlohmann::json;

bool is_file(const Json& type) {
  return type == "File" ||
         (type.is_array() && std::find(type.begin(), type.end(), "File") != type.end());
}

/// The digests in the crate, by path.
std::map<std::string, std::string> digests_in(const std::string& text, const std::string& path) {
  const Json crate = Json::parse(text, nullptr, false);
  std::map<std::string, std::string> digests;
  const auto refuse = [&] { return Error::environment("'" + path + "' cannot be understood"); };
  if (!crate.is_object() || !crate.contains("@graph") || !crate["@graph"].is_array()) {
    throw refuse();
  }
  try {
    for (const Json& entity : crate.at("@graph")) {
      if (!entity.contains("sha256") || !is_file(entity.at("@type"))) continue;
      digests[path_of_id(entity.at("@id").get<std::string>())] =
          entity.at("sha256").get<std::string>();
    }
  } catch (const Json::exception&) {
    throw refuse();
  }
  return digests;
}

bool is_still(const std::string& path, const std::string& digest) {
  std::error_code unseen;
  return std::filesystem::is_regular_file(path, unseen) && digest_of_file(path) == digest;
}

/// Templates, data and solvers as they are now, against what the run used.
std::vector<std::string> changed_since(const std::string& run_directory,
                                       const std::filesystem::path& project,
                                       const std::filesystem::path& build) {
  std::vector<std::string> changed;
  const std::string path = run_directory + "/provenance.json";
  std::error_code unseen;
  if (!std::filesystem::exists(path, unseen)) return changed;
  const Json provenance = Json::parse(read_file(path), nullptr, false);
  if (!provenance.is_object()) return changed;  // then it is among those altered
  // Absolute, or relative to one of the two.
  const auto look = [&](const Json& one) {
    const std::filesystem::path file = one.value("path", "");
    const std::string digest = one.value("digest", "");
    const bool same = digest.empty() || is_still((project / file).string(), digest) ||
                      is_still((build / file).string(), digest);
    const bool known = std::find(changed.begin(), changed.end(), file.string()) != changed.end();
    if (!same && !known) changed.push_back(file.string());
  };
  for (const char* kind : {"templates", "data"}) {
    for (const Json& one : provenance.value(kind, Json::array())) look(one);
  }
  for (const Json& solver : provenance.value("solvers", Json::array())) {
    look(solver);
    for (const Json& part : solver.value("parts", Json::array())) look(part);
  }
  return changed;
}

}  // namespace

Verdict verify(const std::string& run_directory, const std::string& project,
               const std::string& build) {
  const std::string path = run_directory + "/" + kCrateFile;
  std::error_code unseen;
  if (!std::filesystem::is_regular_file(path, unseen)) {
    throw Error::environment("'" + run_directory + "' holds no " + kCrateFile,
                             "it is written when a run ends; 'sandglass resume' ends one that was "
                             "killed");
  }
  const std::string text = read_file(path);
  Verdict verdict;
  verdict.crate_digest = digest_of_text(text);
  std::map<std::string, std::string> expected = digests_in(text, path);
  for (const std::string& file : files_of_crate(run_directory)) {
    ++verdict.files;
    const auto known = expected.find(file);
    if (known == expected.end()) {
      verdict.added.push_back(file);
      continue;
    }
    if (digest_of_file(run_directory + "/" + file) != known->second) {
      verdict.altered.push_back(file);
    }
    expected.erase(known);
  }
  for (const auto& [file, digest] : expected) verdict.missing.push_back(file);
  verdict.changed_since = changed_since(run_directory, project, build);
  return verdict;
}

}  // namespace sandglass::record
