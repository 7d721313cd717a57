#include "exchange/mapping.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nanoflann.hpp>
#include <tuple>

#include "base/error.hpp"

namespace sandglass::exchange {
namespace {

using Point = std::array<double, 3>;  // the third coordinate is 0 in two dimensions

Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Point point_at(std::span<const double> points, int dimension, std::size_t i) {
  Point result{};
  for (int k = 0; k < dimension; ++k)
    result[k] = points[i * static_cast<std::size_t>(dimension) + k];
  return result;
}

/// Points as nanoflann wants to see them.
struct Cloud {
  std::vector<Point> points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t k) const { return points[i][k]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

class Tree {
 public:
  explicit Tree(std::vector<Point> points)
      : cloud_{std::move(points)},
        index_(3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}

  [[nodiscard]] std::pair<std::size_t, double> nearest(const Point& at) const {
    std::size_t number = 0;
    double square = 0;
    index_.knnSearch(at.data(), 1, &number, &square);
    return {number, std::sqrt(square)};
  }
  /// Numbers of all points up to `radius` away.
  void within(const Point& at, double radius,
              std::vector<std::pair<std::size_t, double>>& found) const {
    nanoflann::SearchParams unsorted;
    unsorted.sorted = false;
    index_.radiusSearch(at.data(), radius * radius, found, unsorted);
  }

 private:
  Cloud cloud_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3,
                                      std::size_t>
      index_;
};

/// Weights of the corners for the point of the cell next to p, and its distance.
double project(const Point& p, std::span<const Point> corners, std::array<double, 3>& weights) {
  const Point& a = corners[0];
  const Point ab = corners[1] - a, ap = p - a;
  if (corners.size() == 2) {
    const double length = dot(ab, ab);
    const double share = length > 0 ? std::clamp(dot(ap, ab) / length, 0.0, 1.0) : 0.0;
    weights = {1 - share, share, 0};
  } else {
    // The regions of a triangle: corner, edge or face (C. Ericson, Real-Time Collision Detection,
    // 2005, 5.1.5).
    const Point ac = corners[2] - a, bp = p - corners[1], cp = p - corners[2];
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp);
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0 && d2 <= 0) {
      weights = {1, 0, 0};
    } else if (d3 >= 0 && d4 <= d3) {
      weights = {0, 1, 0};
    } else if (d6 >= 0 && d5 <= d6) {
      weights = {0, 0, 1};
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
      const double share = d1 / (d1 - d3);
      weights = {1 - share, share, 0};
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
      const double share = d2 / (d2 - d6);
      weights = {1 - share, 0, share};
    } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
      const double share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
      weights = {0, 1 - share, share};
    } else {
      const double sum = va + vb + vc;
      weights = {va / sum, vb / sum, vc / sum};
      weights[0] = 1 - weights[1] - weights[2];
    }
  }
  Point foot{};
  for (std::size_t c = 0; c < corners.size(); ++c)
    for (int k = 0; k < 3; ++k) foot[k] += weights[c] * corners[c][k];
  const Point away = p - foot;
  return std::sqrt(dot(away, away));
}

/// A surface's cells, by the middles of the balls around them.
class Cells {
 public:
  explicit Cells(const Interface& surface) : corners_(static_cast<std::size_t>(surface.corners)) {
    const std::size_t points = surface.count();
    if (corners_ < 2 || corners_ > 3 || surface.cells.size() % corners_ != 0 ||
        surface.cells.empty()) {
      throw Error::participant(
          "a linear mapping needs cells of 2 (segments) or 3 (triangles) points",
          fmt::format("{} numbers were given, {} to a cell", surface.cells.size(), corners_));
    }
    std::vector<Point> middles;
    for (std::size_t c = 0; c < surface.cells.size(); c += corners_) {
      Point middle{};
      for (std::size_t k = 0; k < corners_; ++k) {
        const std::int64_t number = surface.cells[c + k];
        if (number < 0 || static_cast<std::size_t>(number) >= points) {
          throw Error::participant(
              fmt::format("cell {} of an interface names point {}", c / corners_, number),
              fmt::format("there are {} points, counted from 0", points));
        }
        numbers_.push_back(static_cast<std::size_t>(number));
        corner_.push_back(point_at(surface.points, surface.dimension, numbers_.back()));
        for (int i = 0; i < 3; ++i) middle[i] += corner_.back()[i] / static_cast<double>(corners_);
      }
      for (std::size_t k = 0; k < corners_; ++k) {
        const Point away = corner_[c + k] - middle;
        radius_ = std::max(radius_, std::sqrt(dot(away, away)));
      }
      middles.push_back(middle);
    }
    tree_ = std::make_unique<Tree>(std::move(middles));
  }

  /// The nearest place of any cell, with the numbers and weights of its corners.
  double nearest(const Point& at, std::span<const std::size_t>& numbers,
                 std::array<double, 3>& weights) {
    // The cell with the nearest middle bounds the distance; none whose middle is further than that
    // and the largest radius can be nearer.
    std::size_t best = tree_->nearest(at).first;
    double distance = distance_to(at, best, weights);
    numbers = std::span(numbers_).subspan(best * corners_, corners_);
    if (distance <= 1e-14 * radius_) return distance;  // in the cell: none is nearer
    // A hair further, so that rounding loses no cell.
    tree_->within(at, (distance + radius_) * (1 + 1e-12), found_);
    std::array<double, 3> other{};
    for (const auto& [cell, square] : found_) {
      const double reach = distance + radius_;
      if (cell == best || square > reach * reach * (1 + 1e-11)) continue;  // no longer near enough
      const double one = distance_to(at, cell, other);
      // Of equally near cells the first, however the tree is built.
      if (one < distance || (one == distance && cell < best)) {
        best = cell;
        distance = one;
        weights = other;
      }
    }
    numbers = std::span(numbers_).subspan(best * corners_, corners_);
    return distance;
  }

 private:
  double distance_to(const Point& at, std::size_t cell, std::array<double, 3>& weights) const {
    return project(at, std::span(corner_).subspan(cell * corners_, corners_), weights);
  }

  std::size_t corners_;
  std::vector<std::size_t> numbers_;
  std::vector<Point> corner_;
  double radius_ = 0;
  std::unique_ptr<Tree> tree_;
  std::vector<std::pair<std::size_t, double>> found_;
};

/// Numbers of points, those near each other one after the other (along Morton's curve): what the
/// search for one has read is then still in the cache for the next.
std::vector<std::size_t> in_order_of_place(std::span<const double> points, int dimension) {
  constexpr int levels = 10;  // of halving, along each axis
  const std::size_t count = points.size() / static_cast<std::size_t>(dimension);
  Point low{}, high{};
  for (int k = 0; k < 3; ++k) {
    low[k] = std::numeric_limits<double>::max();
    high[k] = std::numeric_limits<double>::lowest();
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Point at = point_at(points, dimension, i);
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], at[k]);
      high[k] = std::max(high[k], at[k]);
    }
  }
  std::vector<std::pair<std::uint32_t, std::size_t>> codes(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Point at = point_at(points, dimension, i);
    std::uint32_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const double share = high[k] > low[k] ? (at[k] - low[k]) / (high[k] - low[k]) : 0;
      const auto place =
          static_cast<std::uint32_t>(std::clamp(share, 0.0, 1.0) * ((1 << levels) - 1));
      for (int bit = 0; bit < levels; ++bit) code |= (place >> bit & 1U) << (3 * bit + k);
    }
    codes[i] = {code, i};
  }
  std::sort(codes.begin(), codes.end());
  std::vector<std::size_t> order(count);
  std::transform(codes.begin(), codes.end(), order.begin(),
                 [](const auto& one) { return one.second; });
  return order;
}

/// Where a point lies on a surface.
struct Place {
  std::array<std::size_t, 3> numbers{};
  std::array<double, 3> weights{};
  std::size_t corners = 0;
  double distance = 0;
};

}  // namespace

Mapping::Mapping(MappingMethod method, const Interface& surface, std::span<const double> points,
                 double limit)
    : surface_points_(surface.count()) {
  const auto dimension = static_cast<std::size_t>(surface.dimension);
  if (dimension < 2 || dimension > 3 || points.size() % dimension != 0) {
    throw Error::participant(
        "points of a mapping must have 2 or 3 coordinates, alike on both sides",
        "send them as [points, 2] or [points, 3]");
  }
  const std::size_t count = points.size() / dimension;
  if (count > 0 && surface_points_ == 0) {
    throw Error::participant(
        fmt::format("{} points are to be mapped to an interface without points", count),
        "its participant must send points");
  }
  begins_.reserve(count + 1);
  std::unique_ptr<Tree> tree;
  std::unique_ptr<Cells> cells;
  if (count > 0 && method == MappingMethod::linear) {
    cells = std::make_unique<Cells>(surface);
  } else if (count > 0) {
    std::vector<Point> all(surface_points_);
    for (std::size_t i = 0; i < all.size(); ++i)
      all[i] = point_at(surface.points, surface.dimension, i);
    tree = std::make_unique<Tree>(std::move(all));
  }
  std::vector<Place> places(count);
  for (const std::size_t i : in_order_of_place(points, surface.dimension)) {
    const Point at = point_at(points, surface.dimension, i);
    Place& place = places[i];
    if (cells) {
      std::span<const std::size_t> numbers;
      place.distance = cells->nearest(at, numbers, place.weights);
      place.corners = numbers.size();
      std::copy(numbers.begin(), numbers.end(), place.numbers.begin());
    } else {
      std::tie(place.numbers[0], place.distance) = tree->nearest(at);
      place.weights[0] = 1;
      place.corners = 1;
    }
  }
  const std::size_t most = count * (cells ? static_cast<std::size_t>(surface.corners) : 1);
  numbers_.reserve(most);
  weights_.reserve(most);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [numbers, weights, corners, distance] = places[i];
    add(std::span(numbers).first(corners), std::span(weights).first(corners), distance);
    if (!(distance <= limit)) {
      throw Error::participant(
          fmt::format("point {} at ({:.6g}) m is {:.6g} m from the interface it is mapped to", i,
                      fmt::join(points.subspan(i * dimension, dimension), ", "), distance),
          fmt::format(
              "the mapping's limit is {:.6g} m: the interfaces do not lie on each other, or "
              "the limit is too small",
              limit));
    }
  }
}

void Mapping::add(std::span<const std::size_t> numbers, std::span<const double> weights,
                  double distance) {
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (weights[k] == 0) continue;
    numbers_.push_back(numbers[k]);
    weights_.push_back(weights[k]);
  }
  begins_.push_back(numbers_.size());
  distance_ = std::max(distance_, distance);
}

std::vector<double> Mapping::consistent(std::span<const double> values,
                                        std::int64_t components) const {
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> result(points() * width, 0.0);
  for (std::size_t i = 0; i < points(); ++i)
    for (std::size_t e = begins_[i]; e < begins_[i + 1]; ++e)
      for (std::size_t k = 0; k < width; ++k)
        result[i * width + k] += weights_[e] * values[numbers_[e] * width + k];
  return result;
}

std::vector<double> Mapping::conservative(std::span<const double> values,
                                          std::int64_t components) const {
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> result(surface_points_ * width, 0.0);
  for (std::size_t i = 0; i < points(); ++i)
    for (std::size_t e = begins_[i]; e < begins_[i + 1]; ++e)
      for (std::size_t k = 0; k < width; ++k)
        result[numbers_[e] * width + k] += weights_[e] * values[i * width + k];
  return result;
}

std::vector<std::int64_t> chain(std::size_t points) {
  std::vector<std::int64_t> cells;
  for (std::size_t i = 0; i + 1 < points; ++i) {
    cells.push_back(static_cast<std::int64_t>(i));
    cells.push_back(static_cast<std::int64_t>(i + 1));
  }
  return cells;
}

}  // namespace sandglass::exchange
