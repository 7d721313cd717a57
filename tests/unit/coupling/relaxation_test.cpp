#include "coupling/relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sandglass::coupling {
namespace {

/// Iterations until x solves x = slope x + 1 to 1e-12, or 0 when it does not within 200.
int iterations(Relaxation relaxation, double slope) {
  std::vector<double> x = {0.0};
  const double solution = 1 / (1 - slope);
  for (int n = 1; n <= 200; ++n) {
    const std::vector<double> next = {slope * x[0] + 1};
    relaxation.step(x, next);
    if (std::abs(x[0] - solution) < 1e-12 * std::abs(solution)) return n;
  }
  return 0;
}

TEST(Relaxation, NoneTakesTheNewestValue) {
  Relaxation relaxation(Acceleration::none, 0.1);
  std::vector<double> x = {1.0, 2.0};
  relaxation.step(x, std::vector<double>{3.0, 4.0});
  EXPECT_EQ(x, (std::vector<double>{3.0, 4.0}));
}

TEST(Relaxation, ConstantConvergesBelowItsLimitOnly) {
  // A window of lambda relaxation times iterates with slope -lambda: converges for w <
  // 2/(1+lambda).
  for (const double lambda : {0.5, 1.0, 4.0}) {
    const double limit = 2 / (1 + lambda);
    EXPECT_GT(iterations({Acceleration::constant, 0.9 * limit}, -lambda), 0) << lambda;
    EXPECT_EQ(iterations({Acceleration::constant, 1.02 * limit}, -lambda), 0) << lambda;
  }
}

TEST(Relaxation, AitkenSolvesALinearProblemOfOneUnknownInThreeSteps) {
  for (const double slope : {-0.5, -4.0, 0.5, -100.0}) {
    EXPECT_LE(iterations({Acceleration::aitken, 0.5}, slope), 3) << slope;
    EXPECT_GT(iterations({Acceleration::aitken, 0.5}, slope), 0) << slope;
  }
}

TEST(Relaxation, ANewWindowStartsWithAUsableFactor) {
  Relaxation relaxation(Acceleration::aitken, 0.5);
  std::vector<double> x = {0.0};
  relaxation.step(x, std::vector<double>{1.0});
  relaxation.step(x, std::vector<double>{0.5});  // no residual: the factor is kept
  relaxation.new_window();
  EXPECT_GT(relaxation.factor(), 0.0);
  EXPECT_LE(relaxation.factor(), 0.5);
}

TEST(Relaxation, AnotherNumberOfValuesIsTakenAsItIs) {
  Relaxation relaxation(Acceleration::constant, 0.5);
  std::vector<double> x = {1.0};
  relaxation.step(x, std::vector<double>{3.0, 4.0});
  EXPECT_EQ(x, (std::vector<double>{3.0, 4.0}));
}

}  // namespace
}  // namespace sandglass::coupling
