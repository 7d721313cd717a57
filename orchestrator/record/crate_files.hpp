#pragma once

#include <string>
#include <vector>

namespace sandglass::record {

/// The files of a run directory that belong to its result, relative to it, sorted: all but locks,
/// slots, work directories, the state of a running run, and the crate's description itself.
std::vector<std::string> files_of_crate(const std::string& run_directory);

/// A relative path as the @id of a file, and back: what is not safe in a URI is percent-encoded.
std::string id_of_path(const std::string& path);
std::string path_of_id(const std::string& id);

}  // namespace sandglass::record
