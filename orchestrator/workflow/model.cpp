#include "workflow/model.hpp"

#include <fmt/format.h>

#include <set>

#include "base/unit.hpp"
#include "workflow/values.hpp"

namespace sandglass::workflow {
namespace {

/// Fewest digits that convert back to the same SI value: 0.0001 m is "0.1" mm, although the
/// conversion itself may end in ...9.
std::string in_unit(double si, const std::string& unit) {
  const double number = Unit::from_si(si, unit);
  for (const int digits : {15, 16}) {
    std::string text = fmt::format("{:.{}g}", number, digits);
    if (Quantity read; Quantity::parse(text, read) && Unit::to_si(read.number, unit) == si) {
      return text;
    }
  }
  return shortest(number);
}

}  // namespace

const Parameter* Workflow::parameter(const std::string& wanted) const {
  for (const Parameter& candidate : parameters) {
    if (candidate.name == wanted) return &candidate;
  }
  return nullptr;
}

std::vector<std::string> data_files(const Workflow& workflow) {
  std::set<std::string> paths;
  const auto add = [&](const GivenMap& given) {
    for (const auto& [name, one] : given) {
      if (one.file && one.file->stage.empty()) paths.insert(one.file->file);
    }
  };
  for (const Stage& stage : workflow.stages) add(stage.given);
  for (const Participant& one : workflow.participants) add(one.given);
  for (const Comparison& one : workflow.comparisons) {
    if (!one.reference_file.empty()) paths.insert(one.reference_file);
  }
  return {paths.begin(), paths.end()};
}

std::string shown(const Parameter& parameter) {
  const auto* number = parameter.value.as<double>();
  if (!number) return plain_text(parameter.value);
  if (parameter.unit.empty() || parameter.unit == "1") return shortest(*number);
  return fmt::format("{} {}", in_unit(*number, parameter.unit), parameter.unit);
}

}  // namespace sandglass::workflow
