#include <fmt/format.h>
#include <gmock/gmock.h>

#include <random>

#include "fuzz.hpp"
#include "template_helpers.hpp"

namespace sandglass {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(Extremes, NamesOfTenKilobytes) {
  const std::string name(10'000, 'n');
  EXPECT_EQ(parsed("{{" + name + "}}").render({{name, 1}}), "1");
  const std::string message = refusal([&] { (void)parsed("{{" + name + "}}").render({{"x", 1}}); });
  EXPECT_THAT(message, HasSubstr("is not given"));
  EXPECT_LT(message.size(), 300U);
}

TEST(Extremes, ValuesOfAMegabyte) {
  const std::string text(1'000'000, '\'');
  EXPECT_EQ(parsed("{{x}}", Language::python).render({{"x", text}}).size(), 4'000'002U);
}

TEST(Extremes, SectionsNestAHundredDeep) {
  const auto nested = [](int depth) {
    return repeated("{{#s}}", depth) + "x" + repeated("{{/s}}", depth);
  };
  EXPECT_EQ(parsed(nested(100)).render({{"s", true}}), "x");
  EXPECT_THAT(parse_problems(nested(101)), ElementsAre(HasSubstr("nested deeper than 100")));
  EXPECT_THAT(parse_problems(nested(100'000)), ElementsAre(HasSubstr("nested deeper than 100")));
}

TEST(Extremes, DepthCountsThroughBuildingBlocks) {
  EXPECT_THAT(
      parse_problems(repeated("{{#s}}", 60) + "{{> b}}" + repeated("{{/s}}", 60), Language::text,
                     {{"b.txt", repeated("{{#s}}", 60) + repeated("{{/s}}", 60)}}),
      ElementsAre(HasSubstr("b.txt:1:241: sections are nested deeper than 100")));
}

TEST(Extremes, BuildingBlocksThatMultiplyAreRefused) {
  Blocks blocks{{"b0.txt", "x"}};
  for (int i = 1; i < 40; ++i) {
    const std::string before = fmt::format("{{{{> b{}}}}}", i - 1);
    blocks[fmt::format("b{}.txt", i)] = before + before;
  }
  EXPECT_THAT(parse_problems("{{> b39}}", Language::text, blocks),
              ElementsAre(HasSubstr("building blocks make the template too large")));
}

TEST(Extremes, TemplatesOfAMegabyte) {
  const int lines = 50'000;
  const Template made = parsed(repeated("a = {{x}} # {{y}} text\n", lines), Language::python);
  EXPECT_EQ(made.render({{"x", 1}, {"y", "b"}}), repeated("a = 1 # 'b' text\n", lines));
  // One line, and the shapes that would be slow if every tag were searched for to the end.
  EXPECT_EQ(parsed(repeated("{{x}} ", 200'000)).render({{"x", 1}}), repeated("1 ", 200'000));
  EXPECT_THAT(parse_problems(repeated("{{ ", 300'000)), SizeIs(100));
  EXPECT_THAT(parse_problems(repeated("{{{ ", 300'000)), SizeIs(100));
  EXPECT_THAT(parse_problems(repeated("{{!", 300'000)), SizeIs(1));
  EXPECT_THAT(parse_problems(std::string(1'000'000, '{')), SizeIs(1));
}

TEST(Extremes, BytesThatAreNoText) {
  std::string bytes;
  for (int i = 1; i < 256; ++i) bytes += static_cast<char>(i);
  EXPECT_EQ(parsed(bytes + '\0' + "{{x}}").render({{"x", 1}}), bytes + '\0' + "1");
}

TEST(Fuzz, RandomTemplatesEndInATextOrAnError) {
  const std::vector<std::string> pieces{
      "{{x}}", "{{t}}",    "{{#s}}",      "{{/s}}",    "{{^s}}",  "{{#n}}",   "{{/n}}",
      "{{.}}", "{{#p}}",   "{{/p}}",      "{{name}}",  "{{m.x}}", "{{#c.a}}", "{{/c.a}}",
      "{{c}}", "{{! c }}", "{{> b}}",     "{{>same}}", "{{",      "}}",       "{{{",
      "\n",    "  ",       "'",           "\"",        "\"\"\"",  "#",        "//",
      "/*",    "*/",       "\\",          "<<E\n",     "E\n",     "`",        "$(",
      ")",     "<script>", "</script>",   "<a b=\"",   "<!--",    "-->",      "é",
      "\xff",  "text ",    "{{nothing}}", "{{a.b.c}}", "{{&x}}",  "{{=a b=}}"};
  std::mt19937 random(20240607);
  const auto below = [&](size_t limit) { return static_cast<size_t>(random()) % limit; };
  for (int round = 0; round < 5'000; ++round) {
    std::string text(1, static_cast<char>(below(8)));
    for (size_t count = below(30); count > 0; --count) text += pieces[below(pieces.size())];
    for (size_t count = below(4); count > 0; --count) {
      const size_t at = 1 + below(text.size());
      if (at >= text.size()) continue;
      if (below(2) == 0) {
        text.erase(at, 1);
      } else {
        text[at] = static_cast<char>(below(256));
      }
    }
    SCOPED_TRACE(testing::PrintToString(text));
    EXPECT_NO_THROW(fuzz_template(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  }
}

}  // namespace
}  // namespace sandglass
