#include <gmock/gmock.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include "template_helpers.hpp"

namespace sandglass {
namespace {

using List = Value::List;
using testing::HasSubstr;

constexpr Language languages[] = {Language::python, Language::freefem, Language::gmsh,
                                  Language::lammps, Language::shell,   Language::json,
                                  Language::html,   Language::text};
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();

struct Case {
  Value value;
  // In the order of `languages`; nullptr: refused.
  const char* expected[8];
};

TEST(Quote, WritesEveryTypeInEveryLanguage) {
  const std::vector<Case> cases{
      {1.0, {"1.0", "1.0", "1.0", "1.0", "1", "1", "1", "1"}},
      {0.1, {"0.1", "0.1", "0.1", "0.1", "0.1", "0.1", "0.1", "0.1"}},
      {1e-6, {"1e-06", "1e-06", "1e-06", "1e-06", "1e-06", "1e-06", "1e-06", "1e-06"}},
      {1e22, {"1e+22", "1e+22", "1e+22", "1e+22", "1e+22", "1e+22", "1e+22", "1e+22"}},
      {-2.0, {"(-2.0)", "(-2.0)", "(-2.0)", "-2.0", "-2", "-2", "-2", "-2"}},
      {-0.0, {"(-0.0)", "(-0.0)", "(-0.0)", "-0.0", "-0", "-0", "-0", "-0"}},
      {std::nan(""), {}},
      {infinity, {}},
      {-infinity, {}},
      {42, {"42", "42", "42", "42", "42", "42", "42", "42"}},
      {-3, {"(-3)", "(-3)", "(-3)", "-3", "-3", "-3", "-3", "-3"}},
      {most,
       {"9223372036854775807", nullptr, nullptr, "9223372036854775807", "9223372036854775807",
        "9223372036854775807", "9223372036854775807", "9223372036854775807"}},
      {true, {"True", "true", "1", "yes", "true", "true", "true", "true"}},
      {false, {"False", "false", "0", "no", "false", "false", "false", "false"}},
      {"word", {"'word'", "\"word\"", "\"word\"", "word", "'word'", "\"word\"", "word", "word"}},
      {"", {"''", "\"\"", "\"\"", nullptr, "''", "\"\"", "", ""}},
      {"two words",
       {"'two words'", "\"two words\"", "\"two words\"", nullptr, "'two words'", "\"two words\"",
        "two words", "two words"}},
      {"it's",
       {"'it\\x27s'", "\"it's\"", "\"it's\"", nullptr, "'it'\\''s'", "\"it's\"", "it&#39;s",
        "it's"}},
      {"a\"b",
       {"'a\\x22b'", "\"a\\\"b\"", "'a\"b'", nullptr, "'a\"b'", "\"a\\\"b\"", "a&quot;b", "a\"b"}},
      {"\"'",
       {"'\\x22\\x27'", "\"\\\"'\"", nullptr, nullptr, "'\"'\\'''", "\"\\\"'\"", "&quot;&#39;",
        "\"'"}},
      {"a\\b", {"'a\\x5cb'", nullptr, "\"a\\b\"", nullptr, "'a\\b'", "\"a\\\\b\"", "a\\b", "a\\b"}},
      {"{x}", {"'\\x7bx\\x7d'", "\"{x}\"", "\"{x}\"", nullptr, "'{x}'", "\"{x}\"", "{x}", "{x}"}},
      {"a\nb",
       {"'a\\x0ab'", "\"a\\nb\"", nullptr, nullptr, nullptr, "\"a\\u000ab\"", "a\nb", "a\nb"}},
      {"é日😀", {"'é日😀'", nullptr, "\"é日😀\"", nullptr, "'é日😀'", "\"é日😀\"", "é日😀", "é日😀"}},
      {"\u202e\u00a0\U000E0001",
       {"'\\u202e\\xa0\\U000e0001'", nullptr, "\"\u202e\u00a0\U000E0001\"", nullptr,
        "'\u202e\u00a0\U000E0001'", "\"\u202e\u00a0\U000E0001\"", "\u202e\u00a0\U000E0001",
        "\u202e\u00a0\U000E0001"}},
      {"a//b", {"'a//b'", "\"a/\\/b\"", "\"a//b\"", "a//b", "'a//b'", "\"a//b\"", "a//b", "a//b"}},
      {"x ENDIFMACRO",
       {"'x ENDIFMACRO'", nullptr, "\"x ENDIFMACRO\"", nullptr, "'x ENDIFMACRO'",
        "\"x ENDIFMACRO\"", "x ENDIFMACRO", "x ENDIFMACRO"}},
      {"x/EndIf1",
       {"'x/EndIf1'", "\"x/EndIf1\"", nullptr, "x/EndIf1", "'x/EndIf1'", "\"x/EndIf1\"", "x/EndIf1",
        "x/EndIf1"}},
      {"Elsevier",
       {"'Elsevier'", "\"Elsevier\"", "\"Elsevier\"", "Elsevier", "'Elsevier'", "\"Elsevier\"",
        "Elsevier", "Elsevier"}},
      {"coding: utf-7",
       {"'coding\\x3a utf-7'", "\"coding: utf-7\"", "\"coding: utf-7\"", nullptr, "'coding: utf-7'",
        "\"coding: utf-7\"", "coding: utf-7", "coding: utf-7"}},
      {"<&>", {"'<&>'", "\"<&>\"", "\"<&>\"", nullptr, "'<&>'", "\"<&>\"", "&lt;&amp;&gt;", "<&>"}},
      {"$x", {"'$x'", "\"$x\"", "\"$x\"", nullptr, "'$x'", "\"$x\"", "$x", "$x"}},
      {Value::Choice{"box", {"box"}},
       {"'box'", "\"box\"", "\"box\"", "box", "'box'", "\"box\"", "box", "box"}},
      {Value::Markup{"<b>"},
       {nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, "<b>", nullptr}},
      {List{1.0, -2, true},
       {"[1.0, -2, True]", "[1.0, -2, true]", "{1.0, -2, 1}", "1.0 -2 yes", "1 -2 true",
        "[1, -2, true]", nullptr, nullptr}},
      {List{}, {"[]", nullptr, "{}", nullptr, "", "[]", nullptr, nullptr}},
      {List{"a", "b"},
       {"['a', 'b']", "[\"a\", \"b\"]", nullptr, "a b", "'a' 'b'", "[\"a\", \"b\"]", nullptr,
        nullptr}},
      {List{List{1}, List{2}},
       {"[[1], [2]]", "[[1], [2]]", nullptr, nullptr, nullptr, "[[1], [2]]", nullptr, nullptr}},
      {List{Value()}, {}},
      {Value::Map{{"a", 1}}, {}},
      {Value(), {}},
      {"\xff", {nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, "\xff"}},
      {"\xed\xa0\x80",
       {nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, "\xed\xa0\x80"}},
      {"\xc0\xaf", {nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, "\xc0\xaf"}},
  };
  for (size_t row = 0; row < cases.size(); ++row) {
    for (size_t i = 0; i < std::size(languages); ++i) {
      const char* expected = cases[row].expected[i];
      std::string written;
      const std::string refused = refusal([&] { written = quote(cases[row].value, languages[i]); });
      const std::string where =
          "row " + std::to_string(row) + ", language " + std::to_string(i) + ": " + refused;
      EXPECT_EQ(refused.empty(), expected != nullptr) << where << written;
      if (expected) {
        EXPECT_EQ(written, expected) << where;
      }
    }
  }
}

TEST(Quote, SplitsOrRefusesLongTexts) {
  const std::string longest(255, 'a');
  EXPECT_EQ(quote(longest, Language::freefem), '"' + longest + '"');
  EXPECT_EQ(quote(longest + "bc", Language::freefem), "(\"" + longest + "\"+\"bc\")");
  EXPECT_EQ(quote(std::string(1023, 'a'), Language::gmsh).size(), 1025U);
  EXPECT_THAT(refusal([] { (void)quote(std::string(1024, 'a'), Language::gmsh); }),
              HasSubstr("at most 1023 bytes"));
}

TEST(Quote, RefusesEndlessNesting) {
  Value nested(List{});
  for (int i = 0; i < 150; ++i) nested = Value(List{nested});
  EXPECT_THAT(refusal([&] { (void)quote(nested, Language::python); }), HasSubstr("nested deeper"));
}

TEST(Quote, NumbersReadBackAsTheSameDouble) {
  for (const double number :
       {0.1, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, 123456789.12345678, 2.2250738585072014e-308,
        9.80665, 1e15, 1e16, 1e17, 4503599627370497.5}) {
    const std::string written = quote(number, Language::python);
    double back = 0;
    std::from_chars(written.data(), written.data() + written.size(), back);
    EXPECT_EQ(back, number);
    EXPECT_NE(written.find_first_of(".e"), std::string::npos) << written;
  }
}

TEST(Language, IsThatOfTheEnding) {
  EXPECT_EQ(language_of("yade/a.py"), Language::python);
  EXPECT_EQ(language_of("a.edp"), Language::freefem);
  EXPECT_EQ(language_of("a.idp"), Language::freefem);
  EXPECT_EQ(language_of("a.geo"), Language::gmsh);
  EXPECT_EQ(language_of("in.lmp"), Language::lammps);
  EXPECT_EQ(language_of("a.in"), Language::lammps);
  EXPECT_EQ(language_of("a.sbatch"), Language::shell);
  EXPECT_EQ(language_of("a.json"), Language::json);
  EXPECT_EQ(language_of("a.html"), Language::html);
  EXPECT_EQ(language_of("a.py.txt"), Language::text);
  EXPECT_EQ(language_of(""), Language::text);
}

}  // namespace
}  // namespace sandglass
