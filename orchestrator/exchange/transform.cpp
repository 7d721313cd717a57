#include "exchange/transform.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

namespace sandglass::exchange {
namespace {

double median_of(std::vector<double> column) {
  const auto middle = column.begin() + static_cast<std::ptrdiff_t>(column.size() / 2);
  std::nth_element(column.begin(), middle, column.end());
  if (column.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(column.begin(), middle));
}

double statistic(Transform transform, const std::vector<double>& column) {
  if (transform == Transform::sum) return std::accumulate(column.begin(), column.end(), 0.0);
  // A NaN must arrive as NaN: ordering it would drop it or put it anywhere.
  const bool undefined = column.empty() || std::any_of(column.begin(), column.end(),
                                                       [](double x) { return std::isnan(x); });
  if (undefined) return std::numeric_limits<double>::quiet_NaN();
  switch (transform) {
    case Transform::mean:
      return std::accumulate(column.begin(), column.end(), 0.0) /
             static_cast<double>(column.size());
    case Transform::minimum:
      return *std::min_element(column.begin(), column.end());
    case Transform::maximum:
      return *std::max_element(column.begin(), column.end());
    default:
      return median_of(column);
  }
}

std::size_t row_size(const std::vector<std::int64_t>& shape) {
  std::size_t size = 1;
  for (std::size_t axis = 1; axis < shape.size(); ++axis)
    size *= static_cast<std::size_t>(shape[axis]);
  return size;
}

std::vector<double> resample(std::span<const double> values, std::size_t from, std::size_t columns,
                             std::size_t to) {
  std::vector<double> result(to * columns, std::numeric_limits<double>::quiet_NaN());
  if (from == 0) return result;
  for (std::size_t i = 0; i < to; ++i) {
    // Whole products before the division: where a sample exists, it is hit exactly.
    const double time = static_cast<double>((i + 1) * from) / static_cast<double>(to);
    const double at = std::max(0.0, time - 1.0);
    const std::size_t low = std::min(static_cast<std::size_t>(at), from - 1);
    const std::size_t high = std::min(low + 1, from - 1);
    const double weight = at - static_cast<double>(low);
    for (std::size_t c = 0; c < columns; ++c) {
      const double below = values[low * columns + c];
      const double above = values[high * columns + c];
      result[i * columns + c] = weight == 0.0 ? below : below + weight * (above - below);
    }
  }
  return result;
}

}  // namespace

std::vector<std::int64_t> transformed_shape(Transform transform, std::vector<std::int64_t> shape,
                                            std::int64_t samples) {
  if (transform == Transform::identity || shape.empty()) return shape;
  if (transform == Transform::linear) {
    shape[0] = samples;
    return shape;
  }
  shape.erase(shape.begin());
  if (shape.empty()) shape.push_back(1);
  return shape;
}

std::vector<double> apply(Transform transform, std::span<const double> values,
                          const std::vector<std::int64_t>& shape, std::int64_t samples) {
  if (transform == Transform::identity || shape.empty()) return {values.begin(), values.end()};
  const auto rows = static_cast<std::size_t>(shape[0]);
  const std::size_t columns = row_size(shape);
  if (transform == Transform::linear) {
    return resample(values, rows, columns, static_cast<std::size_t>(samples));
  }
  std::vector<double> result(columns);
  std::vector<double> column(rows);
  for (std::size_t c = 0; c < columns; ++c) {
    for (std::size_t r = 0; r < rows; ++r) column[r] = values[r * columns + c];
    result[c] = statistic(transform, column);
  }
  return result;
}

}  // namespace sandglass::exchange
