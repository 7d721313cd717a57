#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "coupling/relaxation.hpp"
#include "coupling/rest.hpp"
#include "coupling/scheme.hpp"
#include "coupling/stability.hpp"
#include "exchange/mapping.hpp"
#include "exchange/transform.hpp"
#include "render/value.hpp"

/// The checked model of a workflow: what the other rooms see. Everything is resolved: parameters
/// have their final values, references are replaced, cases are chosen, `when` is decided. Numbers
/// are SI.
namespace sandglass::workflow {

struct Parameter {
  enum class Type { number, count, toggle, choice, text };
  std::string name;
  Type type = Type::number;
  Value value;
  std::string unit;     ///< the unit it is declared and reported in; the value itself is SI
  std::string meaning;  ///< one sentence
  std::string source;   ///< where the value comes from
  std::vector<std::string> choices;
  bool overridden = false;  ///< set from the command line
  Place place;
};

/// A file that another stage makes, given to a template by name; resolved to a path by the run.
struct FileReference {
  std::string stage;  ///< the stage that makes it; empty: a file of the project (under data/)
  std::string file;
};

/// What a template is given under one name.
struct Given {
  Value value;                        ///< unused where `file` is set
  std::optional<FileReference> file;  ///< arrives in the template as an absolute path (text)
  Place place;
};
using GivenMap = std::map<std::string, Given>;

enum class Program { gmsh, python, freefem, yade, lammps, command, coupling };

struct Stage {
  std::string name;
  Program program = Program::python;
  std::string template_path;         ///< relative to templates/; empty for coupling and command
  std::vector<std::string> command;  ///< argument vector, for Program::command
  GivenMap given;
  std::vector<std::string> makes;  ///< files it must have made, relative to its work directory
  std::vector<std::string> after;  ///< stages that must be done before, files' makers included
  bool reuse = false;              ///< its products are kept for later runs
  bool analysis = false;           ///< a python stage that reads the record and writes quantities
  double deadline = 0;             ///< seconds
  Place place;
};

enum class Solver { yade, freefem, lammps, command };
enum class Lifetime { resident, fresh };

struct Participant {
  std::string name;
  Solver solver = Solver::command;
  std::string template_path;         ///< the script it starts with
  std::string window_template_path;  ///< the script executed per window; may be empty
  std::vector<std::string> command;  ///< argument vector, for Solver::command
  GivenMap given;                    ///< to template and window template together
  Lifetime lifetime = Lifetime::resident;
  int threads = 1;
  int ranks = 1;         ///< processes under MPI, for Solver::lammps
  double deadline = 60;  ///< seconds that one answer may take
  Place place;
};

using exchange::Transform;

/// How a field crosses between points that do not coincide.
struct FieldMapping {
  exchange::MappingMethod method = exchange::MappingMethod::linear;
  bool conservative = false;
  std::string from_points;  ///< fields
  std::string to_points;
  std::string cells;  ///< may be empty
  double limit = 0;   ///< m
};

struct Field {
  std::string name;
  std::string unit;
  std::vector<std::int64_t> shape;  ///< as sent; the first axis may be counted at run time
  bool variable = false;            ///< the first axis of `shape` is an upper limit
  std::string from;
  std::string to;  ///< a participant; empty: recorded only
  Transform transform = Transform::identity;
  std::optional<FieldMapping> mapping;
  std::int64_t samples = 0;                  ///< rows after Transform::linear
  std::vector<std::int64_t> received_shape;  ///< as the receiver sees it, after the transform
  double initial = 0;                        ///< every value before the sender has spoken
  bool recorded = true;
  bool relaxed = false;  ///< the unknown of an iteration, or under-relaxed
  bool watched = true;   ///< for growth from window to window
  Place place;
};

using coupling::Acceleration;
using coupling::EnergyLimits;
using coupling::RestLimits;
using coupling::Scheme;
using coupling::StabilityLimits;
enum class Transport { mapped, file };

struct Coupling {
  Scheme scheme = Scheme::serial_explicit;
  double window = 0;  ///< s
  double end = 0;     ///< s; where the last window ends, so maybe a little after what was asked
  std::int64_t windows = 0;  ///< the fewest whole windows that reach the end that was asked for
  std::vector<std::string> order;
  Transport transport = Transport::mapped;
  Acceleration acceleration = Acceleration::none;
  double relaxation = 1;             ///< factor, or the first one
  std::int64_t reused_windows = 10;  ///< of IQN-ILS
  double filter = 1e-2;              ///< of IQN-ILS
  double tolerance = 1e-10;          ///< when a serial-implicit window has converged
  std::int64_t iterations = 100;     ///< that one may take
  StabilityLimits stability;
  EnergyLimits energy;
  RestLimits rest;
  std::vector<Field> fields;
  std::int64_t checkpoint_every = 0;         ///< windows; 0: never
  std::int64_t checkpoints_kept = 0;         ///< the newest ones; 0: all
  std::vector<std::string> fields_left_out;  ///< neither received nor recorded: not sent
  Place place;
};

/// The condition under which a published reference holds.
struct HoldsFor {
  std::string parameter;
  Value value;
  std::string text;  ///< as written, for messages ("2650 kg/m3")
  bool met = true;
};

enum class Metric {
  value,                ///< the quantity itself against the tolerance
  absolute_difference,  ///< |ours - reference|
  relative_difference,  ///< |ours - reference| / |reference|
  maximum_difference,   ///< curves: max over the common abscissa of |ours - reference|
  root_mean_square      ///< curves: root mean square of the difference
};

struct Comparison {
  std::string name;
  std::string quantity;  ///< one of quantity and curve is set
  std::string curve;
  std::optional<double> reference_value;  ///< SI
  std::string reference_quantity;         ///< an analytic reference computed by the analysis
  std::string reference_curve;            ///< a curve of the analysis, or
  std::string reference_file;             ///< a CSV under data/
  std::string unit;
  std::string source;  ///< where the reference was published
  Metric metric = Metric::value;
  double tolerance = 0;  ///< SI, or a ratio for relative metrics
  std::string because;   ///< where the tolerance comes from
  std::vector<HoldsFor> holds_for;
  Place place;
};

/// Something that this scene does not need and that is left out, or put back by --no-prune.
struct LeftOut {
  std::string name;
  std::string of;  ///< participant that is told, as a switch of the same name in its template
  std::vector<std::string> also;  ///< further participants that are told
  std::string what;
  std::string why;
  bool active = true;  ///< false: put back
  /// Windows of `of` in which nothing that it receives has changed; else a switch in its template.
  bool unchanged_inputs = false;
  Place place;
};

/// One `--set name=value`, or one value of a study.
struct Setting {
  std::string name;
  std::string text;
  Place place = {};  ///< where a study says it; empty: the command line
};

/// What the command line changes in a workflow.
struct Changes {
  std::vector<Setting> settings;
  bool keep_all = false;  ///< --no-prune: nothing is left out
  std::vector<std::string> keep;
};

/// Some points of a study: every item of `list` (one empty item where there is none) with every
/// combination of the values of `grid` and of `seeds`.
struct StudyPoints {
  std::string name;
  std::vector<Setting> set;
  std::vector<std::vector<Setting>> list;
  std::vector<std::vector<Setting>> grid;   ///< per parameter its values
  std::vector<std::vector<Setting>> seeds;  ///< the same; points differing here are samples of one
  std::int64_t repeat = 1;
  bool unstable = false;  ///< expected to be ended by the stability watch
  Place place;
};

/// How error against run time is read off the points.
struct WorkPrecision {
  std::string error;                      ///< a quantity
  std::optional<double> reference_value;  ///< SI; one of these two, or none: `error` is the error
  std::string reference_quantity;
  std::vector<std::string> points;   ///< names of sets of points; empty: all
  std::vector<std::string> method;   ///< parameters
  std::vector<std::string> seconds;  ///< stages, participants, ...; empty: the whole run
};

struct Study {
  std::string of;  ///< path of the swept workflow; empty: the file itself
  std::vector<Setting> set;
  std::vector<StudyPoints> points;
  bool judge = true;  ///< comparisons of points decide the exit status
  std::vector<WorkPrecision> work_precision;
  Place place;
};

struct Workflow {
  std::string path;  ///< as given on the command line
  Changes changes;   ///< with which it was resolved
  std::string name;
  std::string title;
  std::string description;
  std::vector<Parameter> parameters;  ///< in file order
  std::vector<Stage> stages;          ///< in an order in which they can run; those that apply
  std::vector<std::string> stages_left_out;
  std::vector<Participant> participants;
  std::optional<Coupling> coupling;
  std::vector<Comparison> comparisons;
  std::vector<LeftOut> left_out;
  std::optional<Study> study;

  [[nodiscard]] const Parameter* parameter(const std::string& name) const;
};

/// The value in its declared unit, as people write it: "0.1 mm", "true", "resident".
std::string shown(const Parameter& parameter);

struct LoadOptions : Changes {
  std::string templates_root;  ///< the templates/ folder
  std::string data_root;       ///< the data/ folder
};

/// The files below data/ that its stages, participants and comparisons name, each once.
std::vector<std::string> data_files(const Workflow& workflow);

/// Reads and checks a workflow, templates included (every name used is given, every name given is
/// used, for every case that could be chosen). Throws Error::refused with all problems of one pass,
/// Error::usage for a setting whose name no parameter has, or when there is no such file,
/// Error::environment when it cannot be read.
Workflow load(const std::string& path, const LoadOptions& options);
/// The same from memory; `path` is for messages.
Workflow load_text(const std::string& text, const std::string& path, const LoadOptions& options);

}  // namespace sandglass::workflow
