#include <gtest/gtest.h>

#include "template_helpers.hpp"

// One template per language in tests/golden/render, and what it becomes. To accept a change, write
// the new text into the .expected file by hand: it is what a user would read.
namespace sandglass {
namespace {

using List = Value::List;
using Map = Value::Map;

Map scene() {
  return {{"title", "a sphere's fall (\"ICY\", section 3)"},
          {"diameter", 1e-4},
          {"density", 2650.0},
          {"gravity", -9.80665},
          {"steps", 22},
          {"damped", false},
          {"fluid", Value::Choice{"axisymmetric", {"axisymmetric", "box"}}},
          {"radii", List{5e-5, 1.0, 20.0}},
          {"fields",
           List{Map{{"name", "drag"}, {"unit", "N"}}, Map{{"name", "velocity"}, {"unit", "m/s"}}}},
          {"window", Map{{"index", 3}, {"begin", 0.002}, {"end", 0.003}}}};
}

class Golden : public testing::TestWithParam<const char*> {};

TEST_P(Golden, BecomesTheExpectedText) {
  const std::string root = SANDGLASS_SOURCE_DIR "/tests/golden/render";
  const Template made = Template::load(root, GetParam());
  const std::string expected = read_file(root + "/" + GetParam() + ".expected");
  ASSERT_FALSE(expected.empty());
  EXPECT_EQ(made.render(scene()), expected);
}

INSTANTIATE_TEST_SUITE_P(Languages, Golden,
                         testing::Values("sphere.py", "sphere.edp", "sphere.geo", "sphere.lmp",
                                         "sphere.sh", "sphere.json", "sphere.html"));

}  // namespace
}  // namespace sandglass
