#include "coupling/quasi_newton.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sandglass::coupling {
namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// The most columns that are worth their time.
constexpr std::size_t most_columns = 100;

}  // namespace

void QuasiNewton::step(std::vector<double>& x, std::span<const double> next,
                       std::span<const double> weights) {
  const std::size_t size = x.size();
  if (next.size() != size) {
    x.assign(next.begin(), next.end());
    columns_.clear();
    last_residual_.clear();
    return;
  }
  std::vector<double> residual(size);
  for (std::size_t i = 0; i < size; ++i) residual[i] = next[i] - x[i];
  if (!columns_.empty() && columns_.front().residual.size() != size) columns_.clear();
  if (last_residual_.size() == size) {
    Column column{std::vector<double>(size), std::vector<double>(size), window_};
    for (std::size_t i = 0; i < size; ++i) {
      column.residual[i] = residual[i] - last_residual_[i];
      column.value[i] = next[i] - last_value_[i];
    }
    columns_.insert(columns_.begin(), std::move(column));
    if (columns_.size() > most_columns) columns_.pop_back();
  }
  last_residual_ = residual;
  last_value_.assign(next.begin(), next.end());
  const std::vector<double> parts = combination(residual, weights);
  if (parts.empty()) {
    for (std::size_t i = 0; i < size; ++i) x[i] += factor_ * residual[i];
    return;
  }
  x.assign(next.begin(), next.end());
  for (std::size_t c = 0; c < parts.size(); ++c)
    for (std::size_t i = 0; i < size; ++i) x[i] += parts[c] * columns_[c].value[i];
}

std::vector<double> QuasiNewton::combination(const std::vector<double>& residual,
                                             std::span<const double> weights) {
  // Gram-Schmidt with every projection twice: as orthogonal as Householder's, and a column can be
  // dropped as soon as it is seen to add nothing.
  std::vector<std::vector<double>> q;
  std::vector<std::vector<double>> r;  // r[c]: column c of the triangle
  std::vector<Column> kept;
  for (Column& column : columns_) {
    std::vector<double> v(column.residual.size());
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = weights[i] * column.residual[i];
    const double length = std::sqrt(dot(v, v));
    std::vector<double> above(q.size(), 0.0);
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t c = 0; c < q.size(); ++c) {
        const double along = dot(q[c], v);
        above[c] += along;
        for (std::size_t i = 0; i < v.size(); ++i) v[i] -= along * q[c][i];
      }
    }
    const double rest = std::sqrt(dot(v, v));
    if (!(rest > filter_ * length) || q.size() == v.size()) continue;
    for (double& entry : v) entry /= rest;
    above.push_back(rest);
    q.push_back(std::move(v));
    r.push_back(std::move(above));
    kept.push_back(std::move(column));
  }
  columns_ = std::move(kept);
  std::vector<double> parts(q.size());
  for (std::size_t c = q.size(); c-- > 0;) {
    double right = 0;
    for (std::size_t i = 0; i < residual.size(); ++i) right -= q[c][i] * weights[i] * residual[i];
    for (std::size_t later = c + 1; later < q.size(); ++later) right -= r[later][c] * parts[later];
    parts[c] = right / r[c][c];
  }
  return parts;
}

void QuasiNewton::new_window() {
  ++window_;
  last_residual_.clear();
  last_value_.clear();
  std::erase_if(columns_,
                [&](const Column& one) { return one.window < window_ - reused_windows_; });
}

void QuasiNewton::remember(Memory& memory, const std::string& name) {
  memory(name + ".window", window_);
  auto count = static_cast<std::int64_t>(columns_.size());
  memory(name + ".columns", count);
  columns_.resize(static_cast<std::size_t>(count));
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const std::string column = name + "." + std::to_string(c);
    memory(column + ".residual", columns_[c].residual);
    memory(column + ".value", columns_[c].value);
    memory(column + ".window", columns_[c].window);
  }
}

}  // namespace sandglass::coupling
