#include <fmt/format.h>
#include <gmock/gmock.h>

#include "project.hpp"

namespace sandglass::workflow {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> names(const std::vector<Stage>& stages) {
  std::vector<std::string> result;
  for (const Stage& stage : stages) result.push_back(stage.name);
  return result;
}

class Model : public testing::Test {
 protected:
  [[nodiscard]] Coupling windows(const std::string& window, const std::string& end) const {
    return *project.load(coupled, {{"window", window}, {"end_time", end}}).coupling;
  }
  Project project;
};

TEST_F(Model, EverythingIsResolved) {
  const Workflow workflow = project.load(coupled, {{"density", "2.5 g/cm3"}});
  EXPECT_EQ(workflow.name, "test");
  EXPECT_EQ(workflow.title, "test") << "the name stands in";
  ASSERT_EQ(workflow.participants.size(), 2U);
  const Participant& grains = workflow.participants[0];
  EXPECT_EQ(grains.solver, Solver::yade);
  EXPECT_EQ(grains.window_template_path, "yade/ball_window.py");
  EXPECT_EQ(*grains.given.at("density").value.as<double>(), 2500);
  EXPECT_EQ(*grains.given.at("diameter").value.as<double>(), 1e-4);
  EXPECT_EQ(grains.deadline, 60);
  const Coupling& coupling = *workflow.coupling;
  EXPECT_EQ(coupling.window, 1e-3);
  EXPECT_EQ(coupling.end, 0.03);
  EXPECT_THAT(coupling.order, ElementsAre("grains", "fluid"));
  ASSERT_EQ(coupling.fields.size(), 2U);
  EXPECT_EQ(coupling.fields[0].to, "fluid");
  EXPECT_TRUE(coupling.fields[0].recorded);
  EXPECT_THAT(coupling.fields[0].received_shape, ElementsAre(1));
}

TEST_F(Model, TheSelectedCaseIsInTheModelAndItsStageRuns) {
  const Workflow plain = project.load(coupled);
  EXPECT_EQ(plain.participants[1].template_path, "freefem/ball.edp");
  EXPECT_THAT(names(plain.stages), ElementsAre("couple", "analyse"));
  EXPECT_THAT(plain.stages_left_out, ElementsAre("mesh"));

  const Workflow meshed = project.load(coupled, {{"fluid", "meshed"}});
  const Participant& fluid = meshed.participants[1];
  EXPECT_EQ(fluid.template_path, "freefem/mesh.edp");
  EXPECT_EQ(fluid.given.at("mesh").file->stage, "mesh");
  EXPECT_EQ(fluid.given.at("mesh").file->file, "box.msh");
  EXPECT_THAT(names(meshed.stages), ElementsAre("mesh", "couple", "analyse"));
  EXPECT_THAT(meshed.stages[1].after, ElementsAre("mesh")) << "its participant is given a file";
  EXPECT_THAT(meshed.stages[2].after, ElementsAre("couple")) << "an analysis reads the record";
}

TEST_F(Model, EveryCaseIsChecked) {
  const std::string wrong = changed(coupled, "meshed: {template: freefem/mesh.edp, given: {mesh:",
                                    "meshed: {template: freefem/mesh.edp, given: {mash:");
  EXPECT_THAT(project.problems(wrong), ElementsAre("freefem/mesh.edp:1:10: 'mesh' is not given",
                                                   HasSubstr("w.yaml:34:52: ")));
  EXPECT_THAT(project.problems(changed(coupled, "freefem/mesh.edp", "freefem/mash.edp")),
              ElementsAre("w.yaml:34:26: there is no template 'freefem/mash.edp'"));
  // The file's stage would not run when this case is chosen.
  EXPECT_THAT(project.problems(changed(coupled, "when: {fluid: meshed}", "when: {fluid: plain}")),
              ElementsAre("w.yaml:34:58: stage 'mesh' is not run here"));
}

TEST_F(Model, CasesWithinCasesHoldTogether) {
  // The file's stage runs for 'meshed', whatever is chosen within that case.
  const std::string nested =
      changed(changed(coupled, "  fluid: {value: plain,",
                      "  order: {value: first, choices: [first, second]}\n"
                      "  fluid: {value: plain,"),
              "      meshed: {template: freefem/mesh.edp, given: {mesh: {file: mesh/box.msh}}}\n",
              R"(      meshed:
        given: {mesh: {file: mesh/box.msh}}
        choose: order
        cases:
          first: {template: freefem/mesh.edp}
          second: {template: freefem/mesh.edp, deadline: 5 s}
)");
  for (const std::string fluid : {"plain", "meshed"}) {
    for (const std::string order : {"first", "second"}) {
      EXPECT_NO_THROW((void)project.load(nested, {{"fluid", fluid}, {"order", order}}))
          << fluid << " " << order;
    }
  }
}

TEST_F(Model, CasesMustCoverTheChoices) {
  EXPECT_THAT(project.problems(changed(coupled, "      plain: {", "      plane: {")),
              ElementsAre("w.yaml:29:3: a freefem participant needs 'template'",
                          "w.yaml:29:3: no case for choice 'plain' of 'fluid'",
                          "w.yaml:33:7: parameter 'fluid' has no choice 'plane'"));
  EXPECT_EQ(project.load(changed(coupled, "      plain: {", "      otherwise: {"))
                .participants[1]
                .template_path,
            "freefem/ball.edp");
  EXPECT_THAT(project.problems(changed(coupled, "choose: fluid", "choose: window")),
              testing::Contains("w.yaml:31:13: parameter 'window' is a number in ms"));
  EXPECT_THAT(project.problems(changed(coupled, "    choose: fluid\n", "")),
              testing::Contains("w.yaml:29:3: 'cases' without 'choose'"));
}

TEST_F(Model, ACaseReplacesKeysAndJoinsWhatIsGiven) {
  project.write("templates/freefem/two.edp", "real d = {{diameter}}; real r = {{density}};\n");
  project.write("templates/freefem/both.edp", "real d = {{diameter}}; mesh m = {{mesh}};\n");
  std::string text = changed(coupled, "    choose: fluid\n",
                             "    choose: fluid\n    deadline: 5 s\n    given: [diameter]\n");
  text = changed(
      text, "plain: {template: freefem/ball.edp, given: [diameter]}",
      "plain: {template: freefem/two.edp, given: {density: 1.0, diameter: 2 m}, deadline: 7 s}");
  text = changed(text, "freefem/mesh.edp", "freefem/both.edp");
  const Participant plain = project.load(text).participants[1];
  EXPECT_EQ(plain.deadline, 7);
  EXPECT_EQ(*plain.given.at("diameter").value.as<double>(), 2) << "the case's own";
  EXPECT_EQ(*plain.given.at("density").value.as<double>(), 1);
  const Participant meshed = project.load(text, {{"fluid", "meshed"}}).participants[1];
  EXPECT_EQ(meshed.deadline, 5);
  EXPECT_EQ(*meshed.given.at("diameter").value.as<double>(), 1e-4) << "from beside 'choose'";
  EXPECT_TRUE(meshed.given.contains("mesh"));
}

TEST_F(Model, WindowsAreTheFewestWholeOnesThatReachTheEnd) {
  EXPECT_EQ(windows("1 ms", "30 ms").windows, 30);
  EXPECT_EQ(windows("0.1 ms", "30 ms").windows, 300) << "300.00000000000006 by division";
  EXPECT_EQ(windows("0.1 ms", "30 ms").end, 0.03);
  EXPECT_EQ(windows("0.7 ms", "30 ms").windows, 43);
  EXPECT_DOUBLE_EQ(windows("0.7 ms", "30 ms").end, 43 * 0.7e-3);
  EXPECT_EQ(windows("50 ms", "30 ms").windows, 1);
  EXPECT_EQ(windows("50 ms", "30 ms").end, 0.05);
  EXPECT_EQ(windows("1 ns", "1 s").windows, 1'000'000'000);
  EXPECT_THAT(project.problems(coupled, {{"window", "0.9 ns"}, {"end_time", "1 s"}}),
              ElementsAre(HasSubstr("windows of 9.000000000000001e-10 s")));
  EXPECT_THAT(project.problems(coupled, {{"window", "5e-324"}, {"end_time", "1e308"}}),
              ElementsAre(HasSubstr("inf windows of 5e-324 s")));
  EXPECT_THAT(project.problems(coupled, {{"window", "0"}}),
              ElementsAre("w.yaml:36:11: 'window' is 0"));
  EXPECT_THAT(project.problems(coupled, {{"window", "-1 ms"}}),
              ElementsAre("w.yaml:36:11: 'window' is -0.001"));
}

TEST_F(Model, AFieldThatNobodyNeedsIsLeftOut) {
  const std::string text =
      coupled + "    depth: {unit: m, shape: [1], from: grains}\nrecord: {fields: [drag]}\n";
  const Workflow workflow = project.load(text);
  ASSERT_EQ(workflow.coupling->fields.size(), 2U);
  EXPECT_FALSE(workflow.coupling->fields[0].recorded);
  EXPECT_TRUE(workflow.coupling->fields[1].recorded);
  EXPECT_THAT(workflow.coupling->fields_left_out, ElementsAre("depth"));
  project.options.keep = {"depth"};
  EXPECT_EQ(project.load(text).coupling->fields.size(), 3U);
  project.options.keep = {"dept"};
  const Error error = test::error_of([&] { (void)project.load(text); });
  EXPECT_EQ(error.code(), ExitCode::usage);
  EXPECT_THAT(error.what(), HasSubstr("did you mean 'depth'?"));
}

TEST_F(Model, RestIsAFieldThatIsSentAlthoughNobodyNeedsItAndWholeWindows) {
  const std::string text =
      coupled + "    depth: {unit: m, shape: [1], from: grains}\nrecord: {fields: [drag]}\n";
  const auto with = [&](const std::string& rest) {
    return changed(text, "coupling:\n", "coupling:\n  rest: " + rest + "\n");
  };
  const Workflow workflow = project.load(with("{field: depth, at_most: 1e-9, for: 2.5 ms}"),
                                         {{"window", "1 ms"}, {"end_time", "1 s"}});
  EXPECT_EQ(workflow.coupling->rest.field, "depth");
  EXPECT_EQ(workflow.coupling->rest.at_most, 1e-9);
  EXPECT_EQ(workflow.coupling->rest.windows, 3);
  EXPECT_THAT(workflow.coupling->fields_left_out, IsEmpty());
  EXPECT_EQ(project.load(with("{field: depth, for: 0.3 s}"), {{"window", "0.1 s"}})
                .coupling->rest.windows,
            3);
  EXPECT_EQ(project.load(text).coupling->rest.windows, 0);
  EXPECT_THAT(project.problems(with("{field: dept, for: 1 s}")),
              ElementsAre(HasSubstr("there is no field 'dept'")));
  EXPECT_THAT(project.problems(with("{field: depth}")),
              ElementsAre(HasSubstr("a rest needs 'for'")));
}

TEST_F(Model, AParticipantThatDoesNotApplyTakesItsFieldsAlong) {
  const std::string text =
      changed(coupled, "    solver: freefem\n", "    solver: freefem\n    when: {fluid: meshed}\n");
  const Workflow workflow = project.load(text);
  ASSERT_EQ(workflow.participants.size(), 1U);
  EXPECT_THAT(workflow.coupling->order, ElementsAre("grains"));
  ASSERT_EQ(workflow.coupling->fields.size(), 1U);
  EXPECT_EQ(workflow.coupling->fields[0].name, "velocity");
  EXPECT_EQ(workflow.coupling->fields[0].to, "") << "its receiver is not there: recorded only";
}

TEST_F(Model, WhatIsLeftOutBecomesASwitch) {
  project.write("templates/freefem/ball.edp", "real d = {{diameter}}; bool once = {{once}};\n");
  const std::string text =
      coupled +
      "left_out:\n  once: {of: fluid, what: \"windows 2 to {windows} of {windows}\", "
      "why: linear, when: {fluid: plain}}\n";
  Workflow workflow = project.load(text);
  ASSERT_EQ(workflow.left_out.size(), 1U);
  EXPECT_EQ(workflow.left_out[0].what, "windows 2 to 30 of 30");
  EXPECT_TRUE(workflow.left_out[0].active);
  EXPECT_TRUE(*workflow.participants[1].given.at("once").value.as<bool>());

  workflow = project.load(text, {{"fluid", "meshed"}});
  EXPECT_THAT(workflow.left_out, IsEmpty());
  EXPECT_FALSE(workflow.participants[1].given.contains("once"));

  project.options.keep = {"once"};
  workflow = project.load(text);
  EXPECT_FALSE(workflow.left_out[0].active);
  EXPECT_FALSE(*workflow.participants[1].given.at("once").value.as<bool>());
}

TEST_F(Model, TransformsShapeWhatArrives) {
  const Workflow workflow = project.load(
      coupled +
      R"(    a: {unit: N, shape: [{at_most: 7}, 3], from: fluid, to: grains, transform: mean}
    b: {unit: N, shape: [5, 3], from: fluid, to: grains, transform: linear, samples: 10, initial: 2 kN}
    c: {unit: N, shape: [4], from: fluid, to: grains, transform: max}
)");
  const std::vector<Field>& fields = workflow.coupling->fields;
  ASSERT_EQ(fields.size(), 5U);
  EXPECT_TRUE(fields[2].variable);
  EXPECT_THAT(fields[2].shape, ElementsAre(7, 3));
  EXPECT_THAT(fields[2].received_shape, ElementsAre(3));
  EXPECT_THAT(fields[3].received_shape, ElementsAre(10, 3));
  EXPECT_EQ(fields[3].initial, 2000);
  EXPECT_THAT(fields[4].received_shape, ElementsAre(1));
  EXPECT_EQ(fields[4].transform, Transform::maximum);
}

TEST_F(Model, LiteralsAreTypedByHowTheyAreWritten) {
  project.write("templates/python/all.py",
                "print({{a}}, {{b}}, {{c}}, {{d}}, {{e}}, {{f}}, {{g}}, {{h}}, {{i}})\n");
  const Workflow workflow = project.load(head + R"(stages:
  x:
    run: python
    template: python/all.py
    given: {a: 3, b: 3.0, c: 0.1 mm, d: true, e: "3", f: 2D, g: [1, 2 s, $diameter], h: $diameter, i: {data: icy/figure_2.csv}}
)");
  const GivenMap& given = workflow.stages[0].given;
  EXPECT_EQ(*given.at("a").value.as<std::int64_t>(), 3);
  EXPECT_EQ(*given.at("b").value.as<double>(), 3.0);
  EXPECT_EQ(*given.at("c").value.as<double>(), 1e-4);
  EXPECT_EQ(*given.at("d").value.as<bool>(), true);
  EXPECT_EQ(*given.at("e").value.as<std::string>(), "3");
  EXPECT_EQ(*given.at("f").value.as<std::string>(), "2D");
  const auto* list = given.at("g").value.as<Value::List>();
  ASSERT_NE(list, nullptr);
  ASSERT_EQ(list->size(), 3U);
  EXPECT_EQ(*(*list)[1].as<double>(), 2.0);
  EXPECT_EQ(*(*list)[2].as<double>(), 1e-4);
  EXPECT_EQ(*given.at("h").value.as<double>(), 1e-4);
  EXPECT_EQ(given.at("i").file->stage, "");
  EXPECT_EQ(given.at("i").file->file, "icy/figure_2.csv");
}

TEST_F(Model, CommandsTakeParametersAsWords) {
  const Workflow workflow = project.load(
      head + "stages:\n  x: {run: command, command: [prog, $diameter, '$diameter']}\n");
  EXPECT_THAT(workflow.stages[0].command, ElementsAre("prog", "0.0001", "$diameter"));
}

TEST_F(Model, StagesComeInAnOrderThatWorksAndElseAsWritten) {
  const Workflow workflow = project.load(head + R"(stages:
  last: {run: command, command: [x], after: [second, first]}
  second: {run: command, command: [x], after: [first]}
  first: {run: command, command: [x]}
  other: {run: command, command: [x]}
)");
  EXPECT_THAT(names(workflow.stages), ElementsAre("first", "second", "last", "other"));
}

TEST_F(Model, ComparisonsKnowTheirUnitsAndWhetherTheyHold) {
  const std::string text = coupled + R"(compare:
  - name: printed
    quantity: v
    reference: {value: 9 mm/s, source: paper}
    metric: absolute difference
    tolerance: 1 um/s
    because: digits
    holds_for: {density: [2.65 g/cm3, 2500], fluid: plain}
  - name: meshed only
    quantity: v
    metric: value
    tolerance: 5 %
    because: it is
    when: {fluid: meshed}
)";
  Workflow workflow = project.load(text);
  ASSERT_EQ(workflow.comparisons.size(), 1U);
  const Comparison& printed = workflow.comparisons[0];
  EXPECT_DOUBLE_EQ(*printed.reference_value, 0.009);
  EXPECT_DOUBLE_EQ(printed.tolerance, 1e-6);
  EXPECT_EQ(printed.unit, "mm/s");
  EXPECT_EQ(printed.metric, Metric::absolute_difference);
  ASSERT_EQ(printed.holds_for.size(), 2U);
  EXPECT_EQ(printed.holds_for[0].text, "2.65 g/cm3 or 2500");
  EXPECT_TRUE(printed.holds_for[0].met);
  EXPECT_TRUE(project.load(text, {{"density", "2500.0000000001"}}).comparisons[0].holds_for[0].met)
      << "equal within 1e-9";
  workflow = project.load(text, {{"density", "2501"}, {"fluid", "meshed"}});
  ASSERT_EQ(workflow.comparisons.size(), 2U);
  EXPECT_FALSE(workflow.comparisons[0].holds_for[0].met);
  EXPECT_FALSE(workflow.comparisons[0].holds_for[1].met);
  EXPECT_DOUBLE_EQ(workflow.comparisons[1].tolerance, 0.05);
}

TEST_F(Model, ComparisonsNeedAnAnalysis) {
  EXPECT_THAT(project.problems(
                  changed(coupled, "    analysis: true\n", "") +
                  "compare: [{name: a, quantity: q, metric: value, tolerance: 1, because: x}]\n"),
              ElementsAre("w.yaml:41:10: no analysis stage computes what is compared"));
}

}  // namespace
}  // namespace sandglass::workflow
