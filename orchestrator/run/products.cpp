#include "run/products.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/file.hpp"
#include "run/solvers.hpp"

namespace sandglass::run {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kMade = "/made.json";

std::string stage_folder(const workflow::Stage& stage, const record::RunDirectory& directory) {
  return directory.file("stages/" + stage.name);
}

std::string text_of(const Made& made) {
  const Json json = {{"format", 1},
                     {"made_of", made.made_of},
                     {"products", record::to_json(made.products)},
                     {"seconds", made.seconds},
                     {"taken", made.taken}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string kept_root() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value ? value : "");
  };
  if (const std::string kept = variable("SANDGLASS_KEPT"); !kept.empty()) return kept;
  if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty()) {
    return cache + "/sandglass";
  }
  const std::string user = variable("HOME");
  return user.empty() ? user : user + "/.cache/sandglass";
}

}  // namespace

void store_made(const workflow::Stage& stage, const record::RunDirectory& directory,
                const std::string& made_of, double seconds) {
  const std::string folder = stage_folder(stage, directory);
  Made made{made_of, {}, seconds, false};
  for (const std::string& product : stage.makes) {
    made.products.push_back({product, digest_of_file(folder + "/" + product)});
  }
  write_file(folder + kMade, text_of(made));
}

std::optional<Made> made_in(const std::string& folder) {
  std::error_code unseen;
  if (!fs::exists(folder + kMade, unseen)) return std::nullopt;
  try {
    const Json json = Json::parse(read_file(folder + kMade));
    Made made{json.at("made_of"), {}, json.at("seconds"), json.value("taken", false)};
    for (const Json& one : json.at("products")) {
      made.products.push_back({one.at("path"), one.at("digest")});
      if (digest_of_file(folder + "/" + made.products.back().path) != made.products.back().digest) {
        return std::nullopt;
      }
    }
    return made;
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void copy_made(const Made& made, const std::string& from, const std::string& to) {
  make_directories(to);
  for (const record::UsedFile& product : made.products) {
    const fs::path target = fs::path(to) / product.path;
    make_directories(target.parent_path().string());
    std::error_code error;
    fs::copy_file(fs::path(from) / product.path, target, fs::copy_options::overwrite_existing,
                  error);
    if (error) throw_system_error("copy a product to", target.string(), error.value());
  }
  // Last: it says that they are whole.
  write_file(to + kMade, text_of(made));
}

KeptProducts::KeptProducts() : root_(kept_root()) {}

std::string KeptProducts::folder(const workflow::Stage& stage, const std::string& made_of) const {
  return fmt::format("{}/{}-{}", root_, stage.name, made_of.substr(0, 16));
}

std::string KeptProducts::made_of(const workflow::Stage& stage, const Home& home,
                                  const record::RunDirectory& directory, Scripts& scripts,
                                  const record::UsedProgram& program) {
  Json all;
  all["program"] = record::to_json(program);
  all["command"] = stage.command;
  all["makes"] = stage.makes;
  if (!stage.template_path.empty()) {
    // Paths are left out: where a run lies does not decide what is made.
    all["script"] = scripts.get(stage.template_path).render(values_of(stage.given, "RUN", "DATA"));
  }
  for (const auto& [name, given] : stage.given) {
    if (!given.file) continue;
    const std::string path =
        given.file->stage.empty()
            ? home.data() + "/" + given.file->file
            : directory.file("stages/" + given.file->stage) + "/" + given.file->file;
    all["inputs"][name] = digest_of_file(path);
  }
  return digest_of_text(all.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::optional<Made> KeptProducts::take(const workflow::Stage& stage, const std::string& made_of,
                                       const record::RunDirectory& directory) const {
  if (root_.empty()) return std::nullopt;
  const std::string kept = folder(stage, made_of);
  std::optional<Made> made = made_in(kept);
  if (!made || made->made_of != made_of) return std::nullopt;
  made->taken = true;
  try {
    copy_made(*made, kept, stage_folder(stage, directory));
  } catch (const Error&) {
    return std::nullopt;  // what cannot be taken is made
  }
  return made;
}

void KeptProducts::keep(const workflow::Stage& stage, const std::string& made_of,
                        const record::RunDirectory& directory) const {
  if (root_.empty()) return;
  const std::optional<Made> made = made_in(stage_folder(stage, directory));
  if (!made) return;
  const std::string kept = folder(stage, made_of);
  // Another run that made the same may be there already, and a third one copying from it.
  if (const auto there = made_in(kept); there && there->made_of == made_of) return;
  const std::string unfinished = fmt::format("{}.{}.part", kept, ::getpid());
  std::error_code ignored;
  try {
    copy_made(*made, stage_folder(stage, directory), unfinished);
    fs::remove_all(kept, ignored);
    fs::rename(unfinished, kept, ignored);
  } catch (const Error&) {
    // The disk of the cache is full, or not ours to write: the run has what it needs.
  }
  fs::remove_all(unfinished, ignored);
}

}  // namespace sandglass::run
