#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "../support/errors.hpp"
#include "base/file.hpp"
#include "workflow/json.hpp"
#include "workflow/model.hpp"

namespace sandglass::workflow {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string root = SANDGLASS_SOURCE_DIR;
const std::string scene = root + "/workflows/icy_stokes_sphere.yaml";

LoadOptions options(const std::vector<Setting>& settings = {}) {
  LoadOptions result;
  result.templates_root = root + "/templates";
  result.data_root = root + "/data";
  result.settings = settings;
  return result;
}

int skipped(const Workflow& workflow) {
  int count = 0;
  for (const Comparison& comparison : workflow.comparisons) {
    bool met = true;
    for (const HoldsFor& condition : comparison.holds_for) met = met && condition.met;
    if (!met) ++count;
  }
  return count;
}

TEST(Scene, EveryChoiceOfTheSphereLoads) {
  const Workflow defaults = load(scene, options());
  for (const Parameter& parameter : defaults.parameters) {
    for (const std::string& choice : parameter.choices) {
      // Aitken's factor alone is refused: it needs iterations.
      const std::string scheme = choice == "aitken" ? "serial-implicit" : "serial-explicit";
      std::vector<Setting> settings = {{parameter.name, choice}};
      if (parameter.name != "scheme") settings.push_back({"scheme", scheme});
      EXPECT_NO_THROW((void)load(scene, options(settings))) << choice;
    }
    EXPECT_FALSE(parameter.meaning.empty()) << parameter.name;
    EXPECT_FALSE(parameter.source.empty()) << parameter.name;
  }
  EXPECT_EQ(defaults.coupling->windows, 30);
  EXPECT_EQ(skipped(defaults), 0);
  EXPECT_THAT(defaults.coupling->fields_left_out, ElementsAre("position"));
}

TEST(Scene, PublishedNumbersAreSkippedAwayFromTheirParameters) {
  const Workflow other = load(scene, options({{"density", "2500 kg/m3"}}));
  int published = 0;
  for (const Comparison& comparison : other.comparisons) {
    if (comparison.source.empty()) continue;
    ++published;
    EXPECT_FALSE(comparison.holds_for.empty()) << comparison.name;
    bool met = true;
    for (const HoldsFor& condition : comparison.holds_for) met = met && condition.met;
    EXPECT_FALSE(met) << comparison.name;
  }
  EXPECT_EQ(published, 2);
}

TEST(Scene, WhatChangesAParticipantIsInItsJson) {
  const std::string erosion = root + "/workflows/icy_erosion.yaml";
  const auto participants = [&](const std::string& name, const std::string& value) {
    const std::string dem = name == "ranks" ? "lammps" : "yade";
    return to_json(load(erosion, options({{"dem", dem}, {name, value}}))).at("participants").dump();
  };
  for (const char* name : {"threads", "ranks"}) {
    EXPECT_NE(participants(name, "1"), participants(name, "2")) << name;
  }
}

TEST(Scene, OtherSpheresAndFluidsLoad) {
  const std::vector<std::vector<Setting>> cases = {
      {{"diameter", "1 um"}, {"density", "1001"}},
      {{"density", "900"}},
      {{"fluid_density", "0"}},
      {{"viscosity", "1e-6"}},
      {{"viscosity", "1000 Pa s"}},
      {{"window", "1e-9 s"}, {"end_time", "1 us"}},
      {{"window", "0.7 ms"}},
      {{"end_time", "0.1 ms"}},
      {{"numerical_damping", "0.509"}},
      {{"fluid", "box"}, {"quarter", "false"}, {"process", "fresh"}, {"exchange", "file"}}};
  for (const auto& settings : cases) {
    EXPECT_NO_THROW((void)load(scene, options(settings))) << settings[0].name << settings[0].text;
  }
}

TEST(Scene, ImpossibleSpheresAreRefused) {
  const std::vector<Setting> cases = {
      {"diameter", "0"},    {"density", "-1"},    {"viscosity", "0"},        {"window", "0"},
      {"end_time", "0"},    {"window", "1 Pa s"}, {"fluid", "boks"},         {"quarter", "perhaps"},
      {"grain_steps", "0"}, {"scheme", "serial"}, {"numerical_damping", "1"}};
  for (const Setting& setting : cases) {
    const Error error = test::error_of([&] { (void)load(scene, options({setting})); });
    EXPECT_EQ(error.code(), ExitCode::refused) << setting.name;
    EXPECT_EQ(error.problems()[0].place.file, "command line (--set " + setting.name + ")");
  }
}

TEST(Scene, TheJsonHoldsWhatARunUses) {
  const Workflow workflow = load(scene, options({{"diameter", "0.2 mm"}, {"fluid", "box"}}));
  const nlohmann::ordered_json json = to_json(workflow);
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["parameters"]["diameter"]["value"], 2e-4);
  EXPECT_EQ(json["parameters"]["diameter"]["shown"], "0.2 mm");
  EXPECT_EQ(json["parameters"]["diameter"]["overridden"], true);
  EXPECT_EQ(json["parameters"]["fluid"]["value"], "box");
  EXPECT_EQ(json["coupling"]["windows"], 30);
  EXPECT_EQ(json["participants"][1]["given"]["mesh"]["stage"], "convert");
  EXPECT_EQ(json["stages"][0]["run"], "gmsh");
  EXPECT_EQ(json["left_out"][0]["what"], "fluid solve, windows 2 to 30");
  EXPECT_EQ(json["comparisons"].size(), workflow.comparisons.size());
  EXPECT_EQ(nlohmann::ordered_json::parse(json.dump()), json);
}

/// Small changes such as a hand or a disk makes: whatever comes out, it is an Error or a workflow.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::string mutate(std::string text) {
    const int changes = number(1, 4);
    for (int i = 0; i < changes; ++i) change(text);
    return text;
  }

 private:
  int number(int from, int to) { return std::uniform_int_distribution<int>(from, to)(random_); }
  size_t position(const std::string& text) {
    return static_cast<size_t>(number(0, static_cast<int>(text.size()) - 1));
  }

  void change(std::string& text) {
    static const std::vector<std::string> pieces = {
        "{",      "}",     "[",    "]",        ": ",   "- ",   "\n",   "\n  ",
        "\t",     "'",     "\"",   "#",        "&a ",  "*a",   "!!x ", "$",
        "$a",     "1e999", "-1",   "nan",      "~",    "null", "|",    ">-",
        "<<",     "%",     "\xff", "\xc3\xa9", "\x01", "0",    " mm",  "choose: fluid\n",
        "window", "? "};
    const size_t at = position(text);
    switch (number(0, 5)) {
      case 0:
        text[at] = static_cast<char>(number(0, 255));
        break;
      case 1:
        text.erase(at, static_cast<size_t>(number(1, 40)));
        break;
      case 2:
        text.insert(at,
                    pieces[static_cast<size_t>(number(0, static_cast<int>(pieces.size()) - 1))]);
        break;
      case 3:  // a piece from elsewhere
        text.insert(at, text.substr(position(text), static_cast<size_t>(number(1, 200))));
        break;
      case 4:  // a line less
        if (const size_t begin = text.find('\n', at); begin != std::string::npos) {
          text.erase(begin, text.find('\n', begin + 1) - begin);
        }
        break;
      default:  // the end lost
        if (number(0, 9) == 0) text.resize(at + 1);
    }
    if (text.empty()) text = "a";
  }

  std::mt19937 random_;
};

TEST(Scene, MutantsLoadOrAreRefused) {
  const std::string original = read_file(scene);
  Mutator mutator(20250101);
  std::map<bool, int> outcomes;
  for (int i = 0; i < 2000; ++i) {
    const std::string mutant = mutator.mutate(original);
    try {
      (void)load_text(mutant, "mutant.yaml", options({{"density", "2500"}}));
      ++outcomes[true];
    } catch (const Error& error) {
      ++outcomes[false];
      ASSERT_TRUE(error.code() == ExitCode::refused || error.code() == ExitCode::usage) << mutant;
      ASSERT_FALSE(error.problems().empty());
      for (const Problem& problem : error.problems()) ASSERT_FALSE(problem.what.empty());
    }
  }
  // Both must happen, or the mutations are too wild or too tame to test anything.
  EXPECT_GT(outcomes[true], 100);
  EXPECT_GT(outcomes[false], 500);
}

}  // namespace
}  // namespace sandglass::workflow
