#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "workflow/model.hpp"

namespace sandglass::workflow {

/// The resolved workflow as JSON, format 1, for provenance and reports. All numbers are SI:
///   {"format": 1, "path", "name", "title", "description",
///    "parameters": {NAME: {"type", "value", "unit", "shown", "meaning", "source", "choices",
///                          "overridden"}},
///    "stages": [{"name", "run", "template", "command", "given", "makes", "after", "reuse",
///                "analysis", "deadline_s"}],
///    "stages_left_out": [NAME],
///    "participants": [{"name", "solver", "template", "window_template", "command", "given",
///                      "process", "threads", "ranks", "deadline_s"}],
///    "coupling": {"scheme", "window_s", "end_s", "windows", "order", "exchange", "acceleration",
///                 "reused_windows", "filter", "relaxation", "tolerance", "iterations",
///                 "stability": {"watch", "growth", "monotone_growth", "energy", "energy_growth"},
///                 "rest": {"field", "at_most", "windows"}, "checkpoint_every", "checkpoints_kept",
///                 "fields": [{"name", "unit", "shape", "variable", "from", "to", "transform",
///                             "mapping", "samples", "received_shape", "initial", "recorded",
///                             "relaxed", "watched"}],
///                 "fields_left_out"} or null,
///    "comparisons": [{"name", "quantity" | "curve", "reference", "metric", "tolerance", "unit",
///                     "because", "holds_for": [{"parameter", "value", "met"}]}],
///    "left_out": [{"name", "of", "also", "what", "why", "active", "by"}]}
/// `given` maps names to values, or to {"stage", "file"}. A number that JSON cannot hold is null.
nlohmann::ordered_json to_json(const Workflow& workflow);

/// "number", "count", "switch", "choice", "text".
std::string type_name(Parameter::Type type);
/// As in a workflow: "gmsh", "serial-explicit", "relative difference".
std::string name_of(Program program);
std::string name_of(Solver solver);
std::string name_of(Acceleration acceleration);
std::string name_of(Scheme scheme);
std::string name_of(Transform transform);
std::string name_of(Metric metric);

}  // namespace sandglass::workflow
