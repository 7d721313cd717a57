#include <fmt/format.h>
#include <gmock/gmock.h>

#include "project.hpp"

namespace sandglass::workflow {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Check : public testing::Test {
 protected:
  Project project;
};

TEST_F(Check, AFaultlessWorkflowLoads) {
  const Workflow workflow = project.load(coupled);
  EXPECT_EQ(workflow.participants.size(), 2U);
  EXPECT_EQ(workflow.coupling->windows, 30);
}

TEST_F(Check, AllProblemsOfAllSectionsComeInOnePass) {
  EXPECT_THAT(
      project.problems(R"(sandglass: 1
titel: wrong
parameters:
  diameter: {value: 1 kg, unit: mm}
stages:
  first: {run: python, template: python/bal.py, given: [diameter], after: [second]}
  second: {run: pyton, template: python/ball.py}
  couple: {run: coupling}
participants:
  grains:
    solver: yade
    template: yade/ball.py
    given: [diamter]
    threads: 0
coupling:
  scheme: serial
  window: 1 m
  end: $diameter
  order: [grains, fluids]
  fields:
    velocity: {unit: m/s, shape: [0], from: grain}
record: {fields: [velocty]}
compare:
  - {name: a, quantity: q, metric: value, tolerance: -1}
)"),
      ElementsAre(
          "w.yaml:1:1: a workflow needs 'name'",                 //
          "w.yaml:2:1: a workflow has no key 'titel'",           //
          "w.yaml:4:21: 'diameter': unit 'kg' does not fit mm",  //
          "w.yaml:6:34: there is no template 'python/bal.py'",   //
          "w.yaml:7:17: 'pyton' is not valid for 'run'",         //
          "w.yaml:13:13: there is no parameter 'diamter'",       //
          "w.yaml:14:14: 'threads' is 0",                        //
          "w.yaml:16:11: 'serial' is not valid for 'scheme'",    //
          "w.yaml:17:11: unit 'm' does not fit s",               //
          "w.yaml:18:8: parameter 'diameter' is a number in mm, not a number in s",
          "w.yaml:19:19: there is no participant 'fluids'",  //
          "w.yaml:21:35: 'shape' is 0",                      //
          "w.yaml:21:45: field 'velocity' is unreachable: its sender is no participant: 'grain'",
          "w.yaml:22:19: there is no field 'velocty'",  //
          "w.yaml:24:5: a comparison needs 'because'",  //
          "w.yaml:24:54: 'tolerance' is -1",
          // The template is checked too: what it is given, and what it lacks.
          "yade/ball.py:1:12: 'diameter' is not given"));
}

TEST_F(Check, RemediesNameTheNearestValidName) {
  const Error error = test::error_of([&] {
    (void)project.load(
        changed(changed(coupled, "name: test", "nmae: test"), "solver: freefem", "solver: freefm"));
  });
  EXPECT_THAT(error.what(),
              HasSubstr("w.yaml:2:1: a workflow has no key 'nmae'; did you mean 'name'?"));
  EXPECT_THAT(error.what(),
              HasSubstr("'freefm' is not valid for 'solver'; did you mean 'freefem'?"));
}

TEST_F(Check, KindsOfValues) {
  EXPECT_THAT(project.problems(R"(sandglass: 1
name: [a]
parameters: 3
stages:
  - run: python
participants: {}
coupling:
record: {fields: some}
compare: {name: x}
)"),
              ElementsAre("w.yaml:2:7: 'name' cannot be a list",      //
                          "w.yaml:3:13: 'parameters' must be a map",  //
                          "w.yaml:5:3: 'stages' must be a map",       //
                          "w.yaml:7:1: 'coupling' has no value",      //
                          "w.yaml:8:18: 'fields' must be a list",     //
                          "w.yaml:9:10: 'compare' must be a list"));
}

TEST_F(Check, ANameIsAWord) {
  EXPECT_THAT(project.problems("sandglass: 1\nname: a b\nstages:\n  1st: {run: coupling}\n"),
              ElementsAre("w.yaml:2:7: 'a b' is not a name", "w.yaml:4:3: '1st' is not a name",
                          "w.yaml:4:3: there is no 'coupling' for this stage to run"));
}

TEST_F(Check, TheVersionIsLookedAtFirst) {
  EXPECT_THAT(project.problems("sandglass: 2\nanything: goes\n"),
              ElementsAre("w.yaml:1:12: format version '2'"));
  EXPECT_THAT(project.problems("name: x\nstages: {}\n"),
              ElementsAre("w.yaml:1:1: a workflow needs 'sandglass'"));
  EXPECT_THAT(project.problems("- a\n"), ElementsAre("w.yaml:1:1: a workflow is a map"));
}

TEST_F(Check, CyclesAmongStagesAreNamed) {
  EXPECT_THAT(project.problems(head + R"(stages:
  a: {run: command, command: [x], after: [c]}
  b: {run: command, command: [x], after: [a], makes: [f]}
  c: {run: python, template: python/ball.py, given: {diameter: {file: b/f}}}
  d: {run: command, command: [x], after: [a]}
)"),
              ElementsAre("w.yaml:6:3: the stages wait for each other: a -> b -> c -> a"));
  EXPECT_THAT(project.problems(head + "stages:\n  a: {run: command, command: [x], after: [a]}\n"),
              ElementsAre("w.yaml:6:3: the stages wait for each other: a -> a"));
}

TEST_F(Check, StagesThatAreNotThere) {
  EXPECT_THAT(
      project.problems(head + R"(stages:
  mesh: {run: command, command: [x], makes: [box.msh]}
  use: {run: python, template: python/ball.py, given: {diameter: {file: mash/box.msh}}, after: [mehs]}
  more: {run: python, template: python/ball.py, given: {diameter: {file: mesh/box.mesh}}}
)"),
      ElementsAre("w.yaml:7:66: there is no stage 'mash'", "w.yaml:7:97: there is no stage 'mehs'",
                  "w.yaml:8:67: stage 'mesh' does not make 'box.mesh'"));
}

TEST_F(Check, StagesNeedWhatTheirProgramNeeds) {
  EXPECT_THAT(project.problems(head + R"(stages:
  a: {run: python}
  b: {run: command, template: python/ball.py}
  c: {run: gmsh, template: python/ball.py, given: [diameter], analysis: true}
  d: {run: command, command: [x], makes: [../x, /y], reuse: true}
  e: {run: coupling, deadline: 1 s}
)"),
              ElementsAre("w.yaml:6:3: a python stage needs 'template'",
                          "w.yaml:7:3: a command stage needs 'command'",
                          "w.yaml:7:31: a command stage has no 'template'",
                          "w.yaml:8:28: 'python/ball.py' is not a .geo script",
                          "w.yaml:8:73: a gmsh stage has no 'analysis'",
                          "w.yaml:9:42: '../x' is not a file's place",
                          "w.yaml:9:42: '/y' is not a file's place",
                          "w.yaml:9:61: a command stage has no 'reuse'",
                          "w.yaml:10:3: there is no 'coupling' for this stage to run",
                          "w.yaml:10:32: a coupling stage has no 'deadline'"));
}

TEST_F(Check, TemplatesUseWhatTheyAreGivenAndNoMore) {
  const std::vector<std::string> problems = project.problems(head + R"(stages:
  a: {run: python, template: python/ball.py, given: [diameter, {extra: 3}]}
  b: {run: python, template: python/ball.py}
)");
  EXPECT_THAT(problems, SizeIs(2));
  EXPECT_THAT(problems, Contains(HasSubstr("w.yaml:6:65: ")));
  EXPECT_THAT(problems, Contains(HasSubstr("python/ball.py:1:12: ")));
}

TEST_F(Check, SyntaxErrorsOfATemplateComeWithTheRest) {
  project.write("templates/python/broken.py", "x = {{#a}}\n");
  const std::vector<std::string> problems = project.problems(head + R"(stages:
  a: {run: python, template: python/broken.py, wen: {}}
  b: {run: python, template: python/broken.py}
)");
  EXPECT_THAT(problems, Contains(HasSubstr("w.yaml:6:48: a stage has no key 'wen'")));
  EXPECT_THAT(problems, Contains(HasSubstr("python/broken.py:1:")));
}

TEST_F(Check, TemplatesStayBelowTheirRoot) {
  for (const char* path : {"../secret.py", "/etc/passwd", "a//b.py", "./a.py", "'a\\b.py'"}) {
    const auto problems = project.problems(
        fmt::format("{}stages:\n  a: {{run: python, template: {}}}\n", head, path));
    EXPECT_THAT(problems, ElementsAre(HasSubstr("is not a path below templates/"))) << path;
  }
}

TEST_F(Check, UnreachableFields) {
  const std::string fields = "    drag: {unit: N, shape: [1], from: fluid, to: grains}\n";
  EXPECT_THAT(project.problems(changed(coupled, fields,
                                       "    drag: {unit: N, shape: [1], from: fluid, "
                                       "to: fluid}\n")),
              ElementsAre("w.yaml:41:50: field 'drag' goes from 'fluid' to itself"));
  EXPECT_THAT(
      project.problems(
          changed(coupled, fields, "    drag: {unit: N, shape: [1], from: air, to: grain}\n")),
      ElementsAre(
          "w.yaml:41:39: field 'drag' is unreachable: its sender is no participant: 'air'",
          "w.yaml:41:48: field 'drag' is unreachable: its receiver is no participant: 'grain'"));
  EXPECT_THAT(
      project.problems(changed(coupled, "order: [grains, fluid]", "order: [grains]")),
      ElementsAre("w.yaml:29:3: participant 'fluid' is not in the order",
                  "w.yaml:40:57: field 'velocity' is unreachable: its receiver 'fluid' is not in "
                  "the order",
                  "w.yaml:41:39: field 'drag' is unreachable: its sender 'fluid' is not in the "
                  "order"));
}

TEST_F(Check, FieldsOfAWrongShapeUnitOrTransform) {
  const std::string fields = "    drag: {unit: N, shape: [1], from: fluid, to: grains}\n";
  EXPECT_THAT(
      project.problems(
          changed(coupled, fields, R"(    drag: {unit: N, shape: 3, from: fluid, to: grains}
    a: {unit: N, shape: [3, {at_most: 4}], from: fluid, to: grains}
    b: {unit: N, shape: [1], from: fluid, to: grains, transform: linear}
    c: {unit: N, shape: [1], from: fluid, to: grains, samples: 3}
    d: {unit: N, shape: [1], from: fluid, to: grains, initial: 3 m}
    e: {unit: new, shape: [2000000, 2000000], from: fluid, to: grains}
    f: {unit: N, shape: [$diameter], from: fluid, to: grains}
    g: {unit: N, shape: [~, 3], from: fluid, to: grains}
    h: {unit: N, shape: [{at_most: ~}, 3], from: fluid, to: grains}
    i: {unit: N, shape: [3], from: fluid, to: grains, transform: linear, samples: 1000000000000}
)")),
      ElementsAre("w.yaml:41:28: 'shape' must be a list of 1 to 8 lengths",
                  "w.yaml:42:29: an axis must be a length",
                  "w.yaml:43:66: the transform of 'b' needs 'samples'",
                  "w.yaml:44:64: 'samples' belongs to the transform linear",
                  "w.yaml:45:64: unit 'm' does not fit N", "w.yaml:46:15: unknown unit 'new'",
                  "w.yaml:46:27: the field has more than 2147483648 values",
                  "w.yaml:47:26: parameter 'diameter' is a number in mm, not a count (give it "
                  "'type: count')",
                  "w.yaml:48:26: an axis has no length", "w.yaml:49:26: an axis has no length",
                  "w.yaml:50:83: more than 2147483648 values of field 'i' arrive"));
}

TEST_F(Check, MappingsBetweenPointsThatDoNotFit) {
  const std::string fields = "    drag: {unit: N, shape: [1], from: fluid, to: grains}\n";
  EXPECT_THAT(project.problems(changed(coupled, fields,
                                       R"(    drag: {unit: N, shape: [1], from: fluid, to: grains}
    tips: {unit: m, shape: [4, 3], from: grains}
    wall: {unit: m, shape: [{at_most: 9}, 2], from: fluid}
    push: {unit: N, shape: [5, 3], from: grains, to: fluid, mapping: {kind: conservative, method: linear, from_points: tips, to_points: wall, limit: 1 mm}}
)")),
              ElementsAre("w.yaml:44:70: field 'push' has 5 values, but there are 4 points 'tips'",
                          "w.yaml:44:70: points 'tips' have 3 coordinates, points 'wall' 2"));
}

TEST_F(Check, TheWatchesFieldsNeedNotBeRecorded) {
  const std::string fields = "    drag: {unit: N, shape: [1], from: fluid, to: grains}\n";
  const std::string text =
      changed(coupled, fields, fields + R"(    e: {unit: J, shape: [1], from: fluid}
    f: {unit: J, shape: [1], from: fluid}
  stability: {energy: [e]}
record: {fields: [drag]}
)");
  const Workflow workflow = project.load(text);
  EXPECT_EQ(workflow.coupling->fields.back().name, "e");
  EXPECT_EQ(workflow.coupling->fields_left_out, (std::vector<std::string>{"f"}));
}

TEST_F(Check, ListsHaveNoHoles) {
  EXPECT_THAT(project.problems(changed(coupled, "given: [diameter, density]",
                                       "given: [diameter, density, {x: [1, ~, 3]}]")),
              testing::Contains(testing::HasSubstr("an item of the list is empty")));
}

TEST_F(Check, ComparisonsNeedAUnitThatBeginsAtZero) {
  const std::string compare = R"(compare:
  - {name: t, quantity: t, reference: {value: 20 degC, source: here}, metric: absolute difference, tolerance: 0.5 degC, because: so}
  - {name: u, quantity: t, reference: {value: 20 degC, source: here}, metric: absolute difference, tolerance: 0.5 K, because: so}
)";
  EXPECT_THAT(project.problems(coupled + compare),
              ElementsAre(testing::HasSubstr("a comparison in degC, whose 0 is not 0 in SI")));
}

TEST_F(Check, ParticipantsAndCouplingBelongTogether) {
  EXPECT_THAT(project.problems(changed(coupled, "  couple:\n    run: coupling\n", "")),
              ElementsAre("w.yaml:34:3: no stage runs the coupling"));
  EXPECT_THAT(project.problems(head + R"(stages:
  a: {run: python, template: python/empty.py}
participants:
  grains: {solver: command, command: [x]}
)"),
              ElementsAre("w.yaml:8:3: there are participants and no 'coupling'"));
  EXPECT_THAT(project.problems(changed(coupled, "    run: coupling\n",
                                       "    run: coupling\n  again: {run: coupling}\n")),
              ElementsAre("w.yaml:18:3: a second coupling stage"));
}

TEST_F(Check, ReferencesMustFit) {
  EXPECT_THAT(
      project.problems(changed(coupled, "  window: $window\n", "  window: $fluid\n")),
      ElementsAre(
          "w.yaml:36:11: parameter 'fluid' is a choice of plain, meshed, not a number in s"));
  EXPECT_THAT(project.problems(changed(coupled, "  window: $window\n", "  window: $\n")),
              ElementsAre("w.yaml:36:11: there is no parameter ''"));
  EXPECT_THAT(
      project.problems(
          changed(coupled, "order: [grains, fluid]", "order: [grains, fluid]\n  scheme: $fluid")),
      ElementsAre("w.yaml:39:11: choice 'plain' of parameter 'fluid' is not valid for 'scheme'"));
  EXPECT_THAT(project.problems(changed(coupled, "name: test", "name: $window")),
              ElementsAre("w.yaml:2:7: 'name' cannot be a parameter"));
}

TEST_F(Check, Comparisons) {
  const std::vector<std::string> problems = project.problems(coupled + R"(compare:
  - {name: a, metric: value, tolerance: 1, because: x}
  - {name: b, quantity: q, curve: c, metric: value, tolerance: 1, because: x}
  - {name: c, quantity: q, metric: relative difference, tolerance: 1, because: x}
  - {name: d, quantity: q, reference: {value: 1 m/s}, metric: relative difference, tolerance: 1, because: x}
  - {name: e, curve: q, reference: {value: 1, source: s}, metric: maximum difference, tolerance: 1, because: x}
  - {name: f, quantity: q, reference: {quantity: r}, metric: maximum difference, tolerance: 1, because: x}
  - {name: g, quantity: q, reference: {value: 1 m, source: s}, metric: absolute difference, tolerance: 1 s, because: x}
  - {name: h, quantity: q, reference: {value: 1 m, source: s}, metric: relative difference, tolerance: 1 m, because: x}
  - {name: i, curve: q, reference: {data: icy/figure_3.csv, source: s}, metric: maximum difference, tolerance: 1, because: x}
  - {name: a, quantity: q, metric: value, tolerance: 1, because: x, holds_for: {density: 3 kg, dens: 1}}
  - {name: j, quantity: q, reference: {value: 1, quantity: b, source: s}, metric: absolute difference, tolerance: 1, because: x}
)");
  EXPECT_THAT(problems,
              ElementsAre("w.yaml:43:5: neither 'quantity' nor 'curve'",             //
                          "w.yaml:44:35: both 'quantity' and 'curve'",               //
                          "w.yaml:45:5: this metric needs a 'reference'",            //
                          "w.yaml:46:39: a published reference needs its 'source'",  //
                          "w.yaml:47:44: a curve cannot be compared with 'value'",   //
                          "w.yaml:48:62: this metric needs a curve",                 //
                          "w.yaml:49:104: unit 's' does not fit m",                  //
                          "w.yaml:50:104: unit 'm' does not fit a ratio",            //
                          "w.yaml:51:43: there is no data file 'icy/figure_3.csv'",  //
                          "w.yaml:52:12: a second comparison called 'a'",            //
                          "w.yaml:52:90: unit 'kg' does not fit kg/m3",              //
                          "w.yaml:52:96: there is no parameter 'dens'",              //
                          "w.yaml:53:39: a reference with value and quantity"));
}

TEST_F(Check, LeftOutAndRecord) {
  EXPECT_THAT(project.problems(coupled + R"(record: {fields: all}
left_out:
  a: {of: fluids, what: x, why: y}
  diameter: {of: grains, what: x, why: y}
)"),
              ElementsAre("w.yaml:44:11: there is no participant 'fluids'",
                          "w.yaml:45:3: 'diameter' is also given to 'grains'"));
}

TEST_F(Check, ManyProblemsAreCutAtFifty) {
  std::string text = head + "stages:\n  a: {run: python, template: python/empty.py}\n";
  for (int i = 0; i < 900; ++i) text += fmt::format("key{}: 1\n", i);
  const std::vector<std::string> problems = project.problems(text);
  ASSERT_THAT(problems, SizeIs(51));
  EXPECT_EQ(problems.back(), ": and 850 more problems");
}

TEST_F(Check, WhatWouldTakeLongToCheckIsRefused) {
  std::string choices = "c";
  std::string stages;
  for (int i = 0; i < 50; ++i) choices += fmt::format(", c{}", i);
  for (int i = 0; i < 101; ++i) stages += fmt::format("  s{}: {{run: command, command: [x]}}\n", i);
  EXPECT_THAT(
      project.problems("sandglass: 1\nname: x\nparameters:\n  c: {value: c, choices: [" + choices +
                       "]}\nstages:\n" + stages),
      ElementsAre("w.yaml:4:26: more than 50 choices", "w.yaml:106:3: more than 100 stages"));
}

TEST_F(Check, LongNamesAreRefusedInShortWords) {
  const std::string name(1000, 'x');
  const std::vector<std::string> problems =
      project.problems(head + "stages:\n  " + name +
                       ": {run: python, template: python/empty.py}\n" + name + ": 1\n");
  ASSERT_THAT(problems, SizeIs(2));
  for (const std::string& problem : problems) EXPECT_LT(problem.size(), 200U);
  // Beyond 1024 characters YAML itself has no plain keys.
  EXPECT_THAT(project.problems(head + std::string(10'000, 'x') + ": 1\n"),
              ElementsAre(HasSubstr("YAML syntax")));
  EXPECT_THAT(project.problems(changed(head, "name: test", "name: " + std::string(10'000, 'x')) +
                               "stages: {}\n"),
              ElementsAre(HasSubstr("w.yaml:2:7: 'xxx")));
}

TEST_F(Check, AFileThatIsNotThereOrNotAFileIsAMistakeOfUsage) {
  for (const char* path : {"no/such/file.yaml", "/dev/zero", "/tmp"}) {
    const Error error = test::error_of([&] { (void)load(path, project.options); });
    EXPECT_EQ(error.code(), ExitCode::usage) << path;
  }
}

TEST_F(Check, AHugeFileIsRefusedUnread) {
  project.write("huge.yaml", std::string(2U << 20U, 'x'));
  const std::string path = project.options.data_root + "/../huge.yaml";
  const Error error = test::error_of([&] { (void)load(path, project.options); });
  EXPECT_THAT(error.what(), HasSubstr("larger than 1 MiB"));
}

}  // namespace
}  // namespace sandglass::workflow
