#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "project.hpp"

namespace sandglass::workflow {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string tail = R"(stages:
  prepare: {run: python, template: python/empty.py}
)";

std::string with(const std::string& parameters) {
  return "sandglass: 1\nname: test\nparameters:\n" + parameters + tail;
}

class Parameters : public testing::Test {
 protected:
  [[nodiscard]] double number(const std::string& declaration) const {
    return *project.load(with("  x: " + declaration + "\n")).parameter("x")->value.as<double>();
  }
  [[nodiscard]] Parameter one(const std::string& declaration,
                              const std::vector<Setting>& settings = {}) const {
    return *project.load(with("  x: " + declaration + "\n"), settings).parameter("x");
  }
  [[nodiscard]] std::vector<std::string> wrong(const std::string& declaration) const {
    return project.problems(with("  x: " + declaration + "\n"));
  }
  /// what; remedy of the one thing wrong with --set x=text
  [[nodiscard]] std::string refused(const std::string& declaration, const std::string& text) const {
    const Error error = test::error_of([&] { (void)one(declaration, {{"x", text}}); });
    EXPECT_EQ(error.code(), ExitCode::refused);
    EXPECT_EQ(error.problems().size(), 1U);
    EXPECT_EQ(error.problems()[0].place.text(), "command line (--set x)");
    return error.what();
  }
  Project project;
};

TEST_F(Parameters, NumbersAreSiAndABareNumberIsSiAlready) {
  EXPECT_EQ(number("{value: 0.1 mm, unit: mm}"), 1e-4);
  EXPECT_EQ(number("{value: 0.1, unit: mm}"), 0.1);
  EXPECT_EQ(number("{value: \"23 cm\", unit: mm}"), 0.23);
  EXPECT_DOUBLE_EQ(number("{value: 180 deg}"), M_PI);
  EXPECT_DOUBLE_EQ(number("{value: 5 %}"), 0.05);
  EXPECT_DOUBLE_EQ(number("{value: 2.65 g/cm3, unit: kg/m3}"), 2650);
  EXPECT_DOUBLE_EQ(number("{value: 20 degC, unit: K}"), 293.15);
}

TEST_F(Parameters, TypesAreInferredWhereObvious) {
  EXPECT_EQ(one("{value: 3}").type, Parameter::Type::number);
  EXPECT_EQ(one("{value: 3, type: count}").type, Parameter::Type::count);
  EXPECT_EQ(one("{value: true}").type, Parameter::Type::toggle);
  EXPECT_EQ(one("{value: 'true'}").type, Parameter::Type::text);
  EXPECT_EQ(one("{value: a, choices: [a, b]}").type, Parameter::Type::choice);
  EXPECT_EQ(one("{value: hello}").type, Parameter::Type::text);
  EXPECT_EQ(one("{value: 2D}").type, Parameter::Type::text) << "not two days";
  EXPECT_EQ(one("{value: '3 furlings'}").type, Parameter::Type::text);
  EXPECT_EQ(one("{value: 3 ms}").unit, "ms") << "the unit it is written in";
}

TEST_F(Parameters, TakeTheirValueFromTheCaseOfAChoice) {
  const std::string text = with(
      "  scale: {value: full, choices: [small, full]}\n"
      "  end: {value: 48 s, above: 0, choose: scale, cases: {small: {value: 2 s}, full: {}}}\n");
  const auto end = [&](const std::vector<Setting>& settings) {
    return *project.load(text, settings).parameter("end")->value.as<double>();
  };
  EXPECT_EQ(end({}), 48);
  EXPECT_EQ(end({{"scale", "small"}}), 2);
  EXPECT_EQ(end({{"scale", "small"}, {"end", "3 s"}}), 3) << "what is set counts";
}

TEST_F(Parameters, ACaseMayChooseAgain) {
  const std::string choices =
      "  scale: {value: full, choices: [small, full]}\n"
      "  sides: {value: walls, choices: [walls, periodic]}\n";
  const std::string text = with(choices +
                                "  end: {value: 48 s, above: 0, choose: scale, cases: {full: {}, "
                                "otherwise: {choose: sides, cases: {walls: {value: 2 s}, periodic: "
                                "{value: 3 s}}}}}\n");
  const auto end = [&](const std::vector<Setting>& settings) {
    return *project.load(text, settings).parameter("end")->value.as<double>();
  };
  EXPECT_EQ(end({}), 48);
  EXPECT_EQ(end({{"sides", "periodic"}}), 48);
  EXPECT_EQ(end({{"scale", "small"}}), 2);
  EXPECT_EQ(end({{"scale", "small"}, {"sides", "periodic"}}), 3);
  EXPECT_THAT(
      project.problems(with(choices + "  end: {value: 48 s, above: 0, choose: scale, cases: {full: "
                                      "{}, small: {choose: sides, cases: {walls: {}, periodic: "
                                      "{value: -3 s}}}}}\n")),
      ElementsAre(HasSubstr("'end' is -3 s")))
      << "every case of every case is checked";
  EXPECT_THAT(project.problems(with(choices +
                                    "  end: {value: 48 s, choose: scale, cases: {full: {}, small: "
                                    "{choose: sides, cases: {walls: {}}}}}\n")),
              ElementsAre(HasSubstr("no case for choice 'periodic' of 'sides'")));
}

TEST_F(Parameters, CasesWithinCasesEnd) {
  // Ten choices, and a case for all others within each: ten to the twentieth variants in a line.
  std::string parameters;
  std::string end = "{value: 1 s}";
  for (int i = 0; i < 20; ++i) {
    parameters += fmt::format("  p{}: {{value: a, choices: [a, b, c, d, e, f, g, h, i, j]}}\n", i);
    end = fmt::format("{{choose: p{}, cases: {{otherwise: {}}}}}", i, end);
  }
  EXPECT_THAT(
      project.problems(
          with(parameters + "  end: {value: 2 s, choose: p0, cases: {otherwise: " + end + "}}\n")),
      ElementsAre(HasSubstr("its cases within cases are more than 1000")));
}

TEST_F(Parameters, EveryCaseIsCheckedAndTheChoiceComesFirst) {
  const std::string scale = "  scale: {value: full, choices: [small, full]}\n";
  EXPECT_THAT(project.problems(with(scale + "  end: {value: 48 s, above: 0, choose: scale, cases: "
                                            "{small: {value: -2 s}, full: {}}}\n")),
              ElementsAre(HasSubstr("'end' is -2 s")));
  EXPECT_THAT(project.problems(with("  end: {value: 48 s, choose: scale, cases: {small: {value: 2 "
                                    "s}, full: {}}}\n" +
                                    scale)),
              ElementsAre(HasSubstr("there is no parameter 'scale'")));
}

TEST_F(Parameters, MayLimitEachOther) {
  const std::string text = with(
      "  beam: {value: 10 mm, unit: mm, above: 0}\n"
      "  grid: {value: 3 cm, minimum: $beam}\n");
  EXPECT_NO_THROW((void)project.load(text, {{"beam", "30 mm"}}));
  for (const Setting& setting : {Setting{"beam", "31 mm"}, Setting{"grid", "9 mm"}}) {
    const Error error = test::error_of([&] { (void)project.load(text, {setting}); });
    EXPECT_EQ(error.code(), ExitCode::refused);
    EXPECT_THAT(error.what(), HasSubstr("command line (--set " + setting.name + ")"));
    EXPECT_THAT(error.what(), HasSubstr("minimum: 'beam', which is"));
  }
  const std::string in_a_case = with(
      "  scale: {value: full, choices: [small, full]}\n  beam: {value: 10 mm, unit: mm}\n"
      "  grid: {value: 5 mm, choose: scale, cases: {small: {minimum: $beam}, full: {above: 0}}}\n");
  EXPECT_NO_THROW((void)project.load(in_a_case));
  EXPECT_THROW((void)project.load(in_a_case, {{"scale", "small"}}), Error);
  EXPECT_THAT(project.problems(with("  a: {value: 1 mm, below: $b}\n  b: {value: 1 kg}\n")),
              ElementsAre(HasSubstr("'b' is no limit for 'a'")));
  EXPECT_THAT(project.problems(with("  a: {value: 1 mm, below: $c}\n")),
              ElementsAre(HasSubstr("there is no parameter 'c'")));
}

TEST_F(Parameters, AreShownInTheirUnit) {
  EXPECT_EQ(shown(one("{value: 0.1 mm, unit: mm}")), "0.1 mm");
  EXPECT_EQ(shown(one("{value: 17.19 deg, unit: deg}")), "17.19 deg");
  EXPECT_EQ(shown(one("{value: 0.3 mm, unit: mm}")), "0.3 mm");
  EXPECT_EQ(shown(one("{value: 1e-3 Pa s, unit: Pa s}")), "0.001 Pa s");
  EXPECT_EQ(shown(one("{value: 0.5}")), "0.5");
  EXPECT_EQ(shown(one("{value: 7, type: count}")), "7");
  EXPECT_EQ(shown(one("{value: false}")), "false");
  EXPECT_EQ(shown(one("{value: b, choices: [a, b]}")), "b");
}

TEST_F(Parameters, ShownReadsBackAsTheSameNumber) {
  for (const char* text : {"0.1 mm", "0.7 mm", "3.3 cm", "17.19 deg", "1e-300 mm", "123.456 kPa"}) {
    const Parameter first = one(std::string("{value: ") + text + "}");
    const Parameter again = one(std::string("{value: ") + shown(first) + "}");
    EXPECT_EQ(*first.value.as<double>(), *again.value.as<double>()) << text;
  }
}

TEST_F(Parameters, WrongDeclarationsAreRefusedInOnePass) {
  EXPECT_THAT(project.problems(with(R"(  a: {value: 3 kg, unit: mm}
  b: {value: 3 furlings}
  c: {value: 3, unit: furlings}
  d: {value: maybe, type: switch}
  e: {value: c, choices: [a, b]}
  f: {value: 1.5, type: count}
  g: {value: -1 mm, unit: mm, above: 0}
  h: {value: $g}
  i: {unit: mm}
  j: {value: 1, choises: [a]}
  k: {value: x, unit: mm}
  l: {value: 1, minimum: 0 kg, maximum: 2}
  m: {value: a, choices: [a, a, "b c"]}
  n: {value: true, unit: mm}
  o: {value: true, maximum: 1}
  p: 0.1 mm
)")),
              ElementsAre("w.yaml:4:14: 'a': unit 'kg' does not fit mm",  //
                          "w.yaml:5:14: 'b': unknown unit 'furlings'",    //
                          "w.yaml:6:23: unknown unit 'furlings'",         //
                          "w.yaml:7:14: 'd': 'maybe' is not a switch",
                          "w.yaml:8:14: 'e': 'c' is not a choice of 'e'",
                          "w.yaml:9:14: 'f': '1.5' is not a count",  //
                          "w.yaml:10:14: 'g' is -1 mm",
                          "w.yaml:11:14: the value of a parameter cannot be another parameter",
                          "w.yaml:12:3: a parameter needs 'value'",
                          "w.yaml:13:17: a parameter has no key 'choises'",
                          "w.yaml:14:14: 'k': 'x' is not a number",
                          "w.yaml:15:26: unit 'kg' does not fit a number without a unit",
                          "w.yaml:16:30: choice 'a' is listed twice",
                          "w.yaml:16:33: 'b c' cannot be a choice",
                          "w.yaml:17:14: 'n': 'true' is not a number",
                          "w.yaml:18:29: 'maximum' fits numbers and counts only",
                          "w.yaml:19:6: 'p' must be a map"));
}

TEST_F(Parameters, LimitsIncludeOrExcludeTheirEnds) {
  EXPECT_EQ(number("{value: 1, minimum: 1, maximum: 1}"), 1);
  EXPECT_THAT(wrong("{value: 1 mm, above: 1 mm}"), ElementsAre("w.yaml:4:14: 'x' is 1 mm"));
  EXPECT_THAT(wrong("{value: 1 mm, below: 0.001}"), ElementsAre("w.yaml:4:14: 'x' is 1 mm"));
  EXPECT_THAT(wrong("{value: 2, type: count, maximum: 1}"), ElementsAre("w.yaml:4:14: 'x' is 2"));
}

TEST_F(Parameters, SettingsReplaceValues) {
  const Parameter set = one("{value: 0.1 mm, unit: mm}", {{"x", "25 um"}});
  EXPECT_DOUBLE_EQ(*set.value.as<double>(), 25e-6);
  EXPECT_TRUE(set.overridden);
  EXPECT_EQ(*one("{value: 0.1 mm, unit: mm}", {{"x", "25"}}).value.as<double>(), 25) << "SI";
  EXPECT_EQ(*one("{value: true}", {{"x", "false"}}).value.as<bool>(), false);
  EXPECT_EQ(one("{value: a, choices: [a, b]}", {{"x", "b"}}).value.as<Value::Choice>()->name, "b");
  EXPECT_EQ(*one("{value: 1, type: count}", {{"x", "12"}}).value.as<std::int64_t>(), 12);
  const std::string hostile = "'); import os; os.system(\"true\") #";
  EXPECT_EQ(*one("{value: a}", {{"x", hostile}}).value.as<std::string>(), hostile);
}

TEST_F(Parameters, WrongSettingsSayWhatWouldBeRight) {
  const std::string length = "{value: 0.1 mm, unit: mm, above: 0}";
  EXPECT_EQ(
      refused(length, "3 kg"),
      "command line (--set x): 'x': unit 'kg' does not fit mm; write a number with a unit, such "
      "as 0.1 mm; a bare number is SI");
  EXPECT_THAT(refused(length, "abc"), HasSubstr("'abc' is not a number"));
  EXPECT_THAT(refused(length, ""), HasSubstr("'' is not a number"));
  EXPECT_THAT(refused(length, "nan"), HasSubstr("'nan' is not a number"));
  EXPECT_THAT(refused(length, "inf"), HasSubstr("'inf' is not a number"));
  EXPECT_THAT(refused(length, "1e999"), HasSubstr("out of range"));
  EXPECT_THAT(refused(length, "1e308 km"), HasSubstr("out of range"));
  EXPECT_THAT(refused(length, "0"), HasSubstr("'x' is 0 mm; above: 0 mm"));
  EXPECT_THAT(refused(length, "-0"), HasSubstr("above: 0 mm"));
  EXPECT_THAT(refused(length, "$x"), HasSubstr("not a number"));
  EXPECT_THAT(refused("{value: true}", "yes"), HasSubstr("write true or false"));
  EXPECT_THAT(refused("{value: 1, type: count}", "1.0"), HasSubstr("not a count"));
  EXPECT_THAT(refused("{value: 1, type: count}", "-1"), HasSubstr("not a count"));
  EXPECT_THAT(refused("{value: 1, type: count}", "99999999999999999999"), HasSubstr("not a count"));
  EXPECT_THAT(refused("{value: box, choices: [box, ball]}", "bax"),
              HasSubstr("did you mean 'box'?"));
  EXPECT_THAT(refused("{value: 3 ms}", "1 kHz"), HasSubstr("does not fit"))
      << "hertz are no seconds";
}

TEST_F(Parameters, SettingsOfUnknownNamesAreUsageErrors) {
  const Error error = test::error_of([&] { (void)one("{value: 1}", {{"y", "2"}, {"x", "1"}}); });
  EXPECT_EQ(error.code(), ExitCode::usage);
  EXPECT_THAT(error.what(), HasSubstr("no parameter 'y'; did you mean 'x'?"));
  const Error twice = test::error_of([&] { (void)one("{value: 1}", {{"x", "2"}, {"x", "2"}}); });
  EXPECT_EQ(twice.code(), ExitCode::usage);
  const Error control = test::error_of([&] { (void)one("{value: a}", {{"x", "\x1b[0m"}}); });
  EXPECT_EQ(control.code(), ExitCode::usage);
}

TEST_F(Parameters, ExtremesOfDoublePrecisionPass) {
  EXPECT_EQ(number("{value: 1e308}"), 1e308);
  EXPECT_EQ(number("{value: 5e-324}"), 5e-324);
  EXPECT_TRUE(std::signbit(number("{value: -0.0}")));
  EXPECT_EQ(number("{value: 1e308, minimum: -1e308}"), 1e308);
}

}  // namespace
}  // namespace sandglass::workflow
