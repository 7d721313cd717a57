#include <gmock/gmock.h>

#include "template_helpers.hpp"

// What templates become, after the mustache specification where it applies.
namespace sandglass {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using List = Value::List;
using Map = Value::Map;

struct Case {
  const char* name;
  const char* text;
  Map values;
  const char* expected;
};

TEST(Render, FollowsTheSpecification) {
  const Value numbers(List{1, 2, 3});
  const Value people(List{Map{{"name", "ann"}, {"age", 3}}, Map{{"name", "bob"}, {"age", 5}}});
  const std::vector<Case> cases{
      {"no tags", "Hello\n", {}, "Hello\n"},
      {"value", "a {{ x }} b", {{"x", "v"}}, "a v b"},
      {"member", "{{a.b.c}}", {{"a", Map{{"b", Map{{"c", 7}}}}}}, "7"},
      {"values side by side", "{{x}}{{x}}", {{"x", "v"}}, "vv"},
      {"brace behind a value", "{{{! }}{{x}}}", {{"x", 1}}, "refused"},
      {"value keeps its line", "  {{x}}\n", {{"x", "v"}}, "  v\n"},
      {"switch on", "{{#s}}yes{{/s}}{{^s}}no{{/s}}", {{"s", true}}, "yes"},
      {"switch off", "{{#s}}yes{{/s}}{{^s}}no{{/s}}", {{"s", false}}, "no"},
      {"absent", "{{#s}}yes{{/s}}{{^s}}no{{/s}}", {{"s", Value()}}, "no"},
      {"list", "{{#n}}<{{.}}>{{/n}}", {{"n", numbers}}, "<1><2><3>"},
      {"empty list", "{{#n}}{{.}}{{name}}{{/n}}{{^n}}none{{/n}}", {{"n", List{}}}, "none"},
      {"not empty", "{{^n}}none{{/n}}", {{"n", numbers}}, ""},
      {"list of maps",
       "{{#p}}{{name}} {{age}} {{o}};{{/p}}",
       {{"p", people}, {"o", "O"}},
       "ann 3 O;bob 5 O;"},
      {"list of lists",
       "{{#n}}({{#.}}{{.}}{{/.}}){{/n}}",
       {{"n", List{List{1, 2}, List{3}}}},
       "(12)(3)"},
      {"item before outer",
       "{{#p}}{{name}}{{/p}}{{name}}",
       {{"p", people}, {"name", "out"}},
       "annbobout"},
      {"map once", "{{#m}}{{a}}{{b}}{{/m}}{{^m}}no{{/m}}", {{"m", Map{{"a", 1}}}, {"b", 2}}, "12"},
      {"items inside map",
       "{{#m}}{{#n}}{{.}}{{a}}{{/n}}{{/m}}",
       {{"m", Map{{"a", "x"}, {"n", numbers}}}},
       "1x2x3x"},
      {"item through a switch",
       "{{#n}}{{#s}}{{.}}{{/s}}{{/n}}",
       {{"n", numbers}, {"s", true}},
       "123"},
      {"choice",
       "{{#c.a}}A{{/c.a}}{{#c.b}}B{{/c.b}}{{^c.a}}not a{{/c.a}} {{c}}",
       {{"c", Value::Choice{"b", {"a", "b"}}}},
       "Bnot a b"},
      {"section lines vanish", "a\n  {{#s}}\nb\n  {{/s}}  \nc\n", {{"s", true}}, "a\nb\nc\n"},
      {"section lines vanish with CRLF",
       "a\r\n{{#s}}\r\nb\r\n{{/s}}\r\nc",
       {{"s", true}},
       "a\r\nb\r\nc"},
      {"at both ends", "{{#s}}\na\n{{/s}}", {{"s", true}}, "a\n"},
      {"untaken lines vanish", "a\n{{#s}}\nb\n{{/s}}\nc\n", {{"s", false}}, "a\nc\n"},
      {"inline section stays", "a {{#s}}b{{/s}} c\n", {{"s", true}}, "a b c\n"},
      {"two tags in a line", "{{#s}} {{/s}}\n", {{"s", true}}, " \n"},
      {"comment", "a{{! b }}c", {}, "ac"},
      {"comment line", "a\n  {{! b\n  c }}\nd", {}, "a\nd"},
      {"comment with braces", "{{! } { {{ }}x", {}, "x"},
      {"nested", "{{#a}}{{#b}}x{{/b}}{{^b}}y{{/b}}{{/a}}", {{"a", true}, {"b", false}}, "y"},
      {"same name twice nested", "{{#a}}1{{#a}}2{{/a}}3{{/a}}4", {{"a", true}}, "1234"},
      {"text", "{{x}}", {{"x", "<&\"'\n"}}, "<&\"'\n"},
  };
  for (const Case& each : cases) {
    if (std::string(each.expected) == "refused") {
      EXPECT_THAT(parse_problems(each.text), testing::Not(ElementsAre())) << each.name;
      continue;
    }
    EXPECT_EQ(refusal([&] {
                EXPECT_EQ(parsed(each.text).render(each.values), each.expected) << each.name;
              }),
              "")
        << each.name;
  }
}

TEST(Render, PutsBuildingBlocksInPlaceWithTheirIndent) {
  const Blocks blocks{{"b.txt", "one {{x}}\n\n{{#s}}\n  two\n{{/s}}\n"},
                      {"c.txt", "c\n  {{> b}}\nd"},
                      {"d.txt", "{{x}} begins\n{{#s}}inline{{/s}}\n"}};
  const Map values{{"x", 5}, {"s", true}};
  EXPECT_EQ(parsed("{\n  {{> b}}\n}\n", Language::text, blocks).render(values),
            "{\n  one 5\n\n    two\n}\n");
  EXPECT_EQ(parsed("a {{> b}}.", Language::text, blocks).render(values), "a one 5\n\n  two\n.");
  EXPECT_EQ(parsed(" {{>c}}\n", Language::text, blocks).render(values),
            " c\n   one 5\n\n     two\n d");
  EXPECT_EQ(parsed("  {{> d.txt}}\nend", Language::text, blocks).render(values),
            "  5 begins\n  inline\nend");
}

TEST(Render, RefusesInOnePassWithPlacesAndNearestNames) {
  const Template made = parsed(
      "{{radus}}\n{{x}} {{#x}}a{{/x}}\n{{m}}\n{{#c}}{{/c}}{{#c.boxx}}{{/c.boxx}}"
      "\n{{m.inddex}}{{x.y}}{{nothing}}{{.}}{{radus}}");
  const Map values{{"radius", 1.0},
                   {"x", 3},
                   {"m", Map{{"index", 1}}},
                   {"nothing", Value()},
                   {"c", Value::Choice{"box", {"axisymmetric", "box"}}}};
  try {
    (void)made.render(values);
    FAIL() << "must be refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::refused);
    EXPECT_THAT(
        texts(error.problems()),
        ElementsAre("t.txt:1:1: 'radus' is not given (used 2 times); did you mean 'radius'?",
                    "t.txt:2:7: 'x' is a count: a section needs a switch, a list, or a choice",
                    HasSubstr("t.txt:3:1: 'm' cannot be written: a map has no text of its own"),
                    "t.txt:4:1: the choice 'c' stands in a section without a name; "
                    "ask for one of its names: {{#c.axisymmetric}}",
                    "t.txt:4:13: 'boxx' is not a choice of 'c'; did you mean 'box'?",
                    "t.txt:5:1: 'm' has no member 'inddex'; did you mean 'index'?",
                    "t.txt:5:13: 'x' is a count and has no members, so no 'y'",
                    "t.txt:5:20: 'nothing' has no value",
                    HasSubstr("t.txt:5:31: '{{.}}' stands outside of a list")));
  }
}

TEST(Render, KnowsTheUntakenSectionsToo) {
  EXPECT_THAT(refusal([] {
                (void)parsed("{{#s}}{{typo}}{{/s}}").render({{"s", false}});
              }),
              HasSubstr("t.txt:1:7: 'typo' is not given"));
  // ... but not what the values there would need.
  EXPECT_EQ(parsed("{{#s}}{{x}}{{/s}}").render({{"s", false}, {"x", Value()}}), "");
}

TEST(Render, EveryItemNeedsTheMembers) {
  const Template made = parsed("{{#p}}{{name}}{{/p}}");
  EXPECT_EQ(
      refusal([&] {
        (void)made.render({{"p", List{Map{{"name", 1}}, Map{{"nam", 1}}}}});
      }),
      "t.txt:1:7: 'name' is not given, nor has item 2 of 'p' such a member; did you mean 'nam'?");
}

TEST(Render, RefusesTextWhereItWouldJoinTheTextBefore) {
  for (const char* text : {"f{{x}}", "a = r{{x}}", "{{x}}{{x}}"}) {
    EXPECT_THAT(refusal([&] {
                  (void)parsed(text, Language::python).render({{"x", "v"}});
                }),
                HasSubstr("directly behind a letter, digit or quote"))
        << text;
  }
  EXPECT_THAT(refusal([] {
                (void)parsed("{{x}}'b'", Language::python).render({{"x", ""}});
              }),
              HasSubstr("a quote stands directly behind the text 'x'"));
  EXPECT_EQ(parsed("border b{{i}}", Language::freefem).render({{"i", 2}}), "border b2");
}

TEST(Render, RefusesTextInsideAScriptElement) {
  const Template made = parsed("<script>a = {{x}};</script>", Language::html);
  EXPECT_EQ(made.render({{"x", 1.5}}), "<script>a = 1.5;</script>");
  EXPECT_EQ(made.render({{"x", Value::Markup{"f()"}}}), "<script>a = f();</script>");
  EXPECT_THAT(refusal([&] { (void)made.render({{"x", "alert(1)"}}); }), HasSubstr("would be code"));
}

}  // namespace
}  // namespace sandglass
