#include "grid.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace sandglass::mpm {
namespace {

// A point on the outer boundary is inside, also when rounding says otherwise.
constexpr double kRounding = 1e-10;

}  // namespace

template <int D>
BoxGrid<D>::BoxGrid(const Vector<D>& origin, const Vector<D>& size, const std::array<int, D>& cells)
    : origin_(origin), cells_(cells) {
  std::size_t count = 1;
  for (int k = 0; k < D; ++k) {
    if (cells[k] < 1 || !(size[k] > 0))
      throw std::invalid_argument("a grid needs cells and a size");
    spacing_[k] = size[k] / cells[k];
    count *= static_cast<std::size_t>(cells[k] + 1);
  }
  nodes_.resize(count);
  for (std::size_t n = 0; n < count; ++n) {
    std::size_t rest = n;
    for (int k = 0; k < D; ++k) {
      const auto along = static_cast<std::size_t>(cells[k] + 1);
      nodes_[n][k] = origin[k] + spacing_[k] * static_cast<double>(rest % along);
      rest /= along;
    }
  }
}

template <int D>
bool BoxGrid<D>::shape(const Vector<D>& point, int& cell, Shape<D>& result) const {
  std::array<double, D> local{};  // 0 to 1 in the cell
  int first = 0, number = 0;      // node at the cell's origin; the cell
  int stride = 1, cell_stride = 1;
  std::array<int, D> strides{};
  for (int k = 0; k < D; ++k) {
    const double at = (point[k] - origin_[k]) / spacing_[k];
    if (!(at >= -kRounding && at <= cells_[k] + kRounding)) return false;
    const int index = std::clamp(static_cast<int>(std::floor(at)), 0, cells_[k] - 1);
    local[k] = at - index;
    first += index * stride;
    number += index * cell_stride;
    strides[k] = stride;
    stride *= cells_[k] + 1;
    cell_stride *= cells_[k];
  }
  cell = number;
  result.count = 1 << D;
  for (int corner = 0; corner < (1 << D); ++corner) {
    int node = first;
    double value = 1;
    for (int k = 0; k < D; ++k) {
      const bool far = (corner >> k) & 1;
      if (far) node += strides[k];
      value *= far ? local[k] : 1 - local[k];
    }
    result.node[corner] = node;
    result.value[corner] = value;
    for (int k = 0; k < D; ++k) {
      double slope = ((corner >> k) & 1 ? 1 : -1) / spacing_[k];
      for (int j = 0; j < D; ++j) {
        if (j != k) slope *= (corner >> j) & 1 ? local[j] : 1 - local[j];
      }
      result.gradient[corner][k] = slope;
    }
  }
  return true;
}

template class BoxGrid<2>;
template class BoxGrid<3>;

TriangleGrid::TriangleGrid(std::vector<Vector<2>> nodes, std::vector<std::array<int, 3>> triangles)
    : nodes_(std::move(nodes)), triangles_(std::move(triangles)) {
  if (triangles_.empty()) throw std::invalid_argument("a grid needs triangles");
  std::map<std::pair<int, int>, std::pair<int, int>> edges;  // to triangle and opposite corner
  neighbours_.assign(triangles_.size(), {-1, -1, -1});
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (const int node : triangles_[t]) {
      if (node < 0 || static_cast<std::size_t>(node) >= nodes_.size()) {
        throw std::invalid_argument("triangle " + std::to_string(t) +
                                    " has a corner that is no node");
      }
    }
    const auto& [a, b, c] = triangles_[t];
    const double area = (nodes_[b][0] - nodes_[a][0]) * (nodes_[c][1] - nodes_[a][1]) -
                        (nodes_[c][0] - nodes_[a][0]) * (nodes_[b][1] - nodes_[a][1]);
    if (!(area != 0)) throw std::invalid_argument("triangle " + std::to_string(t) + " has no area");
    for (int k = 0; k < 3; ++k) {
      const int from = triangles_[t][(k + 1) % 3];
      const int to = triangles_[t][(k + 2) % 3];
      const auto key = std::minmax(from, to);
      const auto [other, fresh] = edges.try_emplace(key, static_cast<int>(t), k);
      if (fresh) continue;
      neighbours_[t][k] = other->second.first;
      neighbours_[other->second.first][other->second.second] = static_cast<int>(t);
    }
  }
}

double TriangleGrid::fill(int t, const Vector<2>& point, Shape<2>& result) const {
  const auto& [a, b, c] = triangles_[t];
  const Vector<2>&p = nodes_[a], &q = nodes_[b], &r = nodes_[c];
  const double area = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
  result.count = 3;
  result.node = {a, b, c, 0};
  result.gradient[0] = {(q[1] - r[1]) / area, (r[0] - q[0]) / area};
  result.gradient[1] = {(r[1] - p[1]) / area, (p[0] - r[0]) / area};
  result.gradient[2] = {(p[1] - q[1]) / area, (q[0] - p[0]) / area};
  for (int k = 1; k < 3; ++k) {
    result.value[k] =
        result.gradient[k][0] * (point[0] - p[0]) + result.gradient[k][1] * (point[1] - p[1]);
  }
  result.value[0] = 1 - result.value[1] - result.value[2];
  return std::min({result.value[0], result.value[1], result.value[2]});
}

bool TriangleGrid::shape(const Vector<2>& point, int& cell, Shape<2>& result) const {
  // Walks from triangle to triangle across the edge behind which the point lies; where a hole or a
  // re-entrant boundary is in the way, all triangles are looked at.
  const int count = static_cast<int>(triangles_.size());
  int at = cell >= 0 && cell < count ? cell : 0;
  for (int walked = 0; walked < count && at >= 0; ++walked) {
    if (fill(at, point, result) >= -kRounding) {
      cell = at;
      return true;
    }
    const auto lowest = std::min_element(result.value.begin(), result.value.begin() + 3);
    at = neighbours_[at][lowest - result.value.begin()];
  }
  for (int t = 0; t < count; ++t) {
    if (fill(t, point, result) >= -kRounding) {
      cell = t;
      return true;
    }
  }
  return false;
}

}  // namespace sandglass::mpm
