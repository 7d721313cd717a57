#include "coupling/stability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

namespace sandglass::coupling {
namespace {

/// The window in which the watch speaks, or 0 when it is silent for so many windows.
int window_of_verdict(const std::function<double(int)>& x, int windows,
                      const StabilityLimits& limits = {}) {
  StabilityWatch watch{limits};
  for (int n = 1; n <= windows; ++n) {
    const double value = x(n);
    if (watch.observe({&value, 1})) return n;
  }
  return 0;
}

/// A linear coupling with factor G towards a limit.
std::function<double(int)> mode(double growth, double limit = 1) {
  return [=](int n) { return limit * (1 - std::pow(growth, n)); };
}

TEST(StabilityWatch, EndsEveryModeThatGrowsFivePercentWithinFortyWindows) {
  for (const double growth : {-1.05, -1.2, -1.5, -2.0, -3.0, -10.0, 1.05, 1.1, 1.5, 3.0}) {
    const int window = window_of_verdict(mode(growth), 40);
    EXPECT_GT(window, 0) << "G = " << growth;
  }
}

TEST(StabilityWatch, IsSilentForEveryModeThatDecaysFivePercent) {
  for (const double growth : {-0.95, -0.5, -0.1, 0.0, 0.1, 0.5, 0.95, 0.99}) {
    EXPECT_EQ(window_of_verdict(mode(growth), 3000), 0) << "G = " << growth;
  }
}

TEST(StabilityWatch, SeesGrowingAndDecayingOscillationsOfEveryPeriod) {
  // z^2 - z + lambda = 0 (drag one window older): |z|^2 = lambda, turning by 60 to 75 degrees.
  for (const double degrees : {45.0, 60.0, 70.0, 75.5, 90.0, 120.0, 150.0}) {
    const auto swing = [&](double size) {
      return [=](int n) {
        return std::pow(size, n) * std::cos(n * degrees * std::numbers::pi / 180 + 0.3);
      };
    };
    EXPECT_GT(window_of_verdict(swing(1.05), 40), 0) << degrees;
    EXPECT_EQ(window_of_verdict(swing(0.95), 3000), 0) << degrees;
  }
}

TEST(StabilityWatch, SeesSlowOscillationsThatGrow) {
  for (const double degrees : {3.0, 6.0, 9.0, 10.0, 15.0, 20.0, 30.0}) {
    for (const double growth : {1.03, 1.1, 1.3}) {
      const auto swing = [&](double size) {
        return [=](int n) {
          return 1 + 1e-3 * std::pow(size, n) * std::cos(n * degrees * std::numbers::pi / 180);
        };
      };
      EXPECT_GT(window_of_verdict(swing(growth), 600), 0) << degrees << " " << growth;
      EXPECT_EQ(window_of_verdict(swing(1 / growth), 600), 0) << degrees << " " << growth;
    }
  }
}

TEST(StabilityWatch, IsSilentForAResonance) {
  // Its swings grow as 1, 2, 3, ...: by a half, a third, a quarter.
  for (int half = 8; half <= 60; ++half) {
    for (const double power : {1.0, 2.0}) {
      const auto resonance = [&](int n) {
        return std::pow(n, power) * std::sin(std::numbers::pi * n / half);
      };
      EXPECT_EQ(window_of_verdict(resonance, 3000), 0) << half << " " << power;
    }
  }
}

TEST(StabilityWatch, LooksAtEveryColumnOfALargeField) {
  for (const std::size_t row : {1U, 2U, 3U, 4U, 6U, 9U}) {
    for (const std::size_t rows : {300U, 513U, 683U, 1000U, 1707U, 5000U}) {
      StabilityWatch watch{StabilityLimits{}};
      int found = 0;
      for (int n = 1; n <= 200 && found == 0; ++n) {
        std::vector<double> values(rows * row, 0.0);
        for (std::size_t i = row - 1; i < values.size(); i += row) {
          values[i] = 1 - std::pow(-1.3, n);
        }
        if (watch.observe(values, row)) found = n;
      }
      EXPECT_GT(found, 0) << rows << " rows of " << row;
    }
  }
}

TEST(StabilityWatch, DoesNotTakeRoundingForAnExplosion) {
  const double ulp = std::numeric_limits<double>::epsilon();
  const double changes[] = {0, 1, -30, 900, -27000};
  double value = 1;
  StabilityWatch watch{StabilityLimits{}};
  for (const double change : changes) {
    value += change * ulp;
    EXPECT_FALSE(watch.observe({&value, 1})) << change;
  }
}

TEST(StabilityWatch, IsSilentForPowersOfTime) {
  for (const double power : {1.0, 1.5, 2.0, 3.0, 4.0}) {
    EXPECT_EQ(window_of_verdict([=](int n) { return std::pow(n, power); }, 5000), 0) << power;
  }
}

TEST(StabilityWatch, IsSilentForAnImpactAndForNoise) {
  EXPECT_EQ(window_of_verdict(
                [](int n) {
                  return n < 50 || n > 850
                             ? 0.0
                             : std::pow(std::sin(std::numbers::pi * (n - 50) / 800.0), 1.5);
                },
                1000),
            0);
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> noise;
    EXPECT_EQ(window_of_verdict([&](int) { return 3 + noise(generator); }, 2000), 0) << seed;
  }
}

TEST(StabilityWatch, EndsAnExplosionAtOnce) {
  const int window = window_of_verdict(mode(-67), 40);
  EXPECT_GT(window, 0);
  EXPECT_LE(window, 4);
}

TEST(StabilityWatch, IsSilentForABounce) {
  // Falls, is thrown back a thousand times faster within one window, and falls on.
  EXPECT_EQ(window_of_verdict([](int n) { return n <= 50 ? -0.001 * n : 0.9 - 0.001 * n; }, 100),
            0);
}

TEST(StabilityWatch, DoesNotLookAtWhatIsLostInRounding) {
  EXPECT_EQ(
      window_of_verdict([](int n) { return 1 + 1e-16 * std::pow(-1.5, std::min(n, 30)); }, 100), 0);
}

TEST(StabilityWatch, WorksAtTheEndsOfTheRangeOfNumbers) {
  EXPECT_GT(window_of_verdict(mode(-1.5, 1e-300), 40), 0);
  EXPECT_GT(window_of_verdict(mode(-1.5, 1e300), 40), 0);
  EXPECT_EQ(window_of_verdict([](int) { return 0.0; }, 100), 0);
}

TEST(StabilityWatch, NamesGrowthAndSign) {
  StabilityWatch watch{StabilityLimits{}};
  for (int n = 1; n <= 40; ++n) {
    const double value = mode(-1.31)(n);
    if (const auto found = watch.observe({&value, 1})) {
      EXPECT_NEAR(found->growth, 1.31, 1e-6);
      EXPECT_TRUE(found->alternating);
      EXPECT_EQ(found->text(), "grows 1.31 times per window, with alternating sign");
      return;
    }
  }
  FAIL() << "no verdict";
}

TEST(StabilityWatch, WarnsOfADecayingOscillation) {
  StabilityWatch oscillating{StabilityLimits{}};
  StabilityWatch monotone{StabilityLimits{}};
  for (int n = 1; n <= 30; ++n) {
    const double swinging = mode(-0.7)(n);
    const double settling = mode(0.7)(n);
    EXPECT_FALSE(oscillating.observe({&swinging, 1}));
    EXPECT_FALSE(monotone.observe({&settling, 1}));
  }
  ASSERT_TRUE(oscillating.oscillation());
  EXPECT_NEAR(oscillating.oscillation()->growth, 0.7, 0.01);
  EXPECT_FALSE(monotone.oscillation());
}

TEST(StabilityWatch, HasALimitOfItsOwnForGrowthWithoutAChangeOfSign) {
  const StabilityLimits patient{.monotone_growth = 1.2};
  EXPECT_EQ(window_of_verdict(mode(1.15), 200, patient), 0);
  EXPECT_GT(window_of_verdict(mode(1.25), 40, patient), 0);
  EXPECT_GT(window_of_verdict(mode(-1.05), 40, patient), 0);
}

TEST(StabilityWatch, CanBeSwitchedOff) {
  StabilityWatch watch{StabilityLimits{false}};
  for (int n = 1; n <= 100; ++n) {
    const double value = mode(-2)(n);
    EXPECT_FALSE(watch.observe({&value, 1}));
  }
}

TEST(StabilityWatch, BeginsAnewWhenTheNumberOfValuesChanges) {
  StabilityWatch watch{StabilityLimits{}};
  std::vector<double> values;
  for (int n = 1; n <= 100; ++n) {
    values.assign(static_cast<std::size_t>(n), n % 2 == 0 ? 1e3 * n : -1e3 * n);
    EXPECT_FALSE(watch.observe(values));
  }
}

}  // namespace
}  // namespace sandglass::coupling
