#include <gmock/gmock.h>

#include <map>

#include "render/template.hpp"
#include "template_helpers.hpp"

// Syntax errors: all of a template in one pass, each at its place.
namespace sandglass {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

struct Case {
  const char* text;
  std::vector<std::string> begins;  // how each problem begins, in order
};

TEST(Parse, ReportsEverySyntaxErrorAtItsPlace) {
  const std::vector<Case> cases{
      {"a\nb {{x\nc", {"t.txt:2:3: this tag is not closed"}},
      {"{{x", {"t.txt:1:1: this tag is not closed"}},
      {"{{", {"t.txt:1:1: this tag is not closed"}},
      {"{{a {{b}}", {"t.txt:1:1: this tag is not closed"}},
      {"{{! never\nended", {"t.txt:1:1: this tag is not closed"}},
      {"a\n  {{#s}}\nb", {"t.txt:2:3: the section 's' is not closed; end it with {{/s}}"}},
      {"{{^s}}{{#t}}", {"t.txt:1:1: the section 's'", "t.txt:1:7: the section 't'"}},
      {"{{#a}}\n{{#b}}\n{{/a}}",
       {"t.txt:2:1: the section 'b' is not closed before '{{/a}}' at 3:1"}},
      {"{{#a}}{{/b}}{{/a}}", {"t.txt:1:7: '{{/b}}' does not close the section 'a' of 1:1"}},
      {"{{/a}}", {"t.txt:1:1: '{{/a}}' closes nothing"}},
      {"{{}}", {"t.txt:1:1: this tag has no name"}},
      {"{{#  }}", {"t.txt:1:1: this tag has no name"}},
      {"{{{x}}}", {"t.txt:1:1: there is no unescaped output"}},
      {"{{&x}}", {"t.txt:1:1: there is no unescaped output"}},
      {"{{=<% %>=}}", {"t.txt:1:1: the braces cannot be changed"}},
      {"{{ a b }}", {"t.txt:1:4: 'a b' is not a name"}},
      {"{{1a}}", {"t.txt:1:3: '1a' is not a name"}},
      {"{{a..b}}", {"t.txt:1:3: 'a..b' is not a name"}},
      {"{{a.}}", {"t.txt:1:3: 'a.' is not a name"}},
      {"{{-a}}", {"t.txt:1:3: '-a' is not a name"}},
      {"{{$a}}", {"t.txt:1:3: '$a' is not a name"}},
      {"{{#a(x)}}{{/a(x)}}", {"t.txt:1:4: 'a(x)'", "t.txt:1:13: 'a(x)'"}},
      {"{{> b}}", {"t.txt:1:1: building blocks are not allowed"}},
      {"{{> ../b}}", {"t.txt:1:5: '../b' is not a path"}},
      {"{{> /etc/passwd}}", {"t.txt:1:5: '/etc/passwd' is not a path"}},
      {"é日 {{1}}", {"t.txt:1:6: '1' is not a name"}},  // columns count characters
      {"\r\n\r\n {{&x}}", {"t.txt:3:2: there is no"}},
      {"{{1}}\n{{2}}\n{{#s}}\n", {"t.txt:1:3:", "t.txt:2:3:", "t.txt:3:1:"}},
  };
  for (const Case& each : cases) {
    std::vector<testing::Matcher<std::string>> expected;
    for (const std::string& begin : each.begins) expected.push_back(StartsWith(begin));
    EXPECT_THAT(parse_problems(each.text), testing::ElementsAreArray(expected)) << each.text;
  }
}

TEST(Parse, AcceptsNamesAsTheyAreWritten) {
  for (const char* text : {"{{a}}", "{{ a }}", "{{_a-1.b.c_2}}", "{{ # a }}{{/ a}}", "{{!}}", "}}",
                           "{", "{{a}}}", "{ {{a}} }", "{{!{{x}}", "{{! a\nb }}", ""}) {
    EXPECT_THAT(parse_problems(text), ElementsAre()) << text;
  }
}

TEST(Parse, RefusesATagInsideAStringOrBlockComment) {
  struct Stand {
    Language language;
    const char* text;
    const char* inside;  // nullptr: good
  };
  const std::vector<Stand> stands{
      {Language::python, "a = {{x}}", nullptr},
      {Language::python, "a = '{{x}}'", "a string"},
      {Language::python, "a = \"{{x}}\"", "a string"},
      {Language::python, "a = f'{ {{x}} }'", "a string"},
      {Language::python, "\"\"\"doc\n{{x}}\n\"\"\"", "a string"},
      {Language::python, "'''it's {{x}}'''", "a string"},
      {Language::python, "\"\"\"doc \"quoted\" \"\"\"\na = {{x}}", nullptr},
      {Language::python, "a = '' + {{x}}", nullptr},
      {Language::python, "a = ''{{x}}", "a string"},
      {Language::python, "a = 'it\\'s' + {{x}}", nullptr},
      {Language::python, "a = 'it\\'s {{x}}'", "a string"},
      {Language::python, "a = '\\\\' + {{x}}", nullptr},
      {Language::python, "# it's\na = {{x}}", nullptr},
      {Language::python, "# it's {{x}}", nullptr},
      {Language::python, "a = '#' + {{x}}", nullptr},
      {Language::python, "a = ['{{! words }}', {{x}}]", nullptr},
      {Language::freefem, "string s = \"{{x}}\";", "a string"},
      {Language::freefem, "string s = \"\\\"{{x}}\";", "a string"},
      {Language::freefem, "A' * {{x}};", nullptr},
      {Language::freefem, "// it is \" {{x}}", nullptr},
      {Language::freefem, "/* {{x}} */", "a comment"},
      {Language::freefem, "/* \" */ a = {{x}};", nullptr},
      {Language::freefem, "/*/ {{x}} */", "a comment"},
      {Language::freefem, "s = \"/*\"; a = {{x}};", nullptr},
      {Language::freefem, "a = 1 / {{x}} / 2; b = {{x}};", nullptr},
      {Language::gmsh, "s = \"{{x}}\";", "a string"},
      {Language::gmsh, "s = '{{x}}';", "a string"},
      {Language::gmsh, "s = \"\\\"; a = {{x}};", nullptr},  // no escapes there
      {Language::gmsh, "/* {{x}} */", "a comment"},
      {Language::lammps, "print \"{{x}}\"", "a string"},
      {Language::lammps, "print \"\"\"\n{{x}}\"\"\"", "a string"},
      {Language::lammps, "# it's {{x}}\nrun {{x}}", nullptr},
      {Language::shell, "echo \"{{x}}\"", "a string"},
      {Language::shell, "echo '{{x}}'", "a string"},
      {Language::shell, "echo `{{x}}`", "a string"},
      {Language::shell, "echo \\' {{x}}", nullptr},
      {Language::shell, "echo $'it\\'s {{x}}'", "a string"},
      {Language::shell, "echo $(echo {{x}})", nullptr},
      {Language::shell, "echo \"$(echo \"{{x}}\")\"", "a string"},
      {Language::shell, "echo \"$(echo \"a\")\" {{x}}", nullptr},
      {Language::shell, "name=\"`basename \"{{x}}\"`\"", "a string"},
      {Language::shell, "echo \"`a \"b\"`\" {{x}}", nullptr},
      {Language::shell, "echo \"${nothing:-\"{{x}}\"}\"", "a string"},
      {Language::shell, "echo \"${nothing:-\"a\"}\" {{x}}", nullptr},
      {Language::shell, "echo \"$(printf ')' \"{{x}}\")\"", "a string"},
      {Language::shell, "echo \"$(printf '\\' ')' \"{{x}}\")\"", "a string"},
      {Language::shell, "echo \"$(printf ')' \"a\")\" {{x}}", nullptr},
      {Language::shell, "echo \"$(case a in a) echo \"{{x}}\";; esac)\"", "a string"},
      {Language::shell, "echo \"$(cat <<END\n)\nEND\n) \"{{x}}", "a string"},
      {Language::shell, "echo \"$(a # )\n) \"{{x}}", "a string"},
      {Language::shell, "cat <<END\n{{x}}\nEND\n", "a string"},
      {Language::shell, "cat <<END\n\tEND\n{{x}}\nEND\n", "a string"},
      {Language::shell, "a=$((1 << 3))\necho {{x}}", nullptr},
      {Language::shell, "a=$((1<<bits))\necho {{x}}", nullptr},
      {Language::shell, "a=$((1 << 3)); cat <<END\n{{x}}\nEND\n", "a string"},
      {Language::shell, "cat <<-'END'\nit's\n\tEND\necho {{x}}", nullptr},
      {Language::shell, "cat <<< {{x}}", nullptr},
      {Language::shell, "echo a#b' {{x}}'", "a string"},
      {Language::shell, "echo a # b' {{x}}", nullptr},
      {Language::json, "{\"a\": {{x}}}", nullptr},
      {Language::json, "{\"a\": \"{{x}}\"}", "a string"},
      {Language::html, "<p class=\"{{x}}\">it's {{x}}</p>", nullptr},
      {Language::html, "<p class={{x}}>", "an HTML tag"},
      {Language::html, "<{{x}}>", "an HTML tag"},
      {Language::html, "<!-- ' {{x}} --><p>{{x}}", nullptr},
      {Language::html, "a < b {{x}}", nullptr},
      {Language::html, "<script src='a'>a='</p>'</script>{{x}}", nullptr},
      {Language::text, "\"{{x}}\"", nullptr},
  };
  for (const Stand& stand : stands) {
    const auto problems = parse_problems(stand.text, stand.language);
    if (stand.inside) {
      EXPECT_THAT(problems, ElementsAre(HasSubstr("stands inside " + std::string(stand.inside))))
          << stand.text;
    } else {
      EXPECT_THAT(problems, ElementsAre()) << stand.text;
    }
  }
}

TEST(Parse, RefusesASectionThatBeginsOrEndsAString) {
  EXPECT_THAT(
      parse_problems("a = {{#s}}'{{/s}}'", Language::python),
      ElementsAre(HasSubstr("the section 's' begins inside code and ends inside a string")));
  EXPECT_THAT(parse_problems("a = '{{#s}}b{{/s}}'", Language::python), ElementsAre());
}

TEST(Parse, BuildingBlockErrorsNameTheBlocksFile) {
  const std::map<std::string, std::string> blocks{
      {"a/one.txt", "x\n{{&x}}\n"}, {"a/two.txt", "{{> a/three}}"}, {"a/three.txt", "{{> a/two}}"},
      {"a/open.txt", "{{#s}}"},     {"a/code.py", "{{x}}"},         {"a/twice.txt", "{{> a/one}}"}};
  EXPECT_THAT(parse_problems("{{> a/one}}{{> a/twice.txt}}", Language::text, blocks),
              ElementsAre(StartsWith("a/one.txt:2:1: there is no unescaped output")));
  EXPECT_THAT(parse_problems("\n {{> a/none}}", Language::text, blocks),
              ElementsAre("t.txt:2:2: no 'a/none.txt'"));
  EXPECT_THAT(parse_problems("{{> a/two}}", Language::text, blocks),
              ElementsAre(StartsWith("a/three.txt:1:1: 'a/two.txt' contains itself: "
                                     "t.txt -> a/two.txt -> a/three.txt -> a/two.txt")));
  EXPECT_THAT(parse_problems("{{> t}}", Language::text, blocks),
              ElementsAre(HasSubstr("'t.txt' contains itself")));
  EXPECT_THAT(parse_problems("{{> a/open}}{{/s}}", Language::text, blocks),
              ElementsAre(StartsWith("a/open.txt:1:1: the section 's' is not closed"),
                          StartsWith("t.txt:1:13: '{{/s}}' closes nothing")));
  EXPECT_THAT(parse_problems("{{> a/code.py}}", Language::text, blocks),
              ElementsAre(HasSubstr("another language")));
}

TEST(Parse, LoadReadsBelowTheRootAndSuggestsFiles) {
  const std::string root = testing::TempDir() + "sandglass_render_load";
  write_file(root + "/yade/sphere.py", "{{> yade/block}}\n{{b}}\n");
  write_file(root + "/yade/block.py", "a = {{a}}\n");
  const Template made = Template::load(root, "yade/sphere.py");
  EXPECT_EQ(made.render({{"a", 1}, {"b", 2}}), "a = 1\n2\n");
  EXPECT_THAT(made.files(), ElementsAre("yade/sphere.py", "yade/block.py"));
  EXPECT_THAT(made.names(), ElementsAre("a", "b"));
  EXPECT_EQ(made.language(), Language::python);
  EXPECT_EQ(refusal([&] { (void)Template::load(root, "yade/sphre.py"); }),
            "there is no template 'yade/sphre.py'; did you mean 'yade/sphere.py'?");
  EXPECT_THAT(refusal([&] { (void)Template::load(root, "nowhere/x.py"); }),
              HasSubstr("no template"));
  EXPECT_THAT(refusal([&] { (void)Template::load(root, "yade"); }), HasSubstr("no template"));
}

}  // namespace
}  // namespace sandglass
