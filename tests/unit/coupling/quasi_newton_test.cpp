#include "coupling/quasi_newton.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sandglass::coupling {
namespace {

using Vector = std::vector<double>;

/// f(x) = A x + b.
struct Linear {
  std::vector<Vector> a;
  Vector b;
  [[nodiscard]] Vector operator()(const Vector& x) const {
    Vector y = b;
    for (std::size_t i = 0; i < y.size(); ++i)
      for (std::size_t j = 0; j < x.size(); ++j) y[i] += a[i][j] * x[j];
    return y;
  }
};

double residual(const Vector& x, const Vector& next) {
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += (next[i] - x[i]) * (next[i] - x[i]);
  return std::sqrt(sum);
}

/// Iterations until the residual is below 1e-10.
template <typename Map>
int iterations(QuasiNewton& method, const Map& map, Vector x, Vector* solution = nullptr) {
  const Vector weights(x.size(), 1.0);
  method.new_window();
  for (int n = 1; n <= 60; ++n) {
    const Vector next = map(x);
    if (residual(x, next) < 1e-10) {
      if (solution) *solution = x;
      return n;
    }
    method.step(x, next, weights);
  }
  return 1000;
}

TEST(QuasiNewton, OneUnknownIsSolvedByTheSecant) {
  // An iteration that would diverge, as added mass makes it: slope -3. One relaxed step, one
  // secant.
  QuasiNewton method(0.5, 0, 1e-6);
  Vector solution;
  EXPECT_EQ(iterations(method, Linear{{{-3}}, {8}}, {0}, &solution), 3);
  EXPECT_NEAR(solution[0], 2, 1e-10);
}

TEST(QuasiNewton, LinearProblemsNeedAtMostOneIterationMoreThanUnknowns) {
  const Linear map{
      {{-2, 0.3, 0, 0.1}, {0.2, 1.5, -0.4, 0}, {0, 0.7, -1.2, 0.5}, {0.1, 0, 0.2, 0.3}},
      {1, 2, 3, 4}};
  QuasiNewton method(0.3, 0, 1e-8);
  Vector solution;
  EXPECT_LE(iterations(method, map, {0, 0, 0, 0}, &solution), 6);  // start, four directions, check
  EXPECT_LT(residual(solution, map(solution)), 1e-10);
}

TEST(QuasiNewton, EarlierWindowsAreReused) {
  Linear map{{{-2, 0.3}, {0.2, 1.5}}, {1, 2}};
  QuasiNewton with(0.3, 5, 1e-8), without(0.3, 0, 1e-8);
  iterations(with, map, {0, 0});
  iterations(without, map, {0, 0});
  map.b = {-4, 7};  // the same map around another point: its slope is known already
  EXPECT_EQ(iterations(with, map, {0, 0}), 2);
  EXPECT_GT(iterations(without, map, {0, 0}), 2);
}

TEST(QuasiNewton, ColumnsThatAddNothingAreForgotten) {
  const Linear map{{{0.5, 0}, {0, 0.5}}, {1, 1}};  // all residuals are parallel
  QuasiNewton method(0.1, 10, 1e-3);
  const Vector weights{1, 1};
  Vector x{0, 0};
  method.new_window();
  for (int n = 0; n < 3; ++n) method.step(x, map(x), weights);
  EXPECT_LE(method.columns(), 1U);
  EXPECT_NEAR(x[0], 2, 1e-9);
}

TEST(QuasiNewton, NonlinearProblem) {
  const auto map = [](const Vector& x) {
    return Vector{std::cos(x[1]) * 1.4, 2 - 1.5 * std::sin(x[0])};
  };
  QuasiNewton method(0.5, 0, 1e-4);
  EXPECT_LT(iterations(method, map, {0.5, 0.5}), 15);
}

TEST(QuasiNewton, WhatIsRememberedGoesOnAlike) {
  Linear map{{{-2, 0.3}, {0.2, 1.5}}, {1, 2}};
  QuasiNewton method(0.3, 5, 1e-8);
  iterations(method, map, {0, 0});
  Memory kept;
  method.remember(kept, "joint");
  QuasiNewton again(0.3, 5, 1e-8);
  Memory recalled(kept.arrays());
  again.remember(recalled, "joint");
  map.b = {5, -3};
  Vector one, two;
  EXPECT_EQ(iterations(method, map, {0, 0}, &one), iterations(again, map, {0, 0}, &two));
  EXPECT_EQ(one, two);
}

TEST(QuasiNewton, AnotherLengthBeginsAnew) {
  QuasiNewton method(0.5, 5, 1e-6);
  Vector x{0};
  method.step(x, Vector{1.0, 2.0}, Vector{1.0, 1.0});
  EXPECT_EQ(x, (Vector{1.0, 2.0}));
  EXPECT_EQ(method.columns(), 0U);
}

}  // namespace
}  // namespace sandglass::coupling
