#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sandglass::exchange {

/// Points of an interface, and how they are joined.
struct Interface {
  int dimension = 0;                ///< coordinates of a point, 2 or 3
  std::vector<double> points;       ///< [n, dimension], row-major, m
  int corners = 0;                  ///< of a cell: 2 for segments, 3 for triangles
  std::vector<std::int64_t> cells;  ///< [m, corners], row-major; numbers of points

  [[nodiscard]] std::size_t count() const {
    return dimension == 0 ? 0 : points.size() / static_cast<std::size_t>(dimension);
  }
};

enum class MappingMethod {
  nearest,  ///< the value of the nearest point
  linear    ///< barycentric in the nearest place of the nearest cell
};

/// Values between the points of an interface and other points on or near it, which need not
/// coincide.
///
/// It is made for a surface (points, and cells for `linear`) and the other points. `consistent`
/// interpolates values of the surface's points at the other points: constants, and with `linear`
/// linear fields on the surface, are exact. `conservative` is its transpose: it shares out what is
/// given at the other points to the surface's points, so that sums are kept and, with `linear` and
/// points on the surface, moments too. Displacement and velocity go one way, forces the other.
class Mapping {
 public:
  /// What a point of the surface has to do with one of the other points.
  struct Entry {
    std::size_t number = 0;
    double weight = 1;
  };

  /// `limit` is the longest distance (m) from one of the points to the surface. Throws
  /// Error::participant naming the point that is further away, or the cell that is none.
  Mapping(MappingMethod method, const Interface& surface, std::span<const double> points,
          double limit);

  /// [surface points, components] to [points, components].
  [[nodiscard]] std::vector<double> consistent(std::span<const double> values,
                                               std::int64_t components) const;
  /// [points, components] to [surface points, components].
  [[nodiscard]] std::vector<double> conservative(std::span<const double> values,
                                                 std::int64_t components) const;
  [[nodiscard]] std::size_t points() const { return entries_.size() / corners_; }

 private:
  std::size_t surface_points_ = 0;
  std::size_t corners_ = 1;     ///< of the cell that a point lies in, or its nearest point alone
  std::vector<Entry> entries_;  ///< [points, corners]
};

/// Segments that join points in their order: the cells of a line without branches.
std::vector<std::int64_t> chain(std::size_t points);

}  // namespace sandglass::exchange
