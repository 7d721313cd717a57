#pragma once

#include <array>
#include <memory>
#include <vector>

/// The material point method, without FreeFEM: background grids, laws, and a body of material
/// points (D. Sulsky, Z. Chen, H. L. Schreyer, Comput. Methods Appl. Mech. Eng. 118, 1994, 179).
/// SI units throughout; `D` is the number of dimensions, 2 or 3.
namespace sandglass::mpm {

template <int D>
using Vector = std::array<double, D>;

/// The nodes of one cell, as seen from a point in it: values and gradients of their shape
/// functions. The values add up to 1.
template <int D>
struct Shape {
  int count = 0;
  std::array<int, 1 << D> node{};
  std::array<double, 1 << D> value{};
  std::array<Vector<D>, 1 << D> gradient{};  ///< 1/m
};

/// A background grid that does not move.
template <int D>
class Grid {
 public:
  virtual ~Grid() = default;
  [[nodiscard]] virtual const std::vector<Vector<D>>& nodes() const = 0;  ///< positions in m
  /// Fills the shape functions at `point` and the number of its cell, which also tells where to
  /// begin to look. Returns false for a point outside.
  virtual bool shape(const Vector<D>& point, int& cell, Shape<D>& result) const = 0;
};

/// Equal rectangles or boxes, with linear shape functions along every axis. Nodes are numbered
/// along x first.
template <int D>
class BoxGrid : public Grid<D> {
 public:
  /// Throws std::invalid_argument unless there are cells of a positive size.
  BoxGrid(const Vector<D>& origin, const Vector<D>& size, const std::array<int, D>& cells);
  [[nodiscard]] const std::vector<Vector<D>>& nodes() const override { return nodes_; }
  bool shape(const Vector<D>& point, int& cell, Shape<D>& result) const override;

 private:
  Vector<D> origin_;
  Vector<D> spacing_;
  std::array<int, D> cells_;
  std::vector<Vector<D>> nodes_;
};

/// Any mesh of triangles with linear shape functions.
class TriangleGrid : public Grid<2> {
 public:
  /// Throws std::invalid_argument for a corner that is no node and for a triangle without area.
  TriangleGrid(std::vector<Vector<2>> nodes, std::vector<std::array<int, 3>> triangles);
  [[nodiscard]] const std::vector<Vector<2>>& nodes() const override { return nodes_; }
  bool shape(const Vector<2>& point, int& cell, Shape<2>& result) const override;

 private:
  /// Shape functions of triangle `t`; the smallest of their values.
  double fill(int t, const Vector<2>& point, Shape<2>& result) const;

  std::vector<Vector<2>> nodes_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::array<int, 3>> neighbours_;  ///< across the edge opposite each corner, or -1
};

}  // namespace sandglass::mpm
