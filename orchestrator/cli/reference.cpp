#include <fmt/format.h>

#include <memory>

#include "base/file.hpp"
#include "cli/cli.hpp"
#include "workflow/documents.hpp"

namespace sandglass::cli {

void add_reference(CLI::App& app, Session& session) {
  auto what = std::make_shared<std::string>("page");
  CLI::App* verb = add_verb(app, "reference", "print the workflow format: JSON schema or page",
                            "  sandglass reference schema > workflows/schema.json\n"
                            "  sandglass reference page");
  verb->add_option("what", *what, "schema (for editors) or page (Markdown)")
      ->check(CLI::IsMember({"schema", "page"}));
  verb->callback([&session, what] {
    session.action = [what] {
      fmt::print("{}", *what == "schema" ? workflow::json_schema() : workflow::reference_page());
      return ExitCode::done;
    };
  });
}

}  // namespace sandglass::cli
