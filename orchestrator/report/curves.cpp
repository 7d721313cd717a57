// Reading and subtracting curves, for compare.hpp.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "base/file.hpp"
#include "report/compare.hpp"

namespace sandglass::report {
namespace {

std::string trimmed(std::string text) {
  const size_t first = text.find_first_not_of(" \t\r\"");
  if (first == std::string::npos) return {};
  text = text.substr(first, text.find_last_not_of(" \t\r\"") - first + 1);
  return text;
}

struct Cell {
  std::string text;
  int column = 1;  ///< where it starts in the line
};

std::vector<Cell> split(const std::string& line) {
  std::vector<Cell> cells;
  for (size_t begin = 0; begin <= line.size();) {
    const size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back({trimmed(line.substr(begin, end - begin)), static_cast<int>(begin) + 1});
    begin = end + 1;
  }
  return cells;
}

bool parse(const std::string& text, double& number) {
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && rest == end && std::isfinite(number);
}

}  // namespace

Points read_reference(const std::string& path) {
  const std::string text = read_file(path);
  std::istringstream lines(text);
  Points points;
  bool header = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
    const std::vector<Cell> cells = split(line);
    if (cells.size() < 2) {
      throw Error::refused({path, number, 1}, "a row with one column only",
                           "a reference has the columns x and y, separated by commas");
    }
    double x = 0;
    double y = 0;
    if (!header) {
      if (parse(cells[0].text, x) && parse(cells[1].text, y)) {
        throw Error::refused({path, number, 1}, "numbers where the header row should stand",
                             "name the columns in the first row, for example \"time,velocity\"");
      }
      header = true;
      continue;
    }
    for (size_t i = 0; i < 2; ++i) {
      if (!parse(cells[i].text, i == 0 ? x : y)) {
        throw Error::refused({path, number, cells[i].column},
                             fmt::format("'{}' is not a number", cells[i].text),
                             "write a finite number in SI");
      }
    }
    if (!points.x.empty() && !(x > points.x.back())) {
      throw Error::refused({path, number, cells[0].column},
                           fmt::format("the abscissa {} does not ascend (the row before has {})", x,
                                       points.x.back()),
                           "sort the rows by the first column, each value once");
    }
    points.x.push_back(x);
    points.y.push_back(y);
  }
  if (points.x.empty()) {
    throw Error::refused({path}, "no rows of numbers",
                         "a reference has a header row and then x,y in every row");
  }
  return points;
}

void check_references(const workflow::Workflow& workflow, const std::string& data_root) {
  for (const workflow::Comparison& one : workflow.comparisons) {
    if (!one.reference_file.empty()) read_reference(data_root + "/" + one.reference_file);
  }
}

Difference difference_of_curves(const Points& ours, const Points& reference) {
  Difference difference;
  if (reference.x.empty()) return difference;
  for (size_t i = 0; i < ours.x.size(); ++i) {
    const double x = ours.x[i];
    if (x < reference.x.front() || x > reference.x.back()) continue;
    const auto above = std::lower_bound(reference.x.begin(), reference.x.end(), x);
    const auto k = static_cast<size_t>(above - reference.x.begin());
    double value = reference.y[k];
    // At a point of the reference its own value is taken, whatever stands before it.
    if (reference.x[k] != x) {
      const double share = (x - reference.x[k - 1]) / (reference.x[k] - reference.x[k - 1]);
      value = (1 - share) * reference.y[k - 1] + share * reference.y[k];
    }
    if (difference.values.empty()) difference.from = x;
    difference.to = x;
    difference.values.push_back(ours.y[i] - value);
  }
  return difference;
}

}  // namespace sandglass::report
