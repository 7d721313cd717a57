#include "run/replay.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "base/unit.hpp"
#include "cli/cli.hpp"
#include "cli/terminal.hpp"

namespace sandglass::cli {
namespace {

struct Options {
  std::string run;
  std::int64_t window = 0;
  bool all = false;
};

std::string windows_text(const run::Replayed& replayed) {
  if (replayed.first == replayed.last) return fmt::format("window {}", replayed.last);
  return fmt::format("windows {} to {}", replayed.first, replayed.last);
}

ExitCode execute(const Options& options) {
  if (options.all == (options.window > 0)) {
    throw Error::usage("which windows are to be repeated?", "give either --window K or --all");
  }
  run::Replayed replayed;
  {
    TerminalStatus status;
    replayed = run::replay(options.run, options.window, run::Home::find(), status);
  }
  const std::string from =
      replayed.behind == 0 ? "from the start"
                           : fmt::format("from the checkpoint behind window {}", replayed.behind);
  if (replayed.differences.empty()) {
    fmt::print("{} repeated {}: every byte of {} agrees with the record\n", windows_text(replayed),
               from, fmt::join(replayed.datasets, ", "));
    return ExitCode::done;
  }
  std::string differing;
  for (const run::Replayed::Difference& one : replayed.differences) {
    differing +=
        fmt::format("\n  {}: window {}, position {}: recorded {}, repeated {}", one.dataset,
                    one.window, one.position, shortest(one.recorded), shortest(one.repeated));
  }
  throw Error::mismatch(fmt::format("{} repeated {}: not the bytes of the record{}",
                                    windows_text(replayed), from, differing));
}

}  // namespace

void add_replay(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = add_verb(
      app, "replay", "repeat windows of a run in new processes and compare bytes with its record",
      "  sandglass replay runs/icy_stokes_sphere-0001 --window 17\n"
      "  sandglass replay runs/icy_stokes_sphere-0001 --all");
  verb->add_option("run", options->run, "the run directory")->required()->type_name("RUN");
  verb->add_option("--window", options->window,
                   "this window, from the nearest checkpoint before it, or from the start")
      ->check([](const std::string& text) {
        return text.empty() || text[0] == '-' || text.find_first_not_of('0') == text.npos
                   ? "windows are counted from 1"
                   : std::string();
      })
      ->type_name("K");
  verb->add_flag("--all", options->all, "all windows, from the start");
  verb->callback([&session, options] { session.action = [options] { return execute(*options); }; });
}

}  // namespace sandglass::cli
