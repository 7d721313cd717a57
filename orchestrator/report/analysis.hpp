#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "render/value.hpp"

/// What happens after the last window: analyses are read, compared with references, and shown.
namespace sandglass::report {

/// One result of an analysis stage.
struct Computed {
  std::string stage;
  Value value;          ///< a number, a list (also of lists), or absent: not defined in this run
  std::string unit;     ///< an SI unit without a factor, such as "m/s"; "" or "1" for none
  std::string meaning;  ///< one sentence
};

/// One axis of a curve, in SI.
struct Axis {
  std::string name;
  std::string unit;
  std::vector<double> values;  ///< NaN is a gap
  std::vector<double> error;   ///< half the length of the error bars; empty when none are given
};

enum class Kind { computed, analytic, published, measured };

struct Curve {
  std::string stage;
  Kind kind = Kind::computed;
  std::string label;
  std::string source;
  Axis x;
  Axis y;               ///< as many values as x
  std::string file;     ///< CSV in the stage's work directory; may be empty
  bool points = false;  ///< drawn without a line
};

/// A line across a panel at one value, with a label.
struct Mark {
  bool on_x = true;  ///< the value is an abscissa
  double value = 0;  ///< SI
  std::string label;
};

struct Panel {
  std::string title;
  std::string x_label;
  std::string x_unit;  ///< the unit it is drawn in
  std::string y_label;
  std::string y_unit;
  bool x_logarithmic = false;
  bool y_logarithmic = false;
  std::vector<std::string> curves;  ///< names of curves, in the order they are drawn
  std::vector<Mark> marks;
  std::vector<std::pair<double, std::string>> y_names;  ///< what some ordinates stand for
};

struct Figure {
  std::string stage;
  std::string name;  ///< letters, digits, '_', '-': becomes the name of its files
  std::string title;
  std::string caption;
  int columns = 0;  ///< panels beside each other; 0: two where there are two
  std::vector<Panel> panels;
};

/// Texts in rows, as many in each as there are columns.
struct Table {
  std::string stage;
  std::string name;
  std::string title;
  std::string caption;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// What the analysis stages of a run have found, by name.
struct Analysis {
  std::map<std::string, Computed> quantities;
  std::map<std::string, Curve> curves;
  std::vector<Figure> figures;
  std::vector<Table> tables;
};

/// Reads the `analysis.json` that `stage` wrote (format 1, templates/README.md). Throws
/// Error::participant naming the stage, the place inside the file and what is wrong with it;
/// Error::environment when the file cannot be read.
Analysis read_analysis(const std::string& path, const std::string& stage);

/// Reads stages/NAME/analysis.json of every named stage of the run directory into one. Throws as
/// read_analysis, and Error::participant when two stages define the same name.
Analysis read_analyses(const std::string& run_directory, const std::vector<std::string>& stages);

/// The stages of a run directory that have left an analysis.json, in order of name.
std::vector<std::string> analysed_stages(const std::string& run_directory);

}  // namespace sandglass::report
