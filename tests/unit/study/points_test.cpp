#include "study/points.hpp"

#include <gmock/gmock.h>

#include <set>

#include "../support/errors.hpp"

namespace sandglass::study {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using workflow::Setting;

std::vector<Setting> axis(const std::string& name, const std::vector<std::string>& values) {
  std::vector<Setting> all;
  for (const std::string& value : values) all.push_back({name, value});
  return all;
}

std::vector<std::string> names_of(const std::vector<Point>& points) {
  std::vector<std::string> names;
  for (const Point& point : points) names.push_back(point.name);
  return names;
}

std::string value_in(const Point& point, const std::string& name) {
  for (const Setting& setting : point.settings) {
    if (setting.name == name) return setting.text;
  }
  return "not set";
}

TEST(Points, AGridIsEveryCombination) {
  workflow::Study study;
  study.points.resize(1);
  study.points[0].grid = {axis("window", {"1 ms", "2 ms"}), axis("scheme", {"a", "b"})};
  EXPECT_THAT(names_of(make_points(study, {})),
              ElementsAre("window=1ms,scheme=a", "window=1ms,scheme=b", "window=2ms,scheme=a",
                          "window=2ms,scheme=b"));
}

TEST(Points, EveryItemOfTheListMeetsTheGrid) {
  workflow::Study study;
  study.points.resize(1);
  study.points[0].list = {{{"order", "2"}, {"elements", "8"}}, {{"order", "3"}}};
  study.points[0].grid = {axis("far", {"10", "100"})};
  EXPECT_THAT(names_of(make_points(study, {})),
              ElementsAre("order=2,elements=8,far=10", "order=2,elements=8,far=100",
                          "order=3,far=10", "order=3,far=100"));
}

TEST(Points, SeedsAndRepetitionsAreSamplesOfOneSetting) {
  workflow::Study study;
  study.points.resize(1);
  study.points[0].grid = {axis("window", {"1 ms"})};
  study.points[0].seeds = {axis("seed", {"1", "2"})};
  study.points[0].repeat = 2;
  const std::vector<Point> points = make_points(study, {});
  EXPECT_THAT(names_of(points),
              ElementsAre("window=1ms,seed=1,repetition1", "window=1ms,seed=1,repetition2",
                          "window=1ms,seed=2,repetition1", "window=1ms,seed=2,repetition2"));
  for (const Point& point : points) EXPECT_EQ(point.sample_of, "window=1 ms");
  EXPECT_EQ(points[1].repetition, 2);
}

TEST(Points, TheNearerSettingWins) {
  workflow::Study study;
  study.set = {{"a", "1"}, {"b", "1"}, {"c", "1"}};
  study.points.resize(1);
  study.points[0].set = {{"b", "2"}};
  study.points[0].grid = {axis("c", {"3"})};
  const std::vector<Point> points = make_points(study, {{"a", "4"}});
  EXPECT_EQ(value_in(points[0], "a"), "4");
  EXPECT_EQ(value_in(points[0], "b"), "2");
  EXPECT_EQ(value_in(points[0], "c"), "3");
}

TEST(Points, WhatIsSweptCannotBeSetFromOutside) {
  workflow::Study study;
  study.points.resize(1);
  study.points[0].grid = {axis("window", {"1 ms"})};
  const Error error = test::error_of([&] { (void)make_points(study, {{"window", "2 ms"}}); });
  EXPECT_EQ(error.code(), ExitCode::usage);
  EXPECT_THAT(error.what(), HasSubstr("--set window: the study sets this parameter itself"));
}

TEST(Points, NamesAreFoldersAndUnique) {
  workflow::Study study;
  study.points.resize(2);
  study.points[0].grid = {axis("file", {"a/b", "a_b", "..", std::string(500, 'x')})};
  study.points[1].name = "another set";
  study.points[1].grid = {axis("file", {"a/b"})};
  const std::vector<std::string> names = names_of(make_points(study, {}));
  EXPECT_EQ(names[0], "file=a_b");
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  for (const std::string& name : names) {
    EXPECT_LE(name.size(), 200U);
    EXPECT_EQ(name.find('/'), std::string::npos);
  }
}

TEST(Points, TooManyAreRefusedAtOnce) {
  workflow::Study study;
  study.points.resize(1);
  std::vector<std::string> values;
  for (int i = 0; i < 1000; ++i) values.push_back(std::to_string(i));
  for (const char* name : {"a", "b", "c", "d"}) study.points[0].grid.push_back(axis(name, values));
  EXPECT_THAT(test::error_of([&] { (void)make_points(study, {}); }).what(),
              HasSubstr("more than 10000 points"));
  study.points[0].grid.resize(1);
  study.points[0].repeat = INT64_MAX;
  EXPECT_EQ(test::error_of([&] { (void)make_points(study, {}); }).code(), ExitCode::refused);
}

TEST(Points, TheSamePointTwiceIsRefused) {
  workflow::Study study;
  study.points.resize(1);
  study.points[0].grid = {axis("a", {"1", "1"})};
  EXPECT_THAT(test::error_of([&] { (void)make_points(study, {}); }).what(),
              HasSubstr("'a=1' stands here twice"));
}

}  // namespace
}  // namespace sandglass::study
