#include "study/contrast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/unit.hpp"
#include "report/analysis.hpp"
#include "report/compare.hpp"
#include "report/result.hpp"
#include "study/directory.hpp"

namespace sandglass::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Texts = std::map<std::string, std::string>;

constexpr const char* nothing = "-";

json read_json(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return json::object();
  const json found = json::parse(read_file(path), nullptr, false);
  return found.is_object() ? found : json::object();
}

/// Where a number is a digest only that it differs matters.
std::string short_text(const std::string& text) {
  constexpr std::size_t sha256 = 64;
  constexpr std::size_t enough = 12;
  return text.size() == sha256 ? text.substr(0, enough) : text;
}

/// Everything that went into a run, by name.
Texts inputs_of(const std::string& run) {
  Texts inputs;
  const json workflow = read_json(run + "/workflow.json");
  if (workflow.contains("parameters")) {
    for (const auto& [name, one] : workflow.at("parameters").items()) {
      inputs["parameter " + name] = one.value("shown", "");
    }
  }
  const json provenance = read_json(run + "/provenance.json");
  const auto files = [&](const char* list, const std::string& title) {
    if (!provenance.contains(list)) return;
    for (const json& one : provenance.at(list)) {
      inputs[title + one.value("path", "")] = one.value("digest", "");
    }
  };
  files("templates", "");
  files("data", "");
  if (provenance.contains("solvers")) {
    for (const json& one : provenance.at("solvers")) {
      const std::string name = "solver " + one.value("name", "");
      inputs[name] = one.value("version", "");
      inputs[name + ", the program"] = one.value("digest", "");
      for (const json& part : one.value("parts", json::array())) {
        inputs[name + ", " + part.value("path", "")] = part.value("digest", "");
      }
    }
  }
  if (provenance.contains("program")) {
    inputs["sandglass"] = provenance.at("program").value("digest", "");
  }
  if (provenance.contains("host")) {
    const json& host = provenance.at("host");
    inputs["machine"] = host.value("processor", "") + ", " + host.value("system", "");
  }
  return inputs;
}

std::vector<Difference> differing(const Texts& left, const Texts& right) {
  std::vector<Difference> all;
  for (const auto& [name, text] : left) {
    const auto other = right.find(name);
    if (other == right.end()) {
      all.push_back({name, short_text(text), nothing, {}});
    } else if (other->second != text) {
      all.push_back({name, short_text(text), short_text(other->second), {}});
    }
  }
  for (const auto& [name, text] : right) {
    if (!left.contains(name)) all.push_back({name, nothing, short_text(text), {}});
  }
  return all;
}

/// All numbers of a value, lists flattened.
void flatten(const Value& value, std::vector<double>& numbers) {
  if (const double* number = value.as<double>()) numbers.push_back(*number);
  if (const Value::List* list = value.as<Value::List>()) {
    for (const Value& item : *list) flatten(item, numbers);
  }
}

/// The largest relative difference; infinite where the values are not even of a kind.
double relative_difference(const Value& left, const Value& right) {
  std::vector<double> a;
  std::vector<double> b;
  flatten(left, a);
  flatten(right, b);
  if (a.size() != b.size()) return HUGE_VAL;
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i]))) continue;
    const double size = std::max(std::abs(a[i]), std::abs(b[i]));
    const double difference = std::abs(a[i] - b[i]) / size;
    largest = std::max(largest, std::isfinite(difference) ? difference : HUGE_VAL);
  }
  return largest;
}

std::string shown(const report::ResultQuantity& quantity) {
  if (quantity.value.absent()) return "not defined";
  const std::string unit = quantity.unit == "1" ? "" : " " + quantity.unit;
  if (const double* number = quantity.value.as<double>()) return shortest(*number) + unit;
  std::vector<double> numbers;
  flatten(quantity.value, numbers);
  return fmt::format("{} values{}", numbers.size(), unit);
}

std::string size_text(double relative) {
  return std::isfinite(relative) ? fmt::format("relative {:.3g}", relative) : std::string();
}

void compare_quantities(const report::Result& left, const report::Result& right,
                        Contrast& contrast) {
  for (const auto& [name, quantity] : left.quantities) {
    const auto other = right.quantities.find(name);
    if (other == right.quantities.end()) {
      contrast.quantities.push_back({name, shown(quantity), nothing, {}});
      continue;
    }
    const double relative = relative_difference(quantity.value, other->second.value);
    if (relative == 0) {
      ++contrast.same_quantities;
      continue;
    }
    contrast.quantities.push_back(
        {name, shown(quantity), shown(other->second), size_text(relative)});
  }
  for (const auto& [name, quantity] : right.quantities) {
    if (!left.quantities.contains(name)) {
      contrast.quantities.push_back({name, nothing, shown(quantity), {}});
    }
  }
}

/// Without gaps, abscissae ascending.
report::Points points_of(const report::Curve& curve) {
  std::vector<std::pair<double, double>> pairs;
  for (std::size_t i = 0; i < curve.x.values.size(); ++i) {
    if (std::isfinite(curve.x.values[i]) && std::isfinite(curve.y.values[i])) {
      pairs.emplace_back(curve.x.values[i], curve.y.values[i]);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  report::Points points;
  for (const auto& [x, y] : pairs) {
    points.x.push_back(x);
    points.y.push_back(y);
  }
  return points;
}

report::Analysis analysis_of(const std::string& run) {
  return report::read_analyses(run, report::analysed_stages(run));
}

std::string points_text(const report::Curve& curve) {
  return fmt::format("{} points", curve.x.values.size());
}

void compare_curves(const std::string& left, const std::string& right, Contrast& contrast) {
  const report::Analysis a = analysis_of(left);
  const report::Analysis b = analysis_of(right);
  for (const auto& [name, curve] : a.curves) {
    const auto other = b.curves.find(name);
    if (other == b.curves.end()) {
      contrast.curves.push_back({name, points_text(curve), nothing, {}});
      continue;
    }
    const report::Difference difference =
        report::difference_of_curves(points_of(curve), points_of(other->second));
    double largest = 0;
    for (const double value : difference.values) largest = std::max(largest, std::abs(value));
    if (largest == 0 && curve.x.values.size() == other->second.x.values.size()) {
      ++contrast.same_curves;
      continue;
    }
    contrast.curves.push_back(
        {name, points_text(curve), points_text(other->second),
         difference.values.empty()
             ? "no common abscissae"
             : fmt::format("at most {:.3g} {} from {:.4g} to {:.4g} {}", largest, curve.y.unit,
                           difference.from, difference.to, curve.x.unit)});
  }
  for (const auto& [name, curve] : b.curves) {
    if (!a.curves.contains(name)) {
      contrast.curves.push_back({name, nothing, points_text(curve), {}});
    }
  }
}

Contrast contrast_of_runs(const std::string& left, const std::string& right) {
  Contrast result;
  result.inputs = differing(inputs_of(left), inputs_of(right));
  compare_quantities(report::read_result(left), report::read_result(right), result);
  compare_curves(left, right, result);
  return result;
}

/// Of two results of a point: how they ended, or the quantity that differs most.
void compare_points(const std::string& point, const report::Result& a, const report::Result& b,
                    Contrast& contrast) {
  if (a.exit_code != b.exit_code) {
    contrast.quantities.push_back({point + ": ended", a.status, b.status, {}});
    return;
  }
  Contrast inner;
  compare_quantities(a, b, inner);
  contrast.same_quantities += inner.same_quantities;
  double largest = -1;
  Difference most;
  for (const Difference& one : inner.quantities) {
    const auto left = a.quantities.find(one.what);
    const auto right = b.quantities.find(one.what);
    const bool both = left != a.quantities.end() && right != b.quantities.end();
    const double size =
        both ? relative_difference(left->second.value, right->second.value) : HUGE_VAL;
    if (size <= largest) continue;
    largest = size;
    most = one;
  }
  if (largest < 0) return;
  most.what = point + ": " + most.what;
  if (inner.quantities.size() > 1) {
    most.size += fmt::format("{}{} quantities differ", most.size.empty() ? "" : "; ",
                             inner.quantities.size());
  }
  contrast.quantities.push_back(std::move(most));
}

Contrast contrast_of_studies(const StudyDirectory& left, const StudyDirectory& right) {
  Contrast result;
  std::map<std::string, std::string> runs_on_the_right;  // point: the point whose run is its own
  const auto run_of = [](const StudyDirectory::Entry& entry) {
    return entry.twin_of.empty() ? entry.point : entry.twin_of;
  };
  for (const auto& entry : right.read()) runs_on_the_right[entry.point] = run_of(entry);
  std::map<std::string, Difference> inputs;  // what all points have in common is said once
  for (const auto& entry : left.read()) {
    const auto found = runs_on_the_right.find(entry.point);
    if (found == runs_on_the_right.end()) {
      result.inputs.push_back({"point " + entry.point, "there", nothing, {}});
      continue;
    }
    const Outcome a = left.outcome(run_of(entry));
    const Outcome b = right.outcome(found->second);
    for (Difference& one :
         differing(inputs_of(left.run_of(run_of(entry))), inputs_of(right.run_of(found->second)))) {
      inputs.emplace(one.what + one.left + one.right, std::move(one));
    }
    if (a.result && b.result) {
      compare_points(entry.point, *a.result, *b.result, result);
    } else if (a.result || b.result) {
      result.quantities.push_back({entry.point + ": ended",
                                   a.result ? a.result->status : nothing,
                                   b.result ? b.result->status : nothing,
                                   {}});
    }
    runs_on_the_right.erase(found);
  }
  for (const auto& [point, run] : runs_on_the_right) {
    result.inputs.push_back({"point " + point, nothing, "there", {}});
  }
  for (auto& [key, one] : inputs) result.inputs.push_back(std::move(one));
  std::error_code error;
  if (fs::exists(left.summary() + "/result.json", error) &&
      fs::exists(right.summary() + "/result.json", error)) {
    compare_quantities(report::read_result(left.summary()), report::read_result(right.summary()),
                       result);
    compare_curves(left.summary(), right.summary(), result);
  }
  return result;
}

}  // namespace

Contrast contrast(const std::string& left, const std::string& right) {
  for (const std::string& path : {left, right}) {
    std::error_code error;
    if (is_study(path) || fs::exists(path + "/result.json", error)) continue;
    throw Error::environment(fmt::format("'{}' is neither a run that has ended nor a study", path),
                             "name two run directories, or the folders of two studies");
  }
  if (is_study(left) != is_study(right)) {
    throw Error::environment("one of them is a study, the other a run",
                             "name two run directories, or the folders of two studies");
  }
  return is_study(left) ? contrast_of_studies(StudyDirectory(left), StudyDirectory(right))
                        : contrast_of_runs(left, right);
}

}  // namespace sandglass::study
