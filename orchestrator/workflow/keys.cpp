#include "workflow/keys.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

namespace sandglass::workflow {
namespace {

Object workflow_keys() {
  return {
      "workflow",
      "The file itself. Everything in it is data; scripts are made from it by templates.",
      {{.name = "sandglass",
        .kind = Kind::version,
        .required = true,
        .doc = "The version of this format.",
        .example = "1"},
       {.name = "name",
        .kind = Kind::name,
        .required = true,
        .doc = "A word for directories and reports.",
        .example = "icy_stokes_sphere"},
       {.name = "title", .doc = "The report's headline.", .example = "A sphere settles in water"},
       {.name = "description",
        .doc = "What the scene is and what is known about it, in some sentences.",
        .example = "Pirnia et al. (2019), section 3 ..."},
       {.name = "parameters",
        .kind = Kind::object,
        .many = Many::map,
        .object = "parameter",
        .doc = "What can be set, by name; '--set name=value' changes one for a run.",
        .example = "{diameter: {value: 0.1 mm}}"},
       {.name = "stages",
        .kind = Kind::object,
        .many = Many::map,
        .object = "stage",
        .fallback = "none, in a study of another workflow; else there must be some",
        .doc = "What is run, by name, in an order that 'after' and files decide.",
        .example = "{couple: {run: coupling}}"},
       {.name = "participants",
        .kind = Kind::object,
        .many = Many::map,
        .object = "participant",
        .doc = "The solvers that are coupled, by name.",
        .example = "{grains: {solver: yade, template: yade/settling_sphere.py}}"},
       {.name = "coupling",
        .kind = Kind::object,
        .object = "coupling",
        .doc = "How the participants exchange fields.",
        .example = "{scheme: serial-explicit, window: 1 ms, ...}"},
       {.name = "record",
        .kind = Kind::object,
        .object = "record",
        .doc = "What is kept of every window.",
        .example = "{fields: all}"},
       {.name = "compare",
        .kind = Kind::object,
        .many = Many::list,
        .object = "comparison",
        .doc = "What the results are held against; each comparison has a tolerance.",
        .example = "[{name: printed velocity, ...}]"},
       {.name = "left_out",
        .kind = Kind::object,
        .many = Many::map,
        .object = "left_out",
        .doc = "What this scene does not need, by name; '--no-prune' puts it back.",
        .example = "{repeated_solve: {of: fluid, ...}}"},
       {.name = "study",
        .kind = Kind::object,
        .object = "study",
        .doc = "A sweep over parameters, for 'sandglass study': of this workflow, or of another "
               "one (`of`), whose results the stages and comparisons of this file then look at.",
        .example = "{of: icy_stokes_sphere.yaml, points: [...]}"}}};
}

Object study_keys() {
  return {
      "study",
      "A workflow run for many values of its parameters.",
      {{.name = "of",
        .fallback = "this workflow",
        .doc = "The workflow that is run at every point, relative to this file.",
        .example = "icy_stokes_sphere.yaml"},
       {.name = "set",
        .kind = Kind::settings,
        .doc = "Parameters that are set in all points.",
        .example = "{end_time: 22 ms}"},
       {.name = "points",
        .kind = Kind::object,
        .many = Many::list,
        .required = true,
        .object = "points",
        .doc = "Sets of points; together they are the study.",
        .example = "[{grid: {window: [1 ms, 2 ms]}}]"},
       {.name = "judge",
        .kind = Kind::toggle,
        .fallback = "true",
        .doc = "Whether a point whose comparisons are out of tolerance makes the study end with 6. "
               "Where coarse settings are swept on purpose, their errors are the result.",
        .example = "false"},
       {.name = "work_precision",
        .kind = Kind::object,
        .many = Many::list,
        .object = "work_precision",
        .doc = "Diagrams of error against run time, with the efficient frontier and the cheapest "
               "settings; the error of each names it.",
        .example = "[{error: drag_relative_error}]"}}};
}

Object points_keys() {
  return {
      "points",
      "Some points of a study: every item of `list` with every combination of `grid` and `seeds`.",
      {{.name = "name",
        .doc = "What these points are for, in a few words.",
        .example = "mesh of the box"},
       {.name = "set",
        .kind = Kind::settings,
        .doc = "Parameters that are set in all of these points.",
        .example = "{fluid: box}"},
       {.name = "list",
        .kind = Kind::settings,
        .many = Many::list,
        .doc = "Single points, or values of several parameters that go together.",
        .example = "[{element_order: cubic, radial_elements: 24}]"},
       {.name = "grid",
        .kind = Kind::sweep,
        .doc = "The values of each parameter; all combinations are run.",
        .example = "{window: [1 ms, 2 ms], scheme: [serial-explicit, parallel-explicit]}"},
       {.name = "seeds",
        .kind = Kind::sweep,
        .doc = "As `grid`, but points that differ in nothing else are samples of one: their spread "
               "becomes an error bar.",
        .example = "{seed: [1, 2, 3, 4, 5]}"},
       {.name = "repeat",
        .kind = Kind::count,
        .minimum = 1,
        .fallback = "1",
        .doc = "How often each point is run; the spread of run times becomes an error bar.",
        .example = "3"},
       {.name = "expect",
        .kind = Kind::choice,
        .names = {"done", "unstable"},
        .fallback = "done",
        .doc = "How these points must end: well, or stopped by the stability watch (5).",
        .example = "unstable"}}};
}

Object work_precision_keys() {
  return {
      "work_precision",
      "Which result is the error, what its price is, and what counts as one method.",
      {{.name = "error",
        .kind = Kind::name,
        .required = true,
        .doc = "The quantity whose magnitude is the error; with `reference`, its difference.",
        .example = "drag_relative_error"},
       {.name = "reference",
        .kind = Kind::object,
        .object = "reference",
        .doc = "What the quantity should be, a `value` or another `quantity`: the error is then "
               "the relative difference (absolute where the reference is 0).",
        .example = "{quantity: stokes_terminal_velocity}"},
       {.name = "points",
        .many = Many::list,
        .fallback = "all of them",
        .doc = "The names of the sets of points that are looked at.",
        .example = "[mesh of the box]"},
       {.name = "method",
        .kind = Kind::name,
        .many = Many::list,
        .fallback = "every set of points is one method",
        .doc = "The parameters whose values divide a set of points into methods; each method is a "
               "line in the figure.",
        .example = "[fluid, element_order]"},
       {.name = "seconds",
        .kind = Kind::name,
        .many = Many::list,
        .fallback = "the whole run, from its start to its report",
        .doc = "What counts as the price: stages; participants (their work in the windows, by "
               "their own account); start, orchestrator, report.",
        .example = "[mesh, convert, fluid]"}}};
}

Key choose_key() {
  return {.name = "choose",
          .kind = Kind::name,
          .doc =
              "The choice parameter that selects one of `cases`; of a parameter, one declared "
              "before it.",
          .example = "fluid"};
}

Key cases_key(std::string of) {
  return {.name = "cases",
          .kind = Kind::object,
          .many = Many::map,
          .object = std::move(of),
          .partial = true,
          .doc =
              "For every choice (or `otherwise`) the keys that replace or join those beside "
              "`choose`; `given` is joined name by name. A case may choose again. All cases are "
              "checked, one "
              "is used.",
          .example = "{box: {template: freefem/stokes_box.edp}, otherwise: {...}}"};
}

Object parameter_keys() {
  return {
      "parameter",
      "A value that can be set. In every number here a bare number is SI, as in '--set'; a number "
      "with a unit is converted.",
      {{.name = "value",
        .kind = Kind::literal,
        .required = true,
        .doc = "The value when nothing else is set.",
        .example = "0.1 mm"},
       {.name = "unit",
        .kind = Kind::unit,
        .fallback = "the unit that `value` is written in",
        .doc = "The unit it is reported in; every value must be convertible to it.",
        .example = "mm"},
       {.name = "type",
        .kind = Kind::choice,
        .names = {"number", "count", "switch", "choice", "text"},
        .fallback = "choice with `choices`; number for any number, whole ones too; switch for true "
                    "and false; else text",
        .doc = "What kind of value it is; only a count has to be asked for.",
        .example = "count"},
       {.name = "choices",
        .many = Many::list,
        .doc = "The names to choose from.",
        .example = "[resident, fresh]"},
       {.name = "minimum",
        .kind = Kind::number,
        .reference = true,
        .unit = "*",
        .doc = "The smallest value; `$name` is the value of another parameter.",
        .example = "0"},
       {.name = "maximum",
        .kind = Kind::number,
        .reference = true,
        .unit = "*",
        .doc = "The largest value.",
        .example = "1"},
       {.name = "above",
        .kind = Kind::number,
        .reference = true,
        .unit = "*",
        .doc = "Values must be larger than this.",
        .example = "0 mm"},
       {.name = "below",
        .kind = Kind::number,
        .reference = true,
        .unit = "*",
        .doc = "Values must be smaller than this.",
        .example = "90 deg"},
       {.name = "meaning",
        .doc = "What it is, in one sentence.",
        .example = "diameter of the sphere"},
       {.name = "source",
        .doc = "Where the value comes from.",
        .example = "Pirnia et al. (2019), section 3.2"},
       choose_key(),
       cases_key("parameter")}};
}

Key template_key(std::string doc) {
  return {.name = "template",
          .kind = Kind::template_,
          .doc = std::move(doc),
          .example = "yade/settling_sphere.py"};
}

Key command_key() {
  return {.name = "command",
          .many = Many::list,
          .reference = true,
          .doc = "The argument vector of any other program, the program first; there is no shell.",
          .example = "[python3, solver.py]"};
}

Key given_key() {
  return {.name = "given",
          .kind = Kind::given,
          .doc =
              "What the template is given: a list of parameters, or names with values: "
              "`$parameter`, a literal, {file: STAGE/FILE} made by another stage, or "
              "{data: FILE} below data/.",
          .example = "[diameter, {mesh: {file: convert/box.mesh}}]"};
}

Key deadline_key(std::string fallback, std::string doc) {
  return {.name = "deadline",
          .kind = Kind::number,
          .reference = true,
          .unit = "s",
          .above = 0,
          .fallback = std::move(fallback),
          .doc = std::move(doc),
          .example = "10 min"};
}

Key when_key() {
  return {
      .name = "when",
      .kind = Kind::condition,
      .doc = "Applies only when every parameter named has the value, or one of the values, given.",
      .example = "{fluid: [box, navier_stokes]}"};
}

Object stage_keys() {
  return {
      "stage",
      "A program that is run once, or the coupled run itself.",
      {{.name = "run",
        .kind = Kind::choice,
        .required = true,
        .names = {"gmsh", "python", "freefem", "yade", "lammps", "command", "coupling"},
        .doc = "What runs.",
        .example = "gmsh"},
       template_key("The script, except for command and coupling."),
       command_key(),
       given_key(),
       {.name = "makes",
        .many = Many::list,
        .doc = "The files it must have made, relative to its work directory.",
        .example = "[box.msh]"},
       {.name = "after",
        .kind = Kind::name,
        .many = Many::list,
        .doc = "Stages that come first; those whose files are used, and the coupling before an "
               "analysis, need not be named.",
        .example = "[mesh]"},
       {.name = "reuse",
        .kind = Kind::toggle,
        .reference = true,
        .fallback = "false",
        .doc = "What it makes is kept, by the digest of its script, its input files and its "
               "program, and taken over by every later run that needs the same. --no-prune NAME "
               "makes it anew. Not of a command stage, whose inputs are not known.",
        .example = "true"},
       {.name = "analysis",
        .kind = Kind::toggle,
        .fallback = "false",
        .doc = "A python stage that reads the record and writes quantities and curves.",
        .example = "true"},
       deadline_key("10 min (the coupling has none)", "The longest time it may take."),
       when_key(),
       choose_key(),
       cases_key("stage")}};
}

Object participant_keys() {
  return {
      "participant",
      "A solver that takes part in the coupled run.",
      {{.name = "solver",
        .kind = Kind::choice,
        .required = true,
        .names = {"yade", "freefem", "lammps", "command"},
        .doc = "The program; `command` is any that speaks the participant protocol.",
        .example = "yade"},
       template_key("The script it starts with."),
       {.name = "window_template",
        .kind = Kind::template_,
        .doc = "The script that YADE or LAMMPS executes for every window; it is also given "
               "`window` with "
               "`index`, `begin` and `end`, which there hides a given `window`.",
        .example = "yade/settling_sphere_window.py"},
       command_key(),
       given_key(),
       {.name = "process",
        .kind = Kind::choice,
        .reference = true,
        .names = {"resident", "fresh"},
        .fallback = "resident",
        .doc = "Whether its process lives for the whole run or is started anew for every window.",
        .example = "$process"},
       {.name = "threads",
        .kind = Kind::count,
        .reference = true,
        .minimum = 1,
        .fallback = "1",
        .doc = "How many threads it may use.",
        .example = "2"},
       {.name = "ranks",
        .kind = Kind::count,
        .reference = true,
        .minimum = 1,
        .fallback = "1",
        .doc = "How many processes it is under MPI; LAMMPS only.",
        .example = "2"},
       deadline_key("1 min", "The longest time one answer may take."),
       when_key(),
       choose_key(),
       cases_key("participant")}};
}

Object coupling_keys() {
  return {
      "coupling",
      "When the participants run and what crosses between them.",
      {{.name = "scheme",
        .kind = Kind::choice,
        .reference = true,
        .names = {"serial-explicit", "parallel-explicit", "serial-implicit"},
        .fallback = "serial-explicit",
        .doc = "One after the other with the newest values; all at once with the last window's; or "
               "one after the other again and again until the relaxed fields no longer change.",
        .example = "$scheme"},
       {.name = "acceleration",
        .kind = Kind::choice,
        .reference = true,
        .names = {"none", "constant", "aitken", "iqn-ils"},
        .fallback = "none",
        .doc =
            "How relaxed fields follow: at once, by the factor `relaxation` (in explicit schemes "
            "carried from window to window), by Aitken's factor, or all together by the "
            "quasi-Newton "
            "method IQN-ILS (the last two in serial-implicit only).",
        .example = "aitken"},
       {.name = "relaxation",
        .kind = Kind::number,
        .reference = true,
        .unit = "1",
        .above = 0,
        .fallback = "0.5",
        .doc = "The factor of constant relaxation, and the first of the other accelerations.",
        .example = "0.5"},
       {.name = "reused_windows",
        .kind = Kind::count,
        .reference = true,
        .minimum = 0,
        .fallback = "10",
        .doc = "How many earlier windows IQN-ILS learns from, besides the present one.",
        .example = "4"},
       {.name = "filter",
        .kind = Kind::number,
        .reference = true,
        .unit = "1",
        .above = 0,
        .fallback = "1e-2",
        .doc =
            "IQN-ILS forgets an iteration that adds less than this part of itself to newer ones.",
        .example = "1e-3"},
       {.name = "relax",
        .kind = Kind::name,
        .many = Many::list,
        .fallback = "the fields that go to a participant earlier in the order",
        .doc = "The fields that are relaxed, and that a serial-implicit window iterates on.",
        .example = "[velocity]"},
       {.name = "tolerance",
        .kind = Kind::number,
        .reference = true,
        .unit = "1",
        .above = 0,
        .fallback = "1e-10",
        .doc =
            "When a serial-implicit window has converged: the change of every relaxed field over "
            "its largest size so far, as 2-norms.",
        .example = "1e-8"},
       {.name = "iterations",
        .kind = Kind::count,
        .reference = true,
        .minimum = 1,
        .fallback = "100",
        .doc =
            "How many iterations a serial-implicit window may take; more end the run as unstable.",
        .example = "20"},
       {.name = "stability",
        .kind = Kind::object,
        .object = "stability",
        .doc = "When the stability watch ends the run.",
        .example = "{growth: 1.02}"},
       {.name = "rest",
        .kind = Kind::object,
        .object = "rest",
        .doc = "When the run ends before `end`, well, because nothing happens any more.",
        .example = "{field: eroded, for: 3 s}"},
       {.name = "window",
        .kind = Kind::number,
        .required = true,
        .reference = true,
        .unit = "s",
        .above = 0,
        .doc = "The time between exchanges; a participant may take smaller steps inside.",
        .example = "$window"},
       {.name = "end",
        .kind = Kind::number,
        .required = true,
        .reference = true,
        .unit = "s",
        .above = 0,
        .doc = "The physical time to reach; the run ends with the first whole window that reaches "
               "it, so at or up to one window after it.",
        .example = "30 ms"},
       {.name = "order",
        .kind = Kind::name,
        .many = Many::list,
        .required = true,
        .doc = "The participants, in the order in which they run within a window.",
        .example = "[grains, fluid]"},
       {.name = "exchange",
        .kind = Kind::choice,
        .reference = true,
        .names = {"mapped", "file"},
        .fallback = "mapped",
        .doc = "Files mapped into memory by both sides, or a fresh file for every exchange.",
        .example = "mapped"},
       {.name = "fields",
        .kind = Kind::object,
        .many = Many::map,
        .required = true,
        .object = "field",
        .doc = "The arrays that cross, by name.",
        .example = "{velocity: {unit: m/s, shape: [3], from: grains, to: fluid}}"}}};
}

Object stability_keys() {
  return {"stability",
          "When a field is said to diverge, which ends the run with exit status 5.",
          {{.name = "watch",
            .kind = Kind::toggle,
            .reference = true,
            .fallback = "true",
            .doc = "Whether fields are watched; values that are not "
                   "finite always end the run.",
            .example = "false"},
           {.name = "growth",
            .kind = Kind::number,
            .reference = true,
            .unit = "1",
            .above = 1,
            .fallback = "1.02",
            .doc = "Growth per window, of a field's change from window to window that turns its "
                   "sign again and again, above which it diverges when it lasts.",
            .example = "1.05"},
           {.name = "monotone_growth",
            .kind = Kind::number,
            .reference = true,
            .unit = "1",
            .above = 1,
            .fallback = "0.02 more than `growth`",
            .doc = "The same without a change of sign, as some physics grows too.",
            .example = "1.2"},
           {.name = "energy",
            .kind = Kind::name,
            .many = Many::list,
            .doc = "Fields whose values add up to the energy of a system that nothing outside "
                   "feeds: what it gains is made by the coupling.",
            .example = "[sphere_energy, beam_energy]"},
           {.name = "energy_growth",
            .kind = Kind::number,
            .reference = true,
            .unit = "1",
            .above = 1,
            .fallback = "2",
            .doc = "How many times its first value above 0 this energy may become.",
            .example = "1.1"}}};
}

Object rest_keys() {
  return {"rest",
          "When nothing is left to compute. The record ends there, and the report says so.",
          {{.name = "field",
            .kind = Kind::name,
            .required = true,
            .doc = "The field that tells.",
            .example = "eroded"},
           {.name = "at_most",
            .kind = Kind::number,
            .reference = true,
            .unit = "1",
            .minimum = 0,
            .fallback = "0",
            .doc = "The largest size, in SI, of any of its values.",
            .example = "0"},
           {.name = "for",
            .kind = Kind::number,
            .required = true,
            .reference = true,
            .unit = "s",
            .above = 0,
            .doc = "For how long, in whole windows.",
            .example = "3 s"}}};
}

Object field_keys() {
  return {"field",
          "An array that one participant sends in every window.",
          {{.name = "unit",
            .kind = Kind::unit,
            .required = true,
            .doc = "Its unit in the record and in reports; values cross in SI.",
            .example = "m/s"},
           {.name = "shape",
            .kind = Kind::shape,
            .required = true,
            .doc = "The lengths of its axes, each a number or `$count`; the first may be "
                   "{at_most: N} where it changes from window to window.",
            .example = "[{at_most: 25000}, 3]"},
           {.name = "from",
            .kind = Kind::name,
            .required = true,
            .doc = "The participant that sends it.",
            .example = "grains"},
           {.name = "to",
            .kind = Kind::name,
            .fallback = "nobody: it is recorded only",
            .doc = "The participant that receives it.",
            .example = "fluid"},
           {.name = "transform",
            .kind = Kind::choice,
            .reference = true,
            .names = {"identity", "mean", "median", "min", "max", "sum", "linear"},
            .fallback = "identity",
            .doc = "What happens in transit: a statistic over the first axis, which it removes, or "
                   "linear resampling in time to `samples` rows.",
            .example = "mean"},
           {.name = "mapping",
            .kind = Kind::object,
            .object = "mapping",
            .fallback = "values arrive at the points they were sent from",
            .doc = "How the field crosses between points that do not coincide.",
            .example = "{method: linear, kind: conservative, from_points: tips, to_points: nodes}"},
           {.name = "samples",
            .kind = Kind::count,
            .reference = true,
            .minimum = 1,
            .doc = "The rows that arrive, for the transform linear.",
            .example = "10"},
           {.name = "initial",
            .kind = Kind::number,
            .reference = true,
            .unit = "*",
            .fallback = "0",
            .doc = "Every value before the sender has spoken; of a mapped field nothing arrives "
                   "then.",
            .example = "0 m/s"},
           {.name = "watched",
            .kind = Kind::toggle,
            .reference = true,
            .fallback = "true",
            .doc = "Whether its growth from window to window may end the run. What is counted may "
                   "grow without any fault.",
            .example = "false"},
           when_key()}};
}

Object mapping_keys() {
  return {
      "mapping",
      "How a field crosses between points that do not coincide. Both sides' points are fields "
      "themselves, [points, 2] or [points, 3], and may change from window to window; until both "
      "have been sent, no row arrives.",
      {{.name = "method",
        .kind = Kind::choice,
        .reference = true,
        .names = {"nearest", "linear"},
        .fallback = "linear",
        .doc = "The value of the nearest point, or barycentric interpolation in the nearest cell.",
        .example = "nearest"},
       {.name = "kind",
        .kind = Kind::choice,
        .required = true,
        .names = {"consistent", "conservative"},
        .doc = "Consistent keeps constants (and linear fields), for displacement and velocity; "
               "conservative is its transpose and keeps sums (and moments), for forces.",
        .example = "conservative"},
       {.name = "from_points",
        .kind = Kind::name,
        .required = true,
        .doc = "The field with the points that the values belong to.",
        .example = "tips"},
       {.name = "to_points",
        .kind = Kind::name,
        .required = true,
        .doc = "The field with the points that the receiver wants values at.",
        .example = "nodes"},
       {.name = "cells",
        .kind = Kind::name,
        .fallback = "points are joined in their order, to a line",
        .doc = "The field with the segments [cells, 2] or triangles [cells, 3], as numbers of "
               "points from 0: of the sender for a consistent mapping, of the receiver for a "
               "conservative one.",
        .example = "triangles"},
       {.name = "limit",
        .kind = Kind::number,
        .required = true,
        .reference = true,
        .unit = "m",
        .above = 0,
        .doc = "The longest distance between a point and the other interface; a point further "
               "away ends the run.",
        .example = "1 mm"}}};
}

Object record_keys() {
  return {"record",
          "What is kept of every window.",
          {{.name = "fields",
            .kind = Kind::selection,
            .fallback = "all",
            .doc = "The fields that are recorded. One that nobody receives or records is not sent.",
            .example = "[velocity, drag]"},
           {.name = "checkpoint_every",
            .kind = Kind::count,
            .reference = true,
            .minimum = 0,
            .fallback = "0",
            .doc = "After how many windows a checkpoint is written, from which `resume` and "
                   "`replay` go on; 0: never, they begin at the start.",
            .example = "10"},
           {.name = "checkpoints_kept",
            .kind = Kind::count,
            .reference = true,
            .minimum = 0,
            .fallback = "0",
            .doc = "How many checkpoints are kept, the newest ones; 0: all.",
            .example = "2"}}};
}

Object comparison_keys() {
  return {
      "comparison",
      "A result of the analysis against a reference, a bound, or another result.",
      {{.name = "name",
        .required = true,
        .doc = "What is compared, in a few words.",
        .example = "printed terminal velocity"},
       {.name = "quantity",
        .kind = Kind::name,
        .doc = "The quantity of the analysis that is compared; either this or `curve`.",
        .example = "terminal_velocity"},
       {.name = "curve",
        .kind = Kind::name,
        .doc = "The curve of the analysis that is compared.",
        .example = "velocity"},
       {.name = "reference",
        .kind = Kind::object,
        .object = "reference",
        .doc = "What it is compared with; not for the metric `value`.",
        .example = "{value: 0.008989 m/s, source: section 3.4}"},
       {.name = "metric",
        .kind = Kind::choice,
        .required = true,
        .names = {"value", "absolute difference", "relative difference", "maximum difference",
                  "root mean square difference"},
        .doc = "The number that is held against the tolerance: the magnitude of the quantity "
               "itself, of its difference (relative: over that of the reference), or, for curves, "
               "of their largest or root mean square difference.",
        .example = "relative difference"},
       {.name = "tolerance",
        .kind = Kind::number,
        .required = true,
        .reference = true,
        .unit = "*",
        .minimum = 0,
        .doc =
            "The largest value of the metric that passes; for a relative difference a bare number "
            "or one in %.",
        .example = "0.1 %"},
       {.name = "unit",
        .kind = Kind::unit,
        .fallback = "that of the reference, else of the tolerance",
        .doc = "The unit it is reported in.",
        .example = "mm/s"},
       {.name = "because",
        .required = true,
        .doc = "Where the tolerance comes from.",
        .example = "the paper prints four digits"},
       {.name = "holds_for",
        .kind = Kind::condition,
        .doc = "The parameters that a published reference was made with: a run that departs from "
               "them skips the comparison and says so.",
        .example = "{density: 2650 kg/m3}"},
       when_key()}};
}

Object reference_keys() {
  return {"reference",
          "What a result is compared with: exactly one of value, quantity, curve, data.",
          {{.name = "value",
            .kind = Kind::number,
            .unit = "*",
            .doc = "A published number.",
            .example = "0.008989 m/s"},
           {.name = "quantity",
            .kind = Kind::name,
            .doc = "Another quantity of the analysis.",
            .example = "stokes_velocity"},
           {.name = "curve",
            .kind = Kind::name,
            .doc = "Another curve of the analysis.",
            .example = "stokes_velocity"},
           {.name = "data",
            .doc = "A CSV file below data/ with two columns.",
            .example = "beam_impact/single_timoshenko_force.csv"},
           {.name = "source",
            .doc = "Where it was published; required with `value` and `data`.",
            .example = "Pirnia et al. (2019), section 3.4"}}};
}

Object left_out_keys() {
  return {
      "left_out",
      "Something the scene does not need. The participant's templates are given a switch of this "
      "name: true leaves it out.",
      {{.name = "of",
        .kind = Kind::name,
        .required = true,
        .doc = "The participant that is told.",
        .example = "fluid"},
       {.name = "also",
        .kind = Kind::name,
        .many = Many::list,
        .fallback = "nobody else",
        .doc = "Further participants that are told; their templates have the same switch.",
        .example = "[grains]"},
       {.name = "by",
        .kind = Kind::choice,
        .names = {"switch", "unchanged_inputs"},
        .fallback = "switch",
        .doc = "`switch`: the script does it, as said above. `unchanged_inputs`: a window in which "
               "all that the participant receives has the bytes of its last window is not run, and "
               "its answers are taken to be the same; for participants that are stateless and do "
               "not look at the time.",
        .example = "unchanged_inputs"},
       {.name = "what",
        .required = true,
        .doc = "What is not done; {windows} becomes their number.",
        .example = "fluid solve, windows 2 to {windows}"},
       {.name = "why",
        .required = true,
        .doc = "Why it is not needed.",
        .example = "linear; geometry and viscosity do not change"},
       when_key()}};
}

}  // namespace

const Key* Object::find(const std::string& key) const {
  const auto found =
      std::find_if(keys.begin(), keys.end(), [&](const Key& row) { return row.name == key; });
  return found == keys.end() ? nullptr : &*found;
}

std::vector<std::string> Object::key_names() const {
  std::vector<std::string> names;
  for (const Key& key : keys) names.push_back(key.name);
  return names;
}

const std::vector<Object>& objects() {
  static const std::vector<Object> all = {
      workflow_keys(), parameter_keys(), stage_keys(),      participant_keys(),
      coupling_keys(), stability_keys(), rest_keys(),       field_keys(),
      mapping_keys(),  record_keys(),    comparison_keys(), reference_keys(),
      left_out_keys(), study_keys(),     points_keys(),     work_precision_keys()};
  return all;
}

const Object& object(const std::string& name) {
  for (const Object& candidate : objects()) {
    if (candidate.name == name) return candidate;
  }
  throw std::logic_error("no table of keys for " + name);
}

std::string description_of(const Key& key) {
  const auto one = [&]() -> std::string {
    switch (key.kind) {
      case Kind::version:
        return "1";
      case Kind::text:
        return "text";
      case Kind::name:
        return "name";
      case Kind::choice:
        return fmt::format("{}", fmt::join(key.names, ", "));
      case Kind::toggle:
        return "true or false";
      case Kind::count:
        return "whole number";
      case Kind::number:
        return key.unit == "*" ? "number with its unit" : fmt::format("number in {}", key.unit);
      case Kind::unit:
        return "unit";
      case Kind::template_:
        return "path below templates/";
      case Kind::literal:
        return "number, true or false, text";
      case Kind::given:
        return "list of parameters, or map of names to values";
      case Kind::condition:
        return "map of parameters to a value or a list of values";
      case Kind::settings:
        return "map of parameters to a value";
      case Kind::sweep:
        return "map of parameters to a list of values";
      case Kind::shape:
        return "list of lengths";
      case Kind::selection:
        return "list of names, all, none";
      case Kind::object:
        return key.object;
    }
    return {};
  };
  std::string text = one();
  if (key.many == Many::list) text = "list of " + text;
  if (key.many == Many::map) text = "map of names to " + text;
  if (key.reference) text += ", or $parameter";
  return text;
}

}  // namespace sandglass::workflow
