#include "report/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "base/unit.hpp"
#include "workflow/json.hpp"

namespace sandglass::report {
namespace {

using workflow::Comparison;
using workflow::Metric;

/// Raised inside this file only: the comparison cannot be made in this run, which is no error.
struct Skip {
  std::string why;
};

std::string who(const Comparison& comparison) {
  const std::string place = comparison.place.text();
  return fmt::format("comparison '{}'{}", comparison.name,
                     place.empty() ? "" : fmt::format(" ({})", place));
}

template <typename Item>
const Item& find(const std::map<std::string, Item>& items, const std::string& name,
                 const char* what, const Comparison& comparison) {
  const auto found = items.find(name);
  if (found != items.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& item : items) known.push_back(item.first);
  throw Error::participant(fmt::format("{} asks for the {} '{}', which no analysis stage defines",
                                       who(comparison), what, name),
                           suggestion(name, known));
}

void check_unit(const Comparison& comparison, const std::string& name, const std::string& unit,
                const std::string& expected) {
  if (Unit::convertible(unit, expected)) return;
  throw Error::participant(fmt::format("{}: '{}' is in '{}' and cannot be compared in '{}'",
                                       who(comparison), name, unit, expected),
                           "correct the unit in the analysis or in the workflow");
}

double number_of(const Comparison& comparison, const Analysis& analysis, const std::string& name,
                 std::string& unit) {
  const Computed& computed = find(analysis.quantities, name, "quantity", comparison);
  if (unit.empty()) unit = computed.unit;
  check_unit(comparison, name, computed.unit, unit);
  if (computed.value.absent()) {
    throw Skip{fmt::format("'{}' is not defined in this run", name)};
  }
  if (const double* number = computed.value.as<double>()) return *number;
  throw Error::participant(fmt::format("{}: the quantity '{}' of analysis stage '{}' is a list",
                                       who(comparison), name, computed.stage),
                           "compare a single number, or make it a curve");
}

void compare_numbers(const Comparison& comparison, const Analysis& analysis,
                     ComparisonResult& result) {
  const double ours = number_of(comparison, analysis, comparison.quantity, result.unit);
  result.ours = ours;
  if (comparison.metric == Metric::value) {
    result.value = std::abs(ours);
    return;
  }
  double reference = 0;
  if (comparison.reference_value) {
    reference = *comparison.reference_value;
  } else {
    std::string unit = result.unit;
    reference = number_of(comparison, analysis, comparison.reference_quantity, unit);
  }
  result.reference = reference;
  const double difference = std::abs(ours - reference);
  result.value = comparison.metric == Metric::relative_difference ? difference / std::abs(reference)
                                                                  : difference;
}

Points points_of(const Comparison& comparison, const Analysis& analysis, const std::string& name,
                 ComparisonResult& result) {
  const Curve& curve = find(analysis.curves, name, "curve", comparison);
  if (result.unit.empty()) result.unit = curve.y.unit;
  check_unit(comparison, name, curve.y.unit, result.unit);
  const std::vector<double>& x = curve.x.values;
  // Written so that a NaN abscissa is caught too.
  for (size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || (i > 0 && !(x[i] > x[i - 1]))) {
      throw Error::participant(
          fmt::format("{}: curve '{}' of analysis stage '{}' has no ascending abscissae (value {})",
                      who(comparison), name, curve.stage, i + 1),
          "sort the points of the curve by x, each x once");
    }
  }
  return {x, curve.y.values};
}

void compare_curves(const Comparison& comparison, const Analysis& analysis,
                    const std::string& data_root, ComparisonResult& result) {
  const Points ours = points_of(comparison, analysis, comparison.curve, result);
  const Points reference =
      comparison.reference_file.empty()
          ? points_of(comparison, analysis, comparison.reference_curve, result)
          : read_reference((std::filesystem::path(data_root) / comparison.reference_file).string());
  if (ours.x.empty()) {
    throw Skip{fmt::format("curve '{}' has no points in this run", comparison.curve)};
  }
  if (reference.x.empty()) {
    throw Skip{fmt::format("the reference curve '{}' has no points", result.against)};
  }
  const Difference difference = difference_of_curves(ours, reference);
  if (difference.values.empty()) {
    throw Skip{
        fmt::format("the curves have no abscissa in common: ours lies in {} to {}, the "
                    "reference in {} to {}",
                    ours.x.front(), ours.x.back(), reference.x.front(), reference.x.back())};
  }
  double largest = 0;
  double squares = 0;
  for (const double value : difference.values) {
    squares += value * value;
    // std::max would lose a NaN.
    if (std::isnan(value) || std::abs(value) > largest) largest = std::abs(value);
    if (std::isnan(largest)) break;
  }
  const auto count = static_cast<double>(difference.values.size());
  result.value =
      comparison.metric == Metric::maximum_difference ? largest : std::sqrt(squares / count);
  result.points = static_cast<std::int64_t>(difference.values.size());
  result.from = difference.from;
  result.to = difference.to;
}

ComparisonResult compare_one(const Comparison& comparison, const Analysis& analysis,
                             const std::string& data_root) {
  ComparisonResult result;
  result.name = comparison.name;
  result.metric = name_of(comparison.metric);
  result.tolerance = comparison.tolerance;
  result.because = comparison.because;
  result.source = comparison.source;
  result.shown_in = comparison.unit;
  result.subject = comparison.quantity.empty() ? comparison.curve : comparison.quantity;
  for (const std::string* name :
       {&comparison.reference_quantity, &comparison.reference_curve, &comparison.reference_file}) {
    if (!name->empty()) result.against = *name;
  }
  result.reference = comparison.reference_value;

  const bool of_curves = comparison.metric == Metric::maximum_difference ||
                         comparison.metric == Metric::root_mean_square;
  if (of_curves == comparison.curve.empty()) {
    throw Error::refused(
        comparison.place,
        fmt::format("comparison '{}': '{}' does not fit a {}", comparison.name, result.metric,
                    comparison.curve.empty() ? "quantity" : "curve"));
  }
  try {
    // A misspelt name is an error also in a run in which the comparison would be skipped.
    if (of_curves)
      find(analysis.curves, comparison.curve, "curve", comparison);
    else
      find(analysis.quantities, comparison.quantity, "quantity", comparison);
    std::string departs;
    for (const workflow::HoldsFor& condition : comparison.holds_for) {
      if (condition.met) continue;
      departs += fmt::format("{}{} departs from {}", departs.empty() ? "" : "; ",
                             condition.parameter, condition.text);
    }
    if (!departs.empty()) throw Skip{departs};
    if (of_curves)
      compare_curves(comparison, analysis, data_root, result);
    else
      compare_numbers(comparison, analysis, result);
    result.passed = *result.value <= result.tolerance;  // false for NaN
    // A workflow that gives no unit is shown in that of its tolerance, which may be "%".
    if (!Unit::convertible(result.unit, result.shown_in)) {
      if (comparison.metric != Metric::relative_difference) {
        check_unit(comparison, result.subject, result.unit, result.shown_in);
      }
      result.shown_in = result.unit;
    }
  } catch (const Skip& skip) {
    result.skipped = skip.why;
    result.value.reset();
  }
  return result;
}

}  // namespace

std::vector<ComparisonResult> compare(const workflow::Workflow& workflow, const Analysis& analysis,
                                      const std::string& data_root) {
  std::vector<ComparisonResult> results;
  for (const Comparison& comparison : workflow.comparisons) {
    results.push_back(compare_one(comparison, analysis, data_root));
  }
  return results;
}

ExitCode verdict(const std::vector<ComparisonResult>& comparisons) {
  const bool all = std::all_of(comparisons.begin(), comparisons.end(),
                               [](const ComparisonResult& one) { return one.passed != false; });
  return all ? ExitCode::done : ExitCode::mismatch;
}

}  // namespace sandglass::report
