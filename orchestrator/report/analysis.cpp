#include "report/analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/unit.hpp"

namespace sandglass::report {
namespace {

using nlohmann::json;

/// A part of an analysis.json, knowing where it stands, for messages such as
/// "analysis stage 'analyse': analysis.json: figures[0].panels[1].x_scale: ...".
class Part {
 public:
  Part(const json& value, std::string place, const std::string& stage)
      : value_(value), place_(std::move(place)), stage_(stage) {}

  [[noreturn]] void fail(const std::string& what, const std::string& remedy = {}) const {
    throw Error::participant(fmt::format("analysis stage '{}': analysis.json: {}{}{}", stage_,
                                         place_, place_.empty() ? "" : ": ", what),
                             remedy);
  }

  [[nodiscard]] bool has(const char* key) const {
    return value_.is_object() && value_.contains(key) && !value_.at(key).is_null();
  }
  [[nodiscard]] Part at(const char* key) const {
    if (!value_.is_object()) fail("must be a map");
    const auto found = value_.find(key);
    if (found == value_.end()) fail(fmt::format("'{}' is missing", key));
    return {*found, place_.empty() ? key : place_ + "." + key, stage_};
  }
  [[nodiscard]] std::vector<Part> list() const {
    if (!value_.is_array()) fail("must be a list");
    std::vector<Part> parts;
    for (size_t i = 0; i < value_.size(); ++i) {
      parts.emplace_back(value_[i], fmt::format("{}[{}]", place_, i), stage_);
    }
    return parts;
  }
  [[nodiscard]] std::vector<std::pair<std::string, Part>> map() const {
    if (!value_.is_object()) fail("must be a map");
    std::vector<std::pair<std::string, Part>> parts;
    for (const auto& [key, item] : value_.items()) {
      parts.emplace_back(key, Part(item, place_ + "." + key, stage_));
    }
    return parts;
  }
  /// Panels and figures are written by hand in the analysis script: a mistyped key is an error.
  void allow(std::initializer_list<const char*> keys) const {
    if (!value_.is_object()) fail("must be a map");
    const std::vector<std::string> known(keys.begin(), keys.end());
    for (const auto& item : value_.items()) {
      if (std::find(known.begin(), known.end(), item.key()) == known.end()) {
        fail(fmt::format("unknown key '{}'", item.key()), suggestion(item.key(), known));
      }
    }
  }

  [[nodiscard]] std::string text() const {
    if (!value_.is_string()) fail("must be text");
    return value_.get<std::string>();
  }
  [[nodiscard]] std::string text_or_empty(const char* key) const {
    return has(key) ? at(key).text() : std::string();
  }
  [[nodiscard]] bool toggle() const {
    if (!value_.is_boolean()) fail("must be true or false");
    return value_.get<bool>();
  }
  /// A number; JSON has no word for the others, so null and "nan" are NaN, "inf" and "-inf" too.
  [[nodiscard]] double number() const {
    if (value_.is_number()) return value_.get<double>();
    if (value_.is_null()) return std::numeric_limits<double>::quiet_NaN();
    if (value_ == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (value_ == "inf") return std::numeric_limits<double>::infinity();
    if (value_ == "-inf") return -std::numeric_limits<double>::infinity();
    fail("must be a number");
  }
  [[nodiscard]] std::vector<double> numbers() const {
    if (!value_.is_array()) fail("must be a list of numbers");
    std::vector<double> all;
    all.reserve(value_.size());
    for (size_t i = 0; i < value_.size(); ++i) {
      const json& item = value_[i];
      all.push_back(item.is_number()
                        ? item.get<double>()
                        : Part(item, fmt::format("{}[{}]", place_, i), stage_).number());
    }
    return all;
  }
  /// null is "not defined in this run"; "nan" is a number that went wrong.
  [[nodiscard]] Value value() const {
    if (value_.is_null()) return {};
    if (!value_.is_array()) return number();
    Value::List all;
    for (const Part& part : list()) all.push_back(part.value());
    return all;
  }
  /// Values are SI: a unit with a factor in it would be read wrongly by somebody.
  [[nodiscard]] std::string si_unit() const {
    const std::string unit = text();
    if (!Unit::valid(unit)) fail(fmt::format("'{}' is not a unit", unit));
    if (Unit::to_si(1.0, unit) != 1.0 || Unit::to_si(0.0, unit) != 0.0) {
      fail(fmt::format("'{}' is not an SI unit", unit),
           "values are SI: multiply by the factor in the analysis; a panel may still be drawn in "
           "another unit");
    }
    return unit;
  }
  /// The unit a panel is drawn in, which must be able to show values of `shown`.
  [[nodiscard]] std::string unit_for(const std::string& shown) const {
    const std::string unit = text();
    if (!Unit::valid(unit)) fail(fmt::format("'{}' is not a unit", unit));
    if (!Unit::convertible(shown, unit)) {
      fail(fmt::format("a curve in '{}' cannot be drawn in '{}'", shown, unit));
    }
    return unit;
  }
  /// Names become file names.
  void check_name(const std::string& name) const {
    const bool good = !name.empty() && name.size() <= 100 && name.front() != '-' &&
                      std::all_of(name.begin(), name.end(), [](char c) {
                        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                               (c >= '0' && c <= '9') || c == '_' || c == '-';
                      });
    if (!good) {
      fail(fmt::format("'{}' is not a name", name), "names are letters, digits, '_' and '-'");
    }
  }

 private:
  const json& value_;
  std::string place_;
  const std::string& stage_;
};

Axis read_axis(const Part& part) {
  Axis axis;
  axis.name = part.text_or_empty("name");
  axis.unit = part.at("unit").si_unit();
  axis.values = part.at("values").numbers();
  if (part.has("error")) {
    axis.error = part.at("error").numbers();
    if (axis.error.size() != axis.values.size()) {
      part.fail(fmt::format("{} error bars for {} values", axis.error.size(), axis.values.size()));
    }
  }
  return axis;
}

Curve read_curve(const Part& part) {
  static const std::vector<std::string> kinds = {"computed", "analytic", "published", "measured"};
  Curve curve;
  const std::string kind = part.at("kind").text();
  const auto found = std::find(kinds.begin(), kinds.end(), kind);
  if (found == kinds.end()) {
    part.at("kind").fail(fmt::format("unknown kind '{}'", kind), suggestion(kind, kinds));
  }
  curve.kind = static_cast<Kind>(found - kinds.begin());
  curve.label = part.text_or_empty("label");
  curve.source = part.text_or_empty("source");
  curve.x = read_axis(part.at("x"));
  curve.y = read_axis(part.at("y"));
  if (curve.x.values.size() != curve.y.values.size()) {
    part.fail(
        fmt::format("{} abscissae and {} ordinates", curve.x.values.size(), curve.y.values.size()));
  }
  curve.points = part.has("points") && part.at("points").toggle();
  curve.file = part.text_or_empty("file");
  if (curve.file.find('/') != std::string::npos || curve.file.starts_with("..")) {
    part.at("file").fail("must be a file in the stage's own work directory");
  }
  return curve;
}

bool read_logarithmic(const Part& panel, const char* key) {
  if (!panel.has(key)) return false;
  const std::string scale = panel.at(key).text();
  if (scale != "linear" && scale != "log") {
    panel.at(key).fail(fmt::format("unknown scale '{}'", scale), "valid: linear, log");
  }
  return scale == "log";
}

Mark read_mark(const Part& part) {
  part.allow({"axis", "value", "label"});
  Mark mark;
  const std::string axis = part.at("axis").text();
  if (axis != "x" && axis != "y") part.at("axis").fail("must be 'x' or 'y'");
  mark.on_x = axis == "x";
  mark.value = part.at("value").number();
  mark.label = part.text_or_empty("label");
  return mark;
}

Panel read_panel(const Part& part, const Analysis& analysis) {
  part.allow({"title", "x_label", "x_unit", "y_label", "y_unit", "x_scale", "y_scale", "curves",
              "marks", "y_names"});
  Panel panel;
  panel.title = part.text_or_empty("title");
  panel.x_label = part.text_or_empty("x_label");
  panel.y_label = part.text_or_empty("y_label");
  panel.x_logarithmic = read_logarithmic(part, "x_scale");
  panel.y_logarithmic = read_logarithmic(part, "y_scale");
  std::vector<std::string> known;
  for (const auto& [name, curve] : analysis.curves) known.push_back(name);
  for (const Part& item : part.at("curves").list()) {
    const std::string name = item.text();
    const auto found = analysis.curves.find(name);
    if (found == analysis.curves.end()) {
      item.fail(fmt::format("the analysis has no curve '{}'", name), suggestion(name, known));
    }
    const Curve& curve = found->second;
    const bool first = panel.curves.empty();
    panel.curves.push_back(name);
    if (first && panel.x_label.empty()) panel.x_label = curve.x.name;
    if (first && panel.y_label.empty()) panel.y_label = curve.y.name;
    // Without a unit of its own a panel is drawn in that of its first curve.
    if (part.has("x_unit"))
      panel.x_unit = part.at("x_unit").unit_for(curve.x.unit);
    else if (first)
      panel.x_unit = curve.x.unit;
    if (part.has("y_unit"))
      panel.y_unit = part.at("y_unit").unit_for(curve.y.unit);
    else if (first)
      panel.y_unit = curve.y.unit;
    if (!Unit::convertible(curve.x.unit, panel.x_unit) ||
        !Unit::convertible(curve.y.unit, panel.y_unit)) {
      item.fail(fmt::format("curve '{}' ({} over {}) does not fit a panel of {} over {}", name,
                            curve.y.unit, curve.x.unit, panel.y_unit, panel.x_unit));
    }
  }
  if (part.has("marks")) {
    for (const Part& item : part.at("marks").list()) panel.marks.push_back(read_mark(item));
  }
  if (part.has("y_names")) {
    for (const Part& item : part.at("y_names").list()) {
      item.allow({"value", "name"});
      panel.y_names.emplace_back(item.at("value").number(), item.at("name").text());
    }
  }
  return panel;
}

Figure read_figure(const Part& part, const Analysis& analysis) {
  part.allow({"name", "title", "caption", "columns", "panels"});
  Figure figure;
  figure.name = part.at("name").text();
  part.at("name").check_name(figure.name);
  figure.title = part.text_or_empty("title");
  figure.caption = part.text_or_empty("caption");
  if (part.has("columns")) {
    const double columns = part.at("columns").number();
    if (!(columns >= 1 && columns <= 4 && columns == std::floor(columns))) {
      part.at("columns").fail("must be 1, 2, 3 or 4");
    }
    figure.columns = static_cast<int>(columns);
  }
  for (const Part& item : part.at("panels").list()) {
    figure.panels.push_back(read_panel(item, analysis));
  }
  if (figure.panels.empty()) part.at("panels").fail("a figure needs at least one panel");
  return figure;
}

Table read_table(const Part& part, const std::string& stage) {
  part.allow({"name", "title", "caption", "columns", "rows"});
  Table table;
  table.stage = stage;
  table.name = part.at("name").text();
  part.at("name").check_name(table.name);
  table.title = part.text_or_empty("title");
  table.caption = part.text_or_empty("caption");
  for (const Part& column : part.at("columns").list()) table.columns.push_back(column.text());
  for (const Part& row : part.at("rows").list()) {
    table.rows.emplace_back();
    for (const Part& cell : row.list()) table.rows.back().push_back(cell.text());
    if (table.rows.back().size() != table.columns.size()) {
      row.fail(
          fmt::format("{} cells for {} columns", table.rows.back().size(), table.columns.size()));
    }
  }
  return table;
}

json parse(const std::string& path, const std::string& stage) {
  try {
    return json::parse(read_file(path));
  } catch (const json::exception& error) {
    throw Error::participant(
        fmt::format("analysis stage '{}': analysis.json is not JSON: {}", stage, error.what()),
        "JSON knows no NaN or Infinity: write null where a value is not defined in this run, "
        "\"nan\" or \"inf\" where it is not finite");
  }
}

template <typename Item>
void merge(std::map<std::string, Item>& all, std::map<std::string, Item>& added, const char* what) {
  for (auto& [name, item] : added) {
    const auto [place, is_new] = all.try_emplace(name, std::move(item));
    if (!is_new) {
      throw Error::participant(fmt::format("analysis stages '{}' and '{}' both define the {} '{}'",
                                           place->second.stage, item.stage, what, name),
                               "rename one of them");
    }
  }
}

}  // namespace

Analysis read_analysis(const std::string& path, const std::string& stage) {
  const json document = parse(path, stage);
  const Part root(document, "", stage);
  if (root.at("format").number() != 1) {
    root.at("format").fail(fmt::format("format {} is not known", document.at("format").dump()),
                           "this program reads format 1");
  }
  Analysis analysis;
  for (const auto& [name, part] : root.at("quantities").map()) {
    part.check_name(name);
    analysis.quantities[name] = {stage, part.at("value").value(), part.at("unit").si_unit(),
                                 part.text_or_empty("meaning")};
  }
  for (const auto& [name, part] : root.at("curves").map()) {
    part.check_name(name);
    Curve curve = read_curve(part);
    curve.stage = stage;
    analysis.curves[name] = std::move(curve);
  }
  for (const Part& part : root.at("figures").list()) {
    Figure figure = read_figure(part, analysis);
    figure.stage = stage;
    for (const Figure& other : analysis.figures) {
      if (other.name == figure.name) {
        part.fail(fmt::format("a second figure named '{}'", figure.name), "rename one of them");
      }
    }
    analysis.figures.push_back(std::move(figure));
  }
  if (root.has("tables")) {
    for (const Part& part : root.at("tables").list()) {
      analysis.tables.push_back(read_table(part, stage));
    }
  }
  return analysis;
}

Analysis read_analyses(const std::string& run_directory, const std::vector<std::string>& stages) {
  Analysis all;
  for (const std::string& stage : stages) {
    Analysis one = read_analysis(run_directory + "/stages/" + stage + "/analysis.json", stage);
    merge(all.quantities, one.quantities, "quantity");
    merge(all.curves, one.curves, "curve");
    for (Figure& figure : one.figures) {
      for (const Figure& other : all.figures) {
        if (other.name == figure.name) {
          throw Error::participant(fmt::format("analysis stages '{}' and '{}' both define the "
                                               "figure '{}'",
                                               other.stage, stage, figure.name),
                                   "rename one of them");
        }
      }
      all.figures.push_back(std::move(figure));
    }
    for (Table& table : one.tables) all.tables.push_back(std::move(table));
  }
  return all;
}

std::vector<std::string> analysed_stages(const std::string& run_directory) {
  std::vector<std::string> stages;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(run_directory + "/stages", error)) {
    if (std::filesystem::exists(entry.path() / "analysis.json", error)) {
      stages.push_back(entry.path().filename().string());
    }
  }
  std::sort(stages.begin(), stages.end());
  return stages;
}

}  // namespace sandglass::report
