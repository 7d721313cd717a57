#include "report/compare.hpp"

#include <gmock/gmock.h>

#include "support.hpp"

namespace sandglass::report {
namespace {

using testing::HasSubstr;
using workflow::Comparison;
using workflow::Metric;

class Compare : public testing::Test {
 protected:
  ComparisonResult one(const Comparison& comparison) {
    workflow::Workflow workflow;
    workflow.comparisons.push_back(comparison);
    return compare(workflow, analysis_, folder_.path()).at(0);
  }
  static Comparison of_quantity(Metric metric, double reference, double tolerance) {
    Comparison comparison;
    comparison.name = "speed";
    comparison.quantity = "speed";
    comparison.metric = metric;
    comparison.reference_value = reference;
    comparison.tolerance = tolerance;
    comparison.unit = "m/s";
    comparison.place = {"scene.yaml", 12, 3};
    return comparison;
  }
  static Comparison of_curves(Metric metric, double tolerance) {
    Comparison comparison;
    comparison.name = "whole curve";
    comparison.curve = "ours";
    comparison.reference_curve = "theirs";
    comparison.metric = metric;
    comparison.tolerance = tolerance;
    comparison.unit = "mm/s";
    return comparison;
  }
  void speed(Value value) { analysis_.quantities["speed"] = {"analyse", value, "m/s", ""}; }

  Analysis analysis_;
  Folder folder_;
};

TEST_F(Compare, DifferencesOfNumbers) {
  speed(2.2);
  const ComparisonResult absolute = one(of_quantity(Metric::absolute_difference, 2.0, 0.25));
  EXPECT_DOUBLE_EQ(*absolute.value, 2.2 - 2.0);
  EXPECT_EQ(absolute.passed, true);
  EXPECT_EQ(absolute.ours, 2.2);
  EXPECT_EQ(absolute.reference, 2.0);
  const ComparisonResult relative = one(of_quantity(Metric::relative_difference, -2.0, 2.0));
  EXPECT_DOUBLE_EQ(*relative.value, 4.2 / 2.0);
  EXPECT_EQ(relative.passed, false);
  EXPECT_EQ(relative.metric, "relative difference");
}

TEST_F(Compare, TheToleranceItselfIsWithin) {
  speed(-3.0);
  Comparison bound = of_quantity(Metric::value, 0, 3.0);
  bound.reference_value.reset();
  EXPECT_EQ(one(bound).passed, true) << "the magnitude counts";
  bound.tolerance = 2.999;
  EXPECT_EQ(one(bound).passed, false);
}

TEST_F(Compare, AnAnalyticReferenceIsAQuantity) {
  speed(2.0);
  analysis_.quantities["exact"] = {"analyse", 1.6, "m/s", ""};
  Comparison comparison = of_quantity(Metric::relative_difference, 0, 0.3);
  comparison.reference_value.reset();
  comparison.reference_quantity = "exact";
  comparison.unit = "%";  // that of the tolerance, when the workflow names none
  const ComparisonResult result = one(comparison);
  EXPECT_DOUBLE_EQ(*result.value, 0.25);
  EXPECT_EQ(result.against, "exact");
  EXPECT_EQ(result.shown_in, "m/s");
}

TEST_F(Compare, WhatIsNotFiniteNeverPasses) {
  for (const double bad : {not_a_number, std::numeric_limits<double>::infinity()}) {
    speed(bad);
    for (const Metric metric :
         {Metric::value, Metric::absolute_difference, Metric::relative_difference}) {
      EXPECT_EQ(one(of_quantity(metric, 1.0, 1e300)).passed, false);
    }
  }
  speed(0.0);
  EXPECT_EQ(one(of_quantity(Metric::relative_difference, 0.0, 1e300)).passed, false) << "0/0";
}

TEST_F(Compare, DepartingFromTheReferenceSkips) {
  speed(2.0);
  Comparison comparison = of_quantity(Metric::relative_difference, 1.0, 0.1);
  comparison.holds_for = {{"density", 2650.0, "2650 kg/m3", false},
                          {"viscosity", 1e-3, "0.001 Pa s", true}};
  const ComparisonResult result = one(comparison);
  EXPECT_EQ(result.passed, std::nullopt);
  EXPECT_EQ(result.value, std::nullopt);
  EXPECT_EQ(result.skipped, "density departs from 2650 kg/m3");
  EXPECT_EQ(verdict({result}), ExitCode::done);
  comparison.holds_for.front().met = true;
  EXPECT_EQ(verdict({result, one(comparison)}), ExitCode::mismatch);
}

TEST_F(Compare, AQuantityNotDefinedInThisRunSkips) {
  speed({});
  const ComparisonResult result = one(of_quantity(Metric::absolute_difference, 1.0, 1.0));
  EXPECT_EQ(result.passed, std::nullopt);
  EXPECT_EQ(result.skipped, "'speed' is not defined in this run");
}

TEST_F(Compare, ANameThatNobodyDefinesIsAnErrorAlsoWhenSkipped) {
  analysis_.quantities["spead"] = {"analyse", 1.0, "m/s", ""};
  Comparison comparison = of_quantity(Metric::absolute_difference, 1.0, 1.0);
  comparison.holds_for = {{"density", 2650.0, "2650 kg/m3", false}};
  const auto [code, text] = error_of([&] { one(comparison); });
  EXPECT_EQ(code, ExitCode::participant);
  EXPECT_THAT(text, HasSubstr("scene.yaml:12:3"));
  EXPECT_THAT(text, HasSubstr("'speed', which no analysis stage defines"));
  EXPECT_THAT(text, HasSubstr("did you mean 'spead'?"));
}

TEST_F(Compare, ListsAndOtherUnitsCannotBeCompared) {
  speed(Value::List{1.0, 2.0});
  EXPECT_THAT(error_of([&] { one(of_quantity(Metric::value, 1.0, 1.0)); }).second,
              HasSubstr("is a list"));
  analysis_.quantities["speed"] = {"analyse", 1.0, "Pa", ""};
  EXPECT_THAT(error_of([&] { one(of_quantity(Metric::absolute_difference, 1.0, 1.0)); }).second,
              HasSubstr("'speed' is in 'Pa' and cannot be compared in 'm/s'"));
}

TEST_F(Compare, CurvesAreComparedOnOurAbscissaeInTheCommonRange) {
  analysis_.curves["ours"] = curve_of({0, 1, 2, 3, 4}, {9, 1, 5, 6, 9});
  analysis_.curves["theirs"] = curve_of({1, 3}, {1, 3});  // 1, 2, 3 at 1, 2, 3
  const ComparisonResult largest = one(of_curves(Metric::maximum_difference, 3.0));
  EXPECT_DOUBLE_EQ(*largest.value, 3.0);
  EXPECT_EQ(largest.passed, true);
  EXPECT_EQ(largest.points, 3);
  EXPECT_EQ(largest.from, 1.0);
  EXPECT_EQ(largest.to, 3.0);
  const ComparisonResult mean = one(of_curves(Metric::root_mean_square, 2.0));
  EXPECT_DOUBLE_EQ(*mean.value, std::sqrt((0.0 + 9.0 + 9.0) / 3));
  EXPECT_EQ(mean.passed, false);
}

TEST_F(Compare, ANaNInEitherCurveNeverPasses) {
  for (const Metric metric : {Metric::maximum_difference, Metric::root_mean_square}) {
    analysis_.curves["ours"] = curve_of({0, 1, 2}, {0, not_a_number, 0});
    analysis_.curves["theirs"] = curve_of({0, 2}, {0, 0});
    EXPECT_EQ(one(of_curves(metric, 1e300)).passed, false);
    EXPECT_TRUE(std::isnan(*one(of_curves(metric, 1e300)).value));
    analysis_.curves["ours"] = curve_of({0, 1, 2}, {0, 0, 0});
    analysis_.curves["theirs"] = curve_of({0, 1, 2}, {not_a_number, 0, 0});
    EXPECT_EQ(one(of_curves(metric, 1e300)).passed, false);
  }
}

TEST_F(Compare, CurvesWithNothingInCommonAreSkippedWithTheirRanges) {
  analysis_.curves["ours"] = curve_of({0, 1}, {0, 0});
  analysis_.curves["theirs"] = curve_of({2, 3}, {0, 0});
  const ComparisonResult result = one(of_curves(Metric::maximum_difference, 1.0));
  EXPECT_EQ(result.passed, std::nullopt);
  EXPECT_THAT(result.skipped, HasSubstr("ours lies in 0 to 1, the reference in 2 to 3"));
}

TEST_F(Compare, ACurveMustAscend) {
  analysis_.curves["ours"] = curve_of({0, 1, 1}, {0, 0, 0});
  analysis_.curves["theirs"] = curve_of({0, 3}, {0, 0});
  EXPECT_THAT(error_of([&] { one(of_curves(Metric::maximum_difference, 1.0)); }).second,
              HasSubstr("no ascending abscissae (value 3)"));
}

TEST_F(Compare, AMeasuredCurveComesFromAFile) {
  folder_.write("icy/figure_2.csv", "# read from Figure 2\ntime,velocity,error\n0,0,1\n2,4,1\n");
  analysis_.curves["ours"] = curve_of({0, 1, 2}, {0, 2.5, 4});
  Comparison comparison = of_curves(Metric::maximum_difference, 1.0);
  comparison.reference_curve.clear();
  comparison.reference_file = "icy/figure_2.csv";
  EXPECT_DOUBLE_EQ(*one(comparison).value, 0.5);
  comparison.reference_file = "icy/none.csv";
  EXPECT_EQ(error_of([&] { one(comparison); }).first, ExitCode::environment);
}

TEST(Reference, MistakesAreToldWithTheirPlace) {
  const Folder folder;
  const auto text_of = [&](const std::string& text) {
    return error_of([&] { read_reference(folder.write("a.csv", text)); }).second;
  };
  EXPECT_THAT(text_of("x,y\n1,2\n2,three\n"), HasSubstr("a.csv:3:3: 'three' is not a number"));
  EXPECT_THAT(text_of("x,y\n1,nan\n"), HasSubstr("a.csv:2:3: 'nan' is not a number"));
  EXPECT_THAT(text_of("x,y\n1 m,2\n"), HasSubstr("a.csv:2:1: '1 m' is not a number"));
  EXPECT_THAT(text_of("x,y\n2,0\n1,0\n"), HasSubstr("a.csv:3:1: the abscissa 1 does not ascend"));
  EXPECT_THAT(text_of("1,2\n2,3\n"), HasSubstr("a.csv:1:1: numbers where the header row"));
  EXPECT_THAT(text_of("x;y\n"), HasSubstr("a.csv:1:1: a row with one column only"));
  EXPECT_THAT(text_of("# nothing\nx,y\n"), HasSubstr("no rows of numbers"));
  EXPECT_THAT(text_of(""), HasSubstr("no rows of numbers"));
}

TEST(Reference, WindowsLineEndsAndBlanksAreFine) {
  const Folder folder;
  const Points points = read_reference(folder.write("a.csv", "x, y\r\n\r\n 1 , 2e-3\r\n3,4"));
  EXPECT_EQ(points.x, (std::vector<double>{1, 3}));
  EXPECT_EQ(points.y, (std::vector<double>{2e-3, 4}));
}

}  // namespace
}  // namespace sandglass::report
