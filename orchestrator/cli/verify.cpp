#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "record/crate.hpp"
#include "run/home.hpp"

namespace sandglass::cli {
namespace {

void show(const char* what, const std::vector<std::string>& files) {
  for (const std::string& file : files) fmt::print("  {:14} {}\n", what, file);
}

ExitCode execute(const std::string& directory) {
  const run::Home home = run::Home::find();
  const record::Verdict verdict = record::verify(directory, home.root, home.build);
  fmt::print("{}: {} files\n", directory, verdict.files);
  show("altered", verdict.altered);
  show("missing", verdict.missing);
  show("added", verdict.added);
  show("changed since", verdict.changed_since);
  fmt::print("digest of {}: {}\n", record::kCrateFile, verdict.crate_digest);
  if (verdict.whole()) {
    fmt::print("every file is what the run left\n");
    return ExitCode::done;
  }
  throw Error::mismatch(
      fmt::format("'{}' is not what the run left: {} altered, {} missing, {} added", directory,
                  verdict.altered.size(), verdict.missing.size(), verdict.added.size()));
}

}  // namespace

void add_verify(CLI::App& app, Session& session) {
  auto path = std::make_shared<std::string>();
  CLI::App* verb =
      add_verb(app, "verify", "check every file of a run against its digest (exit 6: a difference)",
               "  sandglass verify runs/icy_stokes_sphere-0001");
  verb->add_option("run", *path, "the run directory")->required()->type_name("RUN");
  verb->callback([&session, path] { session.action = [path] { return execute(*path); }; });
}

}  // namespace sandglass::cli
