#include "study/study.hpp"

#include <fmt/format.h>

#include <memory>

#include "base/clock.hpp"
#include "cli/cli.hpp"
#include "cli/terminal.hpp"

namespace sandglass::cli {
namespace {

struct Choices {
  WorkflowOptions workflow;
  study::Options study;

  [[nodiscard]] study::Options complete(const std::vector<std::string>& command) const {
    study::Options options = study;
    options.file = workflow.file;
    options.load = workflow.load_options();
    options.command = command;
    return options;
  }
};

std::string count(std::size_t number, const std::string& thing) {
  return fmt::format("{} {}{}", number, thing, number == 1 ? "" : "s");
}

void show_blemishes(const char* title, const std::vector<study::Blemish>& blemishes) {
  constexpr std::size_t most = 10;
  for (std::size_t i = 0; i < std::min(most, blemishes.size()); ++i) {
    tell("{}  {}: {}\n", title, blemishes[i].point, blemishes[i].error);
  }
  if (blemishes.size() > most) tell("{}  and {} more\n", title, blemishes.size() - most);
}

ExitCode show(const study::Ended& ended, double seconds) {
  if (ended.unchanged) {
    fmt::print("nothing to do: {} unchanged ({:.2f} s)\n", count(ended.points, "point"), seconds);
  } else {
    const std::size_t ran = ended.points - ended.reused - ended.twins;
    fmt::print("{}: {} run, {} there already", count(ended.points, "point"), ran, ended.reused);
    if (ended.twins > 0) fmt::print(", {} the same as another", ended.twins);
    fmt::print("; {}\n", duration_text(seconds));
  }
  show_blemishes("outside", ended.outside);
  show_blemishes("FAILED ", ended.failed);
  if (!ended.error.empty()) tell("sandglass: the study's own stages: {}\n", ended.error);
  fmt::print("result  {}/summary/result.json\n", ended.directory);
  if (!ended.report.empty()) fmt::print("report  {}\n", ended.report);
  return ended.code;
}

ExitCode execute(const study::Options& options) {
  const SystemClock clock;
  const double start = clock.now();
  study::Listener listener;
  listener.started = [&](const std::string& point) {
    tell("{:>8}  begin {}\n", duration_text(clock.now() - start), point);
  };
  listener.ended = [&](const std::string& point) {
    tell("{:>8}  end   {}\n", duration_text(clock.now() - start), point);
  };
  run::Silence silence;
  const study::Ended ended = study::execute(options, run::Home::find(), listener, silence);
  return show(ended, clock.now() - start);
}

ExitCode explain(const study::Options& options) {
  const std::vector<study::Reason> reasons = study::why(options, run::Home::find());
  std::size_t good = 0;
  for (const study::Reason& reason : reasons) {
    if (reason.lines.empty()) {
      ++good;
      continue;
    }
    fmt::print("{}\n", reason.point);
    for (const std::string& line : reason.lines) fmt::print("    {}\n", line);
  }
  if (good == reasons.size()) {
    fmt::print("all {} are there and good: nothing would be run\n", count(good, "point"));
  } else {
    fmt::print("{} of {} would be run\n", reasons.size() - good, count(reasons.size(), "point"));
  }
  return ExitCode::done;
}

void add_common(CLI::App& verb, Choices& choices) {
  choices.workflow.add_to(verb);
  verb.add_option("--out", choices.study.out, "the study's folder (default: runs/NAME)")
      ->type_name("DIR");
}

}  // namespace

void add_study(CLI::App& app, Session& session) {
  auto choices = std::make_shared<Choices>();
  CLI::App* verb = add_verb(
      app, "study", "run what is missing of a workflow swept over parameters; report",
      "  sandglass study workflows/icy_stokes_stability.yaml --jobs 2\n"
      "  sandglass study workflows/icy_stokes_error_vs_time.yaml --again\n"
      "  SBATCH_PARTITION=long sandglass study workflows/icy_stokes_stability.yaml --slurm");
  add_common(*verb, *choices);
  verb->add_option("--jobs", choices->study.jobs,
                   "runs at a time (default: the number of cores; with --slurm: as it likes)")
      ->check(CLI::Range(1, 100000));
  verb->add_flag("--slurm", choices->study.slurm,
                 "run the points as one job array of Slurm, and wait for it");
  verb->add_flag("--again", choices->study.again, "run all points, also those that are there");
  verb->callback([&session, choices] {
    session.action = [&session, choices] { return execute(choices->complete(session.command)); };
  });
}

void add_why(CLI::App& app, Session& session) {
  auto choices = std::make_shared<Choices>();
  CLI::App* verb = add_verb(app, "why", "say of every point of a study why it would be run again",
                            "  sandglass why workflows/icy_stokes_stability.yaml");
  add_common(*verb, *choices);
  verb->callback([&session, choices] {
    session.action = [&session, choices] { return explain(choices->complete(session.command)); };
  });
}

}  // namespace sandglass::cli
