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
  /// Shows `candidates` the points whose squared distance is less than its worstDist(), those near
  /// `at` first.
  template <class Candidates>
  void search(const Point& at, Candidates& candidates) const {
    index_.findNeighbors(candidates, at.data(), nanoflann::SearchParams());
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
    middles.reserve(surface.cells.size() / corners_);
    numbers_.reserve(surface.cells.size());
    corner_.reserve(surface.cells.size());
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

  /// Distance to the nearest place of any cell; `entries` become the corners of that cell.
  double nearest(const Point& at, std::span<Mapping::Entry> entries) const {
    Candidates candidates(*this, at);
    tree_->search(at, candidates);
    for (std::size_t k = 0; k < corners_; ++k)
      entries[k] = {numbers_[candidates.cell * corners_ + k], candidates.weights[k]};
    return candidates.distance;
  }

 private:
  /// What a search for the nearest cell has found: the nearest one so far bounds how far away the
  /// middle of a nearer one can be, by its distance and the largest radius. For nanoflann, which
  /// wants these names.
  struct Candidates {
    Candidates(const Cells& all, const Point& place) : cells(all), at(place) {}

    bool addPoint(double square, std::size_t other) {
      if (square > reach) return true;  // no longer near enough
      std::array<double, 3> found{};
      const double one = project(
          at, std::span(cells.corner_).subspan(other * cells.corners_, cells.corners_), found);
      // Of equally near cells the first, however the tree is built.
      if (one < distance || (one == distance && other < cell)) {
        cell = other;
        distance = one;
        weights = found;
        // A hair further, so that rounding loses no cell.
        reach = (distance + cells.radius_) * (distance + cells.radius_) * (1 + 1e-11);
      }
      return distance > 1e-14 * cells.radius_;  // in the cell: none is nearer
    }
    [[nodiscard]] double worstDist() const { return reach; }
    [[nodiscard]] bool full() const { return true; }

    const Cells& cells;
    const Point& at;
    std::size_t cell = 0;
    double distance = std::numeric_limits<double>::infinity();
    double reach = std::numeric_limits<double>::infinity();  // squared
    std::array<double, 3> weights{};
  };

  std::size_t corners_;
  std::vector<std::size_t> numbers_;
  std::vector<Point> corner_;
  double radius_ = 0;
  std::unique_ptr<Tree> tree_;
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
  std::vector<std::uint64_t> codes(count);  // and below each, the number of its point
  for (std::size_t i = 0; i < count; ++i) {
    const Point at = point_at(points, dimension, i);
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const double share = high[k] > low[k] ? (at[k] - low[k]) / (high[k] - low[k]) : 0;
      const auto place =
          static_cast<std::uint64_t>(std::clamp(share, 0.0, 1.0) * ((1 << levels) - 1));
      for (int bit = 0; bit < levels; ++bit) code |= (place >> bit & 1U) << (3 * bit + k);
    }
    codes[i] = code << (64 - 3 * levels) | i;
  }
  std::sort(codes.begin(), codes.end());
  std::vector<std::size_t> order(count);
  std::transform(codes.begin(), codes.end(), order.begin(), [](std::uint64_t code) {
    return code & ((std::uint64_t{1} << (64 - 3 * levels)) - 1);
  });
  return order;
}

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
  if (count == 0) return;
  std::unique_ptr<Tree> tree;
  std::unique_ptr<Cells> cells;
  if (method == MappingMethod::linear) {
    cells = std::make_unique<Cells>(surface);
    corners_ = static_cast<std::size_t>(surface.corners);
  } else {
    std::vector<Point> all(surface_points_);
    for (std::size_t i = 0; i < all.size(); ++i)
      all[i] = point_at(surface.points, surface.dimension, i);
    tree = std::make_unique<Tree>(std::move(all));
  }
  entries_.resize(count * corners_);
  std::vector<double> distances(count);
  const std::vector<std::size_t> order = in_order_of_place(points, surface.dimension);
  for (std::size_t turn = 0; turn < count; ++turn) {
    // These lie anywhere in memory, which is asked for them ahead of time.
    const std::size_t soon = order[std::min(turn + 8, count - 1)];
    __builtin_prefetch(&points[soon * dimension]);
    __builtin_prefetch(&entries_[soon * corners_], 1);
    __builtin_prefetch(&distances[soon], 1);
    const std::size_t i = order[turn];
    const Point at = point_at(points, surface.dimension, i);
    if (cells) {
      distances[i] = cells->nearest(at, std::span(entries_).subspan(i * corners_, corners_));
    } else {
      std::tie(entries_[i].number, distances[i]) = tree->nearest(at);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!(distances[i] <= limit)) {
      throw Error::participant(
          fmt::format("point {} at ({:.6g}) m is {:.6g} m from the interface it is mapped to", i,
                      fmt::join(points.subspan(i * dimension, dimension), ", "), distances[i]),
          fmt::format(
              "the mapping's limit is {:.6g} m: the interfaces do not lie on each other, or "
              "the limit is too small",
              limit));
    }
  }
}

std::vector<double> Mapping::consistent(std::span<const double> values,
                                        std::int64_t components) const {
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> result(points() * width, 0.0);
  for (std::size_t i = 0; i < points(); ++i)
    for (const auto& [number, weight] : std::span(entries_).subspan(i * corners_, corners_))
      for (std::size_t k = 0; k < width; ++k)
        result[i * width + k] += weight * values[number * width + k];
  return result;
}

std::vector<double> Mapping::conservative(std::span<const double> values,
                                          std::int64_t components) const {
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> result(surface_points_ * width, 0.0);
  for (std::size_t i = 0; i < points(); ++i)
    for (const auto& [number, weight] : std::span(entries_).subspan(i * corners_, corners_))
      for (std::size_t k = 0; k < width; ++k)
        result[number * width + k] += weight * values[i * width + k];
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
