#include <gmock/gmock.h>

#include "project.hpp"

namespace sandglass::workflow {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class StudyKey : public testing::Test {
 protected:
  Project project;
};

TEST_F(StudyKey, AStudyOfAnotherWorkflowNeedsNoStages) {
  const Workflow workflow = project.load(R"(sandglass: 1
name: sweep
study:
  of: scenes/ball.yaml
  set: {end_time: 1 s}
  judge: false
  points:
    - name: windows
      grid: {window: [1 ms, 2 ms]}
      seeds: {seed: [1, 2]}
      repeat: 3
    - list: [{density: 1, window: 3 ms}]
      expect: unstable
  work_precision: [{error: mistake, points: [windows], reference: {value: 2 m}, method: [window], seconds: [fluid]}]
)");
  const Study& study = *workflow.study;
  EXPECT_EQ(study.of, "scenes/ball.yaml");
  EXPECT_FALSE(study.judge);
  ASSERT_EQ(study.points.size(), 2U);
  EXPECT_EQ(study.points[0].grid[0][1].text, "2 ms");
  EXPECT_EQ(study.points[0].grid[0][1].place.text(), "w.yaml:9:29");
  EXPECT_EQ(study.points[0].seeds[0].size(), 2U);
  EXPECT_EQ(study.points[0].repeat, 3);
  EXPECT_TRUE(study.points[1].unstable);
  EXPECT_EQ(study.points[1].list[0][1].text, "3 ms");
  EXPECT_EQ(study.work_precision[0].reference_value, 2.0);
  EXPECT_THAT(workflow.stages, IsEmpty());
}

TEST_F(StudyKey, AllThatIsWrongComesInOnePass) {
  EXPECT_THAT(project.problems(R"(sandglass: 1
name: sweep
study:
  of: ball.yaml
  points:
    - grid: {window: 1 ms, gird: []}
      set: {seed: [1]}
    - set: {window: 1 ms}
      grid: {window: [1 ms]}
      expect: unstabel
    - name: windows
  work_precision:
    - {error: mistake, points: [window]}
    - {error: mistake, reference: {curve: c}}
)"),
              ElementsAre("w.yaml:6:14: 'window' under 'grid' must be a list of values",
                          "w.yaml:6:28: 'gird' under 'grid' must be a list of values",
                          "w.yaml:7:13: 'seed' under 'set' must be a single value",
                          "w.yaml:9:23: parameter 'window' is set twice here",
                          "w.yaml:10:15: 'unstabel' is not valid for 'expect'",
                          "w.yaml:13:33: there is no set of points 'window'",
                          "w.yaml:14:7: a second diagram of 'mistake'",
                          "w.yaml:14:35: a reference of an error that is a number"));
}

TEST_F(StudyKey, WithoutStagesAWorkflowIsNone) {
  EXPECT_THAT(project.problems("sandglass: 1\nname: nothing\n"),
              ElementsAre("w.yaml:1:1: a workflow needs 'stages'"));
}

}  // namespace
}  // namespace sandglass::workflow
