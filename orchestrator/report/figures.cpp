#include "report/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/file.hpp"
#include "base/unit.hpp"
#include "process/process.hpp"
#include "report/format.hpp"

namespace sandglass::report {
namespace {

using nlohmann::json;

/// The affine map from SI to a unit; looked up once per axis, not per value.
class Scale {
 public:
  explicit Scale(const std::string& unit)
      : offset_(Unit::from_si(0.0, unit)), factor_(Unit::from_si(1.0, unit) - offset_) {}
  [[nodiscard]] double operator()(double si) const { return offset_ + factor_ * si; }
  [[nodiscard]] double length(double si) const { return factor_ * si; }

 private:
  double offset_;
  double factor_;
};

json finite(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json finite(const std::vector<double>& values) {
  json all = json::array();
  for (const double value : values) all.push_back(finite(value));
  return all;
}

std::string axis_label(const std::string& label, const std::string& unit) {
  const std::string shown = pretty_unit(unit);
  if (shown.empty()) return label;
  return label.empty() ? shown : fmt::format("{} ({})", label, shown);
}

const char* kind_name(Kind kind) {
  switch (kind) {
    case Kind::analytic:
      return "analytic";
    case Kind::published:
      return "published";
    case Kind::measured:
      return "measured";
    case Kind::computed:
      break;
  }
  return "computed";
}

json curve_to_json(const Curve& curve, const Scale& x_scale, const Scale& y_scale) {
  std::vector<double> x = curve.x.values;
  std::vector<double> y = curve.y.values;
  std::vector<double> error = curve.y.error;
  std::vector<double> x_error = curve.x.error;
  std::transform(x.begin(), x.end(), x.begin(), x_scale);
  std::transform(y.begin(), y.end(), y.begin(), y_scale);
  for (double& value : error) value = y_scale.length(value);
  for (double& value : x_error) value = x_scale.length(value);
  constexpr size_t most = 4000;  // a panel is some 700 dots wide
  if (error.empty() && x_error.empty()) thin(x, y, most);
  return {{"kind", kind_name(curve.kind)},
          {"label", curve.label},
          {"x", finite(x)},
          {"y", finite(y)},
          {"x_error", finite(x_error)},
          {"error", finite(error)},
          {"points", curve.points}};
}

json panel_to_json(const Panel& panel, const Analysis& analysis) {
  const Scale x_scale(panel.x_unit);
  const Scale y_scale(panel.y_unit);
  json curves = json::array();
  for (const std::string& name : panel.curves) {
    curves.push_back(curve_to_json(analysis.curves.at(name), x_scale, y_scale));
  }
  json marks = json::array();
  for (const Mark& mark : panel.marks) {
    if (!std::isfinite(mark.value)) continue;
    marks.push_back({{"axis", mark.on_x ? "x" : "y"},
                     {"value", (mark.on_x ? x_scale : y_scale)(mark.value)},
                     {"label", mark.label}});
  }
  json y_names = json::array();
  for (const auto& [value, name] : panel.y_names) {
    y_names.push_back({{"value", y_scale(value)}, {"name", name}});
  }
  return {{"title", panel.title},
          {"x_label", axis_label(panel.x_label, panel.x_unit)},
          {"y_label", axis_label(panel.y_label, panel.y_unit)},
          {"x_scale", panel.x_logarithmic ? "log" : "linear"},
          {"y_scale", panel.y_logarithmic ? "log" : "linear"},
          {"curves", std::move(curves)},
          {"marks", std::move(marks)},
          {"y_names", std::move(y_names)}};
}

}  // namespace

void thin(std::vector<double>& x, std::vector<double>& y, size_t most) {
  if (x.size() <= most) return;
  const size_t stretch = 2 * x.size() / std::max<size_t>(most, 2) + 1;
  std::vector<double> few_x;
  std::vector<double> few_y;
  const auto keep = [&](size_t i) {
    few_x.push_back(x[i]);
    few_y.push_back(y[i]);
  };
  keep(0);
  for (size_t begin = 1; begin + 1 < x.size(); begin += stretch) {
    const size_t end = std::min(begin + stretch, x.size() - 1);
    size_t low = begin;
    size_t high = begin;
    for (size_t i = begin; i < end; ++i) {
      if (y[i] < y[low]) low = i;
      if (y[i] > y[high]) high = i;
    }
    keep(std::min(low, high));
    if (low != high) keep(std::max(low, high));
  }
  keep(x.size() - 1);
  x = std::move(few_x);
  y = std::move(few_y);
}

std::string figures_to_json(const Analysis& analysis) {
  json figures = json::array();
  for (const Figure& figure : analysis.figures) {
    json panels = json::array();
    for (const Panel& panel : figure.panels) panels.push_back(panel_to_json(panel, analysis));
    figures.push_back({{"name", figure.name},
                       {"title", figure.title},
                       {"columns", figure.columns},
                       {"panels", std::move(panels)}});
  }
  return json{{"figures", std::move(figures)}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

void draw_figures(const Analysis& analysis, const std::string& run_directory,
                  const ReportTools& tools) {
  if (analysis.figures.empty()) return;
  const std::string folder = run_directory + "/figures";
  make_directories(folder);
  write_file(folder + "/figures.json", figures_to_json(analysis));
  Command command;
  // -I: whatever Python the user's environment points to has no say here.
  command.arguments = {tools.python, "-I", tools.templates_root + "/report/draw.py", "figures.json",
                       "."};
  command.directory = folder;
  command.log = folder + "/draw.log";
  run_to_end("drawing of the figures", command, tools.deadline);
}

}  // namespace sandglass::report
