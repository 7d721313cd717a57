#include "workflow/yaml.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "../support/errors.hpp"

namespace sandglass::workflow {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> problems_of(const std::string& text) {
  Problems problems;
  (void)parse_yaml(text, "w.yaml", problems);
  const Error error = test::error_of([&] { problems.raise_if_any(); });
  std::vector<std::string> lines;
  for (const Problem& problem : error.problems()) {
    lines.push_back(problem.place.text() + ": " + problem.what);
  }
  return lines;
}

Node parsed(const std::string& text) {
  Problems problems;
  Node node = parse_yaml(text, "w.yaml", problems);
  problems.raise_if_any();
  return node;
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(Yaml, KeepsOrderKindsAndQuotes) {
  const Node root = parsed("b: [1, '2', \"3\"]\na:\n  x: |\n    text\n");
  ASSERT_EQ(root.keys.size(), 2U);
  EXPECT_EQ(root.keys[0].text, "b");
  const Node& list = root.items[0];
  ASSERT_EQ(list.items.size(), 3U);
  EXPECT_FALSE(list.items[0].quoted);
  EXPECT_TRUE(list.items[1].quoted);
  EXPECT_TRUE(list.items[2].quoted);
  const Node* block = root.items[1].find("x");
  ASSERT_NE(block, nullptr);
  EXPECT_EQ(block->text, "text\n");
  EXPECT_TRUE(block->quoted);
  EXPECT_EQ(block->line, 3);
}

TEST(Yaml, ColumnsCountCharactersNotBytes) {
  const Node root = parsed("\"é\": {\"ü\": 1, \"漢字\": 2}\n");
  EXPECT_EQ(root.items[0].keys[0].column, 7);
  EXPECT_EQ(root.items[0].keys[1].column, 15);
  EXPECT_EQ(root.items[0].items[1].column, 21);
}

TEST(Yaml, WindowsLineEndsAndByteOrderMarkSayNothing) {
  const Node root = parsed(
      "\xEF\xBB\xBF"
      "a: one\r\nb: 2\r\n");
  EXPECT_EQ(root.find("a")->text, "one");
  EXPECT_EQ(root.find("b")->text, "2");
  EXPECT_EQ(root.keys[0].column, 1);
}

TEST(Yaml, AMissingValueIsPlacedAtItsKey) {
  const Node root = parsed("a:\n\n\nb: 1\n");
  EXPECT_EQ(root.items[0].kind, Node::Kind::nothing);
  EXPECT_EQ(root.items[0].line, 1);
}

TEST(Yaml, EveryDuplicateKeyNamesBothPlaces) {
  Problems problems;
  const Node root = parse_yaml("a: 1\nb: {c: 1, c: 2}\na: 3\n", "w.yaml", problems);
  const Error error = test::error_of([&] { problems.raise_if_any(); });
  ASSERT_EQ(error.problems().size(), 2U);
  EXPECT_EQ(error.problems()[0].text(),
            "w.yaml:2:11: duplicate key 'c'; it is already at line 2, column 5");
  EXPECT_EQ(error.problems()[1].text(),
            "w.yaml:3:1: duplicate key 'a'; it is already at line 1, column 1");
  EXPECT_EQ(root.find("a")->text, "1") << "the first one counts for the rest of the pass";
}

TEST(Yaml, WhatIsMoreThanDataIsRefusedInOnePass) {
  EXPECT_THAT(problems_of("a: &x 1\nb: *x\nc: !!str 2\n<<: {d: 1}\n? [e]\n: 1\n"),
              ElementsAre("w.yaml:1:4: an anchor", "w.yaml:2:4: an alias", "w.yaml:3:4: a tag",
                          "w.yaml:4:1: a merge key", "w.yaml:5:3: a key must be a plain word"));
}

TEST(Yaml, ASecondDocumentIsRefused) {
  EXPECT_THAT(problems_of("a: 1\n---\nb: 1\n"), ElementsAre("w.yaml:2:1: a second document"));
}

TEST(Yaml, NothingAtAllIsRefused) {
  EXPECT_THAT(problems_of(""), ElementsAre("w.yaml:1:1: the file is empty"));
  EXPECT_THAT(problems_of("# only words\n"), ElementsAre("w.yaml:1:1: the file is empty"));
}

TEST(Yaml, SyntaxErrorsHaveTheirPlace) {
  EXPECT_THAT(problems_of("a: 1\nb: c: d\n"),
              ElementsAre("w.yaml:2:5: YAML syntax: illegal map value"));
  EXPECT_THAT(problems_of("a: \"\\q\"\n")[0], HasSubstr("w.yaml:1:7: YAML syntax: unknown escape"));
  EXPECT_THAT(problems_of("a: [1, 2\n")[0], HasSubstr("YAML syntax"));
  EXPECT_THAT(problems_of("a: b\n  c\n- d\n")[0], HasSubstr("YAML syntax"));
}

TEST(Yaml, AProblemBeforeASyntaxErrorIsReportedToo) {
  EXPECT_THAT(
      problems_of("a: 1\na: 2\nb: c: d\n"),
      ElementsAre("w.yaml:2:1: duplicate key 'a'", "w.yaml:3:5: YAML syntax: illegal map value"));
}

TEST(Yaml, TabsInTheIndentationAreRefused) {
  EXPECT_THAT(problems_of("a:\n\tb: 1\n"), ElementsAre("w.yaml:2:2: a tab in the indentation"));
  EXPECT_EQ(parsed("a: 'x\ty'\n").find("a")->text, "x\ty");
}

TEST(Yaml, OnlyUtf8WithoutControlCharacters) {
  EXPECT_THAT(problems_of("a: \xff\n"), ElementsAre("w.yaml:1:4: this is not UTF-8"));
  EXPECT_THAT(problems_of("a: \xc0\xaf\n"), ElementsAre("w.yaml:1:4: this is not UTF-8"));
  EXPECT_THAT(problems_of("a: \xed\xa0\x80\n"), ElementsAre("w.yaml:1:4: this is not UTF-8"));
  EXPECT_THAT(problems_of("a: \xe2\x82"), ElementsAre("w.yaml:1:4: this is not UTF-8"));
  EXPECT_THAT(problems_of(std::string("a: b\0c\n", 7)),
              ElementsAre("w.yaml:1:5: control character U+0000"));
  EXPECT_THAT(problems_of("a: \x1b[31m\n"), ElementsAre("w.yaml:1:4: control character U+001B"));
  EXPECT_THAT(problems_of("a: \xc2\x9b\n"), ElementsAre("w.yaml:1:4: control character U+009B"));
  EXPECT_THAT(problems_of("a: \"\\x1b[31m\"\n"),
              ElementsAre("w.yaml:1:4: a control character in a text"));
}

TEST(Yaml, DeepNestingIsRefusedInEveryStyle) {
  const std::string deep = "nested too deeply";
  EXPECT_THAT(problems_of(repeated("[", 1'000'000))[0], HasSubstr(deep));
  EXPECT_THAT(problems_of(repeated("{a: ", 200'000))[0], HasSubstr(deep));
  EXPECT_THAT(problems_of(repeated("- ", 500'000))[0], HasSubstr(deep));
  EXPECT_THAT(problems_of(repeated("? ", 500'000))[0], HasSubstr(deep));
  EXPECT_THAT(problems_of(repeated("[", 51) + repeated("]", 51))[0], HasSubstr(deep));
  EXPECT_EQ(parsed(repeated("[", 50) + repeated("]", 50)).kind, Node::Kind::list);
}

TEST(Yaml, BillionLaughsStopAtTheFirstAlias) {
  std::string text = "a0: &a0 [x]\n";
  for (int i = 1; i < 30; ++i) {
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" +
            repeated("*a" + std::to_string(i - 1) + ", ", 9) + "y]\n";
  }
  EXPECT_THAT(problems_of(text), testing::Contains(HasSubstr("an alias")));
}

TEST(Yaml, LargeFilesAndLongListsAreRefused) {
  EXPECT_THAT(problems_of(std::string((1U << 20U) + 1, ' ')),
              ElementsAre("w.yaml: the file is larger than 1 MiB"));
  EXPECT_THAT(problems_of("a: [" + repeated("1, ", 1001) + "]\n"),
              ElementsAre("w.yaml:1:4: a list or map of more than 1000 items"));
  EXPECT_THAT(problems_of("[" + repeated("[" + repeated("1, ", 999) + "], ", 300) + "]")[0],
              HasSubstr("more than 20000 values"));
}

TEST(Yaml, LongTextsAreKept) {
  const std::string name(10'000, 'x');
  EXPECT_EQ(parsed("a: " + name + "\n").find("a")->text, name);
}

}  // namespace
}  // namespace sandglass::workflow
