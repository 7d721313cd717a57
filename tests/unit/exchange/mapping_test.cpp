#include "exchange/mapping.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "base/error.hpp"

namespace sandglass::exchange {
namespace {

using testing::HasSubstr;

constexpr double kFar = 1e300;

/// A line of n points with uneven distances, bent or straight.
Interface line(std::size_t n, double bend = 0) {
  Interface result{2, {}, 2, chain(n)};
  for (std::size_t i = 0; i < n; ++i) {
    const double s = std::pow(static_cast<double>(i) / static_cast<double>(n - 1), 1.3);
    result.points.insert(result.points.end(), {s, bend * s * s});
  }
  return result;
}

/// An n x n grid of triangles over the unit square, lifted to z = height(x, y).
template <typename Height>
Interface surface(std::int64_t n, Height height) {
  Interface result{3, {}, 3, {}};
  for (std::int64_t i = 0; i <= n; ++i)
    for (std::int64_t j = 0; j <= n; ++j) {
      const double x = static_cast<double>(i) / static_cast<double>(n);
      const double y = static_cast<double>(j) / static_cast<double>(n);
      result.points.insert(result.points.end(), {x, y, height(x, y)});
    }
  for (std::int64_t i = 0; i < n; ++i)
    for (std::int64_t j = 0; j < n; ++j) {
      const std::int64_t a = i * (n + 1) + j, b = a + n + 1;
      result.cells.insert(result.cells.end(), {a, b, a + 1, b, b + 1, a + 1});
    }
  return result;
}

std::vector<double> random_points(std::size_t count,
                                  const std::function<double(double, double)>& height) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = uniform(generator), y = uniform(generator);
    result.insert(result.end(), {x, y, height(x, y)});
  }
  return result;
}

double sum(const std::vector<double>& values, std::size_t column, std::size_t width) {
  double result = 0;
  for (std::size_t i = column; i < values.size(); i += width) result += values[i];
  return result;
}

TEST(Mapping, ConstantsAreExactByBothMethods) {
  const auto flat = [](double, double) { return 0.0; };
  const Interface from = surface(7, flat);
  const std::vector<double> to = random_points(500, flat);
  for (const auto method : {MappingMethod::nearest, MappingMethod::linear}) {
    const Mapping mapping(method, from, to, kFar);
    for (const double value : mapping.consistent(std::vector<double>(from.count(), 4.25), 1)) {
      EXPECT_NEAR(value, 4.25, 1e-14);
    }
  }
}

TEST(Mapping, LinearFieldsAreExactOnLinesAndSurfaces) {
  const Interface straight = line(9);
  std::vector<double> to;
  for (int i = 0; i <= 100; ++i) to.insert(to.end(), {i / 100.0, 0.0});
  std::vector<double> values;
  for (std::size_t i = 0; i < straight.count(); ++i)
    values.push_back(3 - 2 * straight.points[2 * i]);
  const auto mapped = Mapping(MappingMethod::linear, straight, to, 1e-12).consistent(values, 1);
  for (std::size_t i = 0; i < mapped.size(); ++i) EXPECT_NEAR(mapped[i], 3 - 2 * to[2 * i], 1e-14);

  const auto tilted = [](double x, double y) { return 0.3 * x - 0.2 * y; };
  const Interface from = surface(6, tilted);
  const std::vector<double> points = random_points(400, tilted);
  std::vector<double> field;  // two components
  for (std::size_t i = 0; i < from.count(); ++i) {
    const double x = from.points[3 * i], y = from.points[3 * i + 1];
    field.insert(field.end(), {1 + x + 2 * y, -y});
  }
  const auto result = Mapping(MappingMethod::linear, from, points, 1e-12).consistent(field, 2);
  for (std::size_t i = 0; i < 400; ++i) {
    EXPECT_NEAR(result[2 * i], 1 + points[3 * i] + 2 * points[3 * i + 1], 1e-13);
    EXPECT_NEAR(result[2 * i + 1], -points[3 * i + 1], 1e-13);
  }
}

/// Forces keep their sum to the last digits by both methods; their moment by the linear one.
TEST(Mapping, ForcesKeepTheirSumAndMoment) {
  const auto bowl = [](double x, double y) { return 0.1 * x + 0.25 * y; };
  const Interface to = surface(5, bowl);
  const std::vector<double> points = random_points(1000, bowl);
  std::mt19937 generator(2);
  std::normal_distribution<double> normal;
  std::vector<double> forces(3000);
  for (double& force : forces) force = normal(generator);
  for (const auto method : {MappingMethod::nearest, MappingMethod::linear}) {
    const Mapping mapping(method, to, points, kFar);
    const auto mapped = mapping.conservative(forces, 3);
    double size = 0;
    for (const double force : forces) size += std::abs(force);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(sum(mapped, k, 3), sum(forces, k, 3), 1e-14 * size);
    }
    const auto moment = [](const std::vector<double>& places, const std::vector<double>& pushes) {
      std::array<double, 3> result{};
      for (std::size_t i = 0; i < pushes.size(); i += 3) {
        result[0] += places[i + 1] * pushes[i + 2] - places[i + 2] * pushes[i + 1];
        result[1] += places[i + 2] * pushes[i] - places[i] * pushes[i + 2];
        result[2] += places[i] * pushes[i + 1] - places[i + 1] * pushes[i];
      }
      return result;
    };
    const auto before = moment(points, forces), after = moment(to.points, mapped);
    for (std::size_t k = 0; k < 3; ++k) {
      if (method == MappingMethod::linear) {
        EXPECT_NEAR(after[k], before[k], 1e-13 * size);
      } else {
        EXPECT_GT(std::abs(after[k] - before[k]), 1e-6);
      }
    }
  }
}

/// Work is the same on both sides: u_b . f_b = u_a . f_a, because one is the transpose of the
/// other.
TEST(Mapping, WorkIsTheSameOnBothSides) {
  const auto flat = [](double, double) { return 0.0; };
  const Interface from = surface(4, flat);
  const Mapping mapping(MappingMethod::linear, from, random_points(50, flat), kFar);
  std::vector<double> u(from.count()), f(50);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = std::sin(3.0 * static_cast<double>(i));
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = std::cos(2.0 * static_cast<double>(i));
  const auto there = mapping.consistent(u, 1), back = mapping.conservative(f, 1);
  EXPECT_NEAR(std::inner_product(there.begin(), there.end(), f.begin(), 0.0),
              std::inner_product(u.begin(), u.end(), back.begin(), 0.0), 1e-13);
}

/// The nearest cell is found also where cells differ much in size and the nearest point is not one
/// of its corners.
TEST(Mapping, TheNearestCellIsFoundAmongCellsOfAllSizes) {
  Interface uneven{2, {0, 0, 10, 0, 10.1, 0.01, 10.2, 0, 10.3, 0.02, 0.3, 0.5}, 2, {}};
  uneven.cells = {0, 1, 1, 2, 2, 3, 3, 4};  // one long segment and short ones; point 5 is in none
  const Mapping mapping(MappingMethod::linear, uneven, std::vector<double>{4, 0.2}, 0.2 + 1e-12);
  EXPECT_NEAR(mapping.consistent(std::vector<double>{0, 10, 99, 99, 99, 99}, 1)[0], 4, 1e-12);
}

TEST(Mapping, InterfacesGainAndLosePoints) {
  for (const std::size_t count : {0U, 1U, 2U, 5U, 100U}) {
    const Interface from = line(count + 2, 0.2);
    std::vector<double> to(from.points.begin(),
                           from.points.begin() + static_cast<std::ptrdiff_t>(2 * count));
    const Mapping mapping(MappingMethod::linear, from, to, 1e-9);
    EXPECT_EQ(mapping.points(), count);
    EXPECT_EQ(mapping.consistent(std::vector<double>(from.count(), 1.0), 1).size(), count);
    EXPECT_EQ(mapping.conservative(std::vector<double>(count, 1.0), 1).size(), count + 2);
  }
}

TEST(Mapping, WhatIsOutOfReachIsNamed) {
  const Interface from = line(5);
  try {
    const Mapping mapping(MappingMethod::linear, from, std::vector<double>{0.5, 0, 0.25, 0.4}, 0.1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::participant);
    EXPECT_THAT(error.what(), HasSubstr("point 1 at (0.25, 0.4) m is 0.4 m from the interface"));
  }
  const std::vector<double> not_finite{std::nan(""), 0};
  EXPECT_THROW(Mapping(MappingMethod::linear, from, not_finite, 0.1), Error);
  Interface broken = from;
  broken.cells = {0, 7};
  EXPECT_THROW(Mapping(MappingMethod::linear, broken, std::vector<double>{0.5, 0}, kFar), Error);
  EXPECT_THROW(
      Mapping(MappingMethod::nearest, Interface{2, {}, 0, {}}, std::vector<double>{0, 0}, kFar),
      Error);
}

TEST(Mapping, AMillionPoints) {
  const auto flat = [](double, double) { return 0.0; };
  const Interface from = surface(300, flat);
  const std::vector<double> to = random_points(1'000'000, flat);
  for (const auto method : {MappingMethod::nearest, MappingMethod::linear}) {
    const Mapping mapping(method, from, to, 0.1);
    const auto forces = mapping.conservative(std::vector<double>(1'000'000, 1e-6), 1);
    EXPECT_NEAR(sum(forces, 0, 1), 1, 1e-14 * 1e3);  // rounding of a million additions
  }
}

}  // namespace
}  // namespace sandglass::exchange
