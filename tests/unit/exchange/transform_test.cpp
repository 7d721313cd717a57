#include "exchange/transform.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sandglass::exchange {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using Numbers = std::vector<double>;
using Shape = std::vector<std::int64_t>;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr Transform kStatistics[] = {Transform::mean, Transform::median, Transform::minimum,
                                     Transform::maximum, Transform::sum};

TEST(Identity, ChangesNothing) {
  const Numbers values{3, 1, 2, 5};
  EXPECT_EQ(apply(Transform::identity, values, {2, 2}, 0), values);
  EXPECT_THAT(transformed_shape(Transform::identity, {2, 2}, 0), ElementsAre(2, 2));
}

TEST(Statistics, ReduceTheFirstAxis) {
  // Columns: 5 1 3 and -1 0 7.
  const Numbers values{5, -1, 1, 0, 3, 7};
  const Shape shape{3, 2};
  EXPECT_THAT(apply(Transform::mean, values, shape, 0), ElementsAre(3, 2));
  EXPECT_THAT(apply(Transform::median, values, shape, 0), ElementsAre(3, 0));
  EXPECT_THAT(apply(Transform::minimum, values, shape, 0), ElementsAre(1, -1));
  EXPECT_THAT(apply(Transform::maximum, values, shape, 0), ElementsAre(5, 7));
  EXPECT_THAT(apply(Transform::sum, values, shape, 0), ElementsAre(9, 6));
  for (const Transform statistic : kStatistics) {
    EXPECT_THAT(transformed_shape(statistic, shape, 0), ElementsAre(2));
    EXPECT_THAT(transformed_shape(statistic, {9}, 0), ElementsAre(1));
    EXPECT_THAT(transformed_shape(statistic, {9, 4, 3}, 0), ElementsAre(4, 3));
  }
}

TEST(Statistics, OfAnEvenNumberTheMedianIsBetweenTheMiddleTwo) {
  EXPECT_THAT(apply(Transform::median, Numbers{8, 1, 2, 4}, {4}, 0), ElementsAre(3));
  EXPECT_THAT(apply(Transform::median, Numbers{8, 1}, {2}, 0), ElementsAre(4.5));
}

TEST(Statistics, OfOneRowAreThatRow) {
  for (const Transform statistic : kStatistics) {
    EXPECT_THAT(apply(statistic, Numbers{4, -2}, {1, 2}, 0), ElementsAre(4, -2));
  }
}

TEST(Statistics, KeepWhatIsNotANumberInItsOwnColumn) {
  for (size_t at = 0; at < 3; ++at) {
    Numbers values{1, 10, 2, 20, 3, 30};
    values[2 * at] = kNotANumber;
    for (const Transform statistic : kStatistics) {
      const Numbers result = apply(statistic, values, {3, 2}, 0);
      EXPECT_TRUE(std::isnan(result.at(0))) << static_cast<int>(statistic) << " at row " << at;
      EXPECT_TRUE(std::isfinite(result.at(1)));
    }
  }
}

TEST(Statistics, OfNoRowsAreNotNumbersButTheSumIsZero) {
  for (const Transform statistic : kStatistics) {
    const Numbers result = apply(statistic, Numbers{}, {0, 2}, 0);
    ASSERT_EQ(result.size(), 2U);
    for (const double value : result) {
      if (statistic == Transform::sum) {
        EXPECT_EQ(value, 0);
      } else {
        EXPECT_TRUE(std::isnan(value));
      }
    }
  }
}

// ---- resampling in time: sample i of m stands at (i + 1) / m

TEST(Linear, KnowsItsShape) {
  EXPECT_THAT(transformed_shape(Transform::linear, {10, 3}, 4), ElementsAre(4, 3));
}

TEST(Linear, ToTheSameNumberChangesNoBit) {
  for (std::int64_t count = 1; count <= 200; ++count) {
    Numbers values;
    for (std::int64_t i = 0; i < count; ++i)
      values.push_back(std::sin(1.0 + static_cast<double>(i)));
    ASSERT_EQ(apply(Transform::linear, values, {count}, count), values) << count;
  }
}

TEST(Linear, ALinearSignalIsExactAndConstantBeforeItsFirstSample) {
  const auto signal = [](double time) { return 2.0 - 3.0 * time; };
  for (const int from : {1, 2, 3, 7, 10}) {
    Numbers values;
    for (int i = 1; i <= from; ++i) {
      values.push_back(signal(static_cast<double>(i) / from));
      values.push_back(-signal(static_cast<double>(i) / from));
    }
    for (const int to : {1, 2, 5, 10, 100}) {
      const Numbers result = apply(Transform::linear, values, {from, 2}, to);
      ASSERT_EQ(result.size(), 2U * static_cast<size_t>(to));
      for (int i = 1; i <= to; ++i) {
        const double time = std::max(static_cast<double>(i) / to, 1.0 / from);
        const auto at = 2 * static_cast<size_t>(i - 1);
        EXPECT_THAT(result[at], DoubleNear(signal(time), 1e-14)) << from << " to " << to;
        EXPECT_EQ(result[at + 1], -result[at]);
      }
    }
  }
}

TEST(Linear, TheLastSampleIsTheWindowsEnd) {
  const Numbers values{1, 4, 9};
  for (const std::int64_t to : {1, 2, 3, 8}) {
    EXPECT_EQ(apply(Transform::linear, values, {3}, to).back(), 9) << to;
  }
}

TEST(Linear, OneSampleIsAConstant) {
  EXPECT_THAT(apply(Transform::linear, Numbers{7}, {1}, 3), ElementsAre(7, 7, 7));
}

TEST(Linear, WhatIsNotANumberStaysWhereItIs) {
  const Numbers result = apply(Transform::linear, Numbers{1, kNotANumber, 3, 4}, {4}, 4);
  EXPECT_EQ(result[0], 1);
  EXPECT_TRUE(std::isnan(result[1]));
  EXPECT_EQ(result[2], 3);
  EXPECT_EQ(result[3], 4);
}

TEST(Linear, OfNoSamplesAreNotNumbers) {
  for (const double value : apply(Transform::linear, Numbers{}, {0, 2}, 3)) {
    EXPECT_TRUE(std::isnan(value));
  }
}

}  // namespace
}  // namespace sandglass::exchange
