#include <fmt/format.h>

#include <memory>

#include "cli/cli.hpp"
#include "process/interrupt.hpp"
#include "record/crate.hpp"
#include "record/crate_files.hpp"
#include "record/run_directory.hpp"
#include "report/page.hpp"
#include "run/home.hpp"

namespace sandglass::cli {

void add_report(CLI::App& app, Session& session) {
  auto path = std::make_shared<std::string>();
  CLI::App* verb = add_verb(app, "report", "make the figures and report.html of a run again",
                            "  sandglass report runs/icy_stokes_sphere-0001");
  verb->add_option("run", *path, "the run directory")->required()->type_name("RUN");
  verb->callback([&session, path] {
    session.action = [path] {
      Interrupt::install();
      const record::RunDirectory directory = record::RunDirectory::open(*path);
      report::ReportTools tools;
      tools.templates_root = run::Home::find().templates();
      report::write_report(directory.path(), tools);
      std::vector<std::string> made = {"report.html"};
      for (const std::string& file : record::files_of_crate(directory.path())) {
        if (file.starts_with("figures/")) made.push_back(file);
      }
      record::refresh_crate(directory.path(), made);
      fmt::print("report  {}\n", directory.file("report.html"));
      return ExitCode::done;
    };
  });
}

}  // namespace sandglass::cli
