#pragma once

#include <set>
#include <string>
#include <vector>

#include "workflow/context.hpp"

namespace sandglass::workflow {

/// The scripts of one stage or participant, and the values they are given between them.
struct Scripts {
  std::string template_path;
  Place template_place;
  std::string window_template_path;
  Place window_template_place;
  std::string ending;  ///< that the program wants (".py"); empty: any
  GivenMap given;
};

/// The given values of a stage or participant in this scope. Files are checked: the stage is there,
/// makes the file, and (when `running`) runs in this scope; a data file exists.
GivenMap read_given(const Context& context, const Scope& scope, const Node& node, bool running);

/// Checks that the templates exist, parse, suit the program, and use exactly what they are given.
void check_scripts(const Context& context, const Scripts& scripts);

/// Stages whose files these are, without repetition.
std::vector<std::string> makers(const GivenMap& given);

}  // namespace sandglass::workflow
