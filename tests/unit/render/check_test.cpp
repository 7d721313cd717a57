#include <gmock/gmock.h>

#include "template_helpers.hpp"

namespace sandglass {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using List = Value::List;
using Map = Value::Map;

std::vector<std::string> check(const std::string& text, const Map& values,
                               Language language = Language::text) {
  return texts(parsed(text, language).check(values, [](const std::string& name) {
    return Place{"w.yaml", static_cast<int>(name.size()), 3};
  }));
}

TEST(Check, IsSilentWhenAllIsWell) {
  EXPECT_THAT(check("{{a}}{{#s}}{{b}}{{/s}}", {{"a", 1}, {"s", false}, {"b", 2}}), ElementsAre());
}

TEST(Check, ReportsNamesNotGivenAndNamesNotUsed) {
  EXPECT_THAT(check("{{a}} {{diametre}}", {{"a", 1}, {"diameter", 2}, {"zzz", 3}}),
              ElementsAre("t.txt:1:7: 'diametre' is not given; did you mean 'diameter'?",
                          "w.yaml:8:3: 'diameter' is given to t.txt and never used there; "
                          "did you mean 'diametre'?",
                          HasSubstr("w.yaml:3:3: 'zzz' is given to t.txt and never used there")));
  EXPECT_THAT(check("", {{"x", 1}}), ElementsAre(HasSubstr("the template uses no names")));
  EXPECT_THAT(texts(parsed("").check({{"x", 1}}, {})), ElementsAre(HasSubstr("'x' is given")));
}

TEST(Check, UseInAnUntakenSectionIsUse) {
  EXPECT_THAT(check("{{^s}}{{a}}{{/s}}", {{"s", true}, {"a", 1}}), ElementsAre());
  EXPECT_THAT(check("{{#n}}{{a}}{{unknowable}}{{/n}}", {{"n", List{}}, {"a", 1}}), ElementsAre());
}

TEST(Check, AMembersNameIsNotTheOuterOne) {
  EXPECT_THAT(check("{{#p}}{{name}}{{/p}}", {{"p", List{Map{{"name", 1}}}}, {"name", 2}}),
              ElementsAre(HasSubstr("'name' is given to t.txt and never used")));
}

TEST(Check, ReportsValuesTheLanguageCannotHold) {
  EXPECT_THAT(
      check("a = {{a}};\nb = {{b}};", {{"a", "é"}, {"b", List{}}}, Language::freefem),
      ElementsAre(HasSubstr("t.txt:1:5: 'a' cannot be written: FreeFEM cannot hold"),
                  HasSubstr("t.txt:2:5: 'b' cannot be written: FreeFEM has no empty list")));
}

TEST(Check, ReportsWrongChoicesInEveryBranch) {
  const Value fluid(Value::Choice{"box", {"axisymmetric", "box"}});
  EXPECT_THAT(check("{{#fluid.box}}{{/fluid.box}}{{^fluid.box}}{{#fluid.axisymetric}}"
                    "{{/fluid.axisymetric}}{{/fluid.box}}",
                    {{"fluid", fluid}}),
              ElementsAre("t.txt:1:43: 'axisymetric' is not a choice of 'fluid'; "
                          "did you mean 'axisymmetric'?"));
}

TEST(Names, AreTheFirstPartsOfAllNames) {
  EXPECT_THAT(
      parsed("{{a.b}}{{#c}}{{d}}{{.}}{{/c}}{{> x}}", Language::text, {{"x.txt", "{{e}}"}}).names(),
      ElementsAre("a", "c", "d", "e"));
}

}  // namespace
}  // namespace sandglass
