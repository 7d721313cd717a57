#include "study/made_of.hpp"

#include <gmock/gmock.h>

namespace sandglass::study {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

MadeOf some() {
  MadeOf made_of;
  made_of.parts = {{"participant fluid", std::string(64, 'a')},
                   {"template freefem/a.edp", std::string(64, 'b')},
                   {"solver yade", "2023.02a-1"}};
  made_of.parameters = {{"density", "2650 kg/m3"}, {"spare", "1"}};
  return made_of;
}

TEST(Differences, TheSameHasNone) { EXPECT_THAT(differences(some(), some()), IsEmpty()); }

TEST(Differences, AParameterThatNothingUsesIsNone) {
  MadeOf now = some();
  now.parameters["spare"] = "2";
  EXPECT_THAT(differences(some(), now), IsEmpty());
  EXPECT_EQ(key_of(some()), key_of(now));
}

TEST(Differences, AParameterIsNamedInPlaceOfWhatItActsThrough) {
  MadeOf now = some();
  now.parameters["density"] = "2500 kg/m3";
  now.parts["participant fluid"] = std::string(64, 'c');
  EXPECT_THAT(differences(some(), now), ElementsAre("parameter density: 2650 kg/m3 -> 2500 kg/m3"));
  EXPECT_NE(key_of(some()), key_of(now));
}

TEST(Differences, WithoutAChangedParameterThePartIsNamed) {
  MadeOf now = some();
  now.parts["participant fluid"] = std::string(64, 'c');
  EXPECT_THAT(differences(some(), now), ElementsAre("participant fluid changed"));
}

TEST(Differences, VersionsAreShownDigestsAreNot) {
  MadeOf now = some();
  now.parts["solver yade"] = "2024.01-1";
  now.parts["template freefem/a.edp"] = std::string(64, 'd');
  now.parts["data x.csv"] = std::string(64, 'e');
  EXPECT_THAT(differences(some(), now),
              ElementsAre("data x.csv is new", "solver yade: 2023.02a-1 -> 2024.01-1",
                          "template freefem/a.edp changed"));
  EXPECT_THAT(differences(now, some()),
              ElementsAre("solver yade: 2024.01-1 -> 2023.02a-1", "template freefem/a.edp changed",
                          "data x.csv is gone"));
}

TEST(MadeOfJson, ComesBackAsItWas) {
  const MadeOf read = made_of_from_json(to_json(some()));
  EXPECT_EQ(read.parts, some().parts);
  EXPECT_EQ(read.parameters, some().parameters);
  EXPECT_THAT(made_of_from_json("{\"format\": 1, \"parts\": 3}").parts, IsEmpty());
  EXPECT_THAT(made_of_from_json("not JSON").parts, IsEmpty());
}

}  // namespace
}  // namespace sandglass::study
