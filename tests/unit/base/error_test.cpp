#include "base/error.hpp"

#include <gtest/gtest.h>

namespace sandglass {
namespace {

TEST(Place, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ((Place{"a.yaml", 3, 7}).text(), "a.yaml:3:7");
  EXPECT_EQ((Place{"a.yaml", 3, 0}).text(), "a.yaml:3");
  EXPECT_EQ((Place{"a.yaml", 0, 0}).text(), "a.yaml");
  EXPECT_EQ(Place{}.text(), "");
}

TEST(Problem, SaysWhereWhatAndWhatToDo) {
  EXPECT_EQ((Problem{{"a.yaml", 3, 7}, "wrong", "right it"}).text(), "a.yaml:3:7: wrong; right it");
  EXPECT_EQ((Problem{{}, "wrong", "right it"}).text(), "wrong; right it");
  EXPECT_EQ((Problem{{"a.yaml", 3, 7}, "wrong", ""}).text(), "a.yaml:3:7: wrong");
}

TEST(Error, HasOneLineForEveryProblem) {
  const Error error = Error::refused({{{"a", 1, 2}, "first", ""}, {{"b", 3, 4}, "second", "do"}});
  EXPECT_STREQ(error.what(), "a:1:2: first\nb:3:4: second; do");
  EXPECT_EQ(error.problems().size(), 2U);
}

// Scripts depend on the numbers: they are in the documentation of every verb.
TEST(Error, NamedConstructorsSetTheExitCode) {
  const auto number = [](const Error& error) { return static_cast<int>(error.code()); };
  EXPECT_EQ(number(Error::usage("x")), 2);
  EXPECT_EQ(number(Error::refused(Place{}, "x")), 3);
  EXPECT_EQ(number(Error::participant("x")), 4);
  EXPECT_EQ(number(Error::unstable("x")), 5);
  EXPECT_EQ(number(Error::mismatch("x")), 6);
  EXPECT_EQ(number(Error::environment("x")), 7);
  EXPECT_EQ(number(Error::interrupted("x")), 130);
  EXPECT_STREQ(Error::environment("gone", "get it").what(), "gone; get it");
}

TEST(Nearest, FindsTypingErrorsAndNothingElse) {
  const std::vector<std::string> names{"diameter", "density", "viscosity"};
  EXPECT_EQ(nearest("diametre", names), "diameter");
  EXPECT_EQ(nearest("densty", names), "density");
  EXPECT_EQ(nearest("density", names), "density");
  EXPECT_EQ(nearest("temperature", names), "");
  EXPECT_EQ(nearest("", names), "");
  EXPECT_EQ(nearest("x", {}), "");
  EXPECT_EQ(nearest(std::string(10'000, 'd'), names), "");
}

TEST(Suggestion, NamesTheNearestOrAll) {
  EXPECT_EQ(suggestion("densty", {"density", "window"}), "did you mean 'density'?");
  EXPECT_EQ(suggestion("temperature", {"density", "window"}), "valid: density, window");
  EXPECT_EQ(suggestion("x", {}), "nothing is valid here");
}

}  // namespace
}  // namespace sandglass
