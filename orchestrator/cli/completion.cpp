#include <fmt/format.h>

#include <memory>
#include <string>

#include "cli/cli.hpp"

namespace sandglass::cli {
namespace {

/// Words for completion come from the same definitions as the parser's.
std::string words_of(const CLI::App& verb) {
  std::string words;
  for (const CLI::Option* option : verb.get_options()) {
    for (const std::string& name : option->get_lnames()) words += " --" + name;
  }
  return words;
}

std::string bash_script(const CLI::App& app) {
  std::string verbs;
  std::string cases;
  for (const CLI::App* verb : app.get_subcommands({})) {
    verbs += (verbs.empty() ? "" : " ") + verb->get_name();
    cases += fmt::format("    {}) words=\"{}\" ;;\n", verb->get_name(), words_of(*verb).substr(1));
  }
  return fmt::format(
      "_sandglass() {{\n"
      "  local word=\"${{COMP_WORDS[COMP_CWORD]}}\" words=\"\"\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    COMPREPLY=($(compgen -W \"{}\" -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case \"${{COMP_WORDS[1]}}\" in\n{}  esac\n"
      "  case \"$word\" in\n"
      "    -*) COMPREPLY=($(compgen -W \"$words\" -- \"$word\")) ;;\n"
      "    *) COMPREPLY=($(compgen -f -- \"$word\")) ;;\n"
      "  esac\n"
      "}}\n"
      "complete -o filenames -F _sandglass sandglass ./sandglass\n",
      verbs, cases);
}

}  // namespace

void add_completion(CLI::App& app, Session& session) {
  CLI::App* verb = add_verb(app, "completion", "print the completion script for bash",
                            "  source <(./sandglass completion)");
  verb->callback([&app, &session] {
    session.action = [&app] {
      fmt::print("{}", bash_script(app));
      return ExitCode::done;
    };
  });
}

}  // namespace sandglass::cli
