#include "participant/participant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "../support/errors.hpp"
#include "../support/processes.hpp"
#include "../support/scratch.hpp"
#include "base/file.hpp"
#include "process/interrupt.hpp"

namespace sandglass::participant {
namespace {

using test::error_of;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Numbers = std::vector<double>;
using Words = std::vector<std::string>;

/// Debian's Python, as for every Python participant: h5py is there.
constexpr const char* kPython = "/usr/bin/python3";
constexpr double kLong = 60;    // s; nothing here takes that long unless it hangs
constexpr double kShort = 2.0;  // s; longer than a scripted participant takes to start

/// Real processes that do as they are told (tests/faults/scripted_participant.py). Each receives
/// "drag" [2] and "positions" [up to 2, 2], and sends "velocity" [3] and "forces" [2, 2].
class ParticipantTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { Interrupt::install(); }
  // A hang is a failure too.
  void SetUp() override { ::alarm(50); }
  void TearDown() override { ::alarm(0); }

  [[nodiscard]] Description description(const std::string& name, const Words& told = {}) const {
    Description made;
    made.name = name;
    made.command.arguments = {kPython, "-E", "-S", "-B", faults() + "/scripted_participant.py"};
    made.command.arguments.insert(made.command.arguments.end(), told.begin(), told.end());
    complete(made);
    return made;
  }
  /// One that computes the same through the Python module, mapped or by files.
  [[nodiscard]] Description summing(const std::string& name, bool mapped,
                                    const Words& told = {}) const {
    Description made;
    made.name = name;
    made.command.arguments = {kPython, faults() + "/summing_participant.py"};
    made.command.arguments.insert(made.command.arguments.end(), told.begin(), told.end());
    made.command.environment = {
        {"PYTHONPATH", std::string(SANDGLASS_SOURCE_DIR) + "/templates/python"},
        {"PYTHONDONTWRITEBYTECODE", "1"},
        {"INPUTS", "drag positions"},
        {"OUTPUTS", "velocity=3 forces=2,2"}};
    made.mapped = mapped;
    complete(made);
    return made;
  }
  void complete(Description& made) const {
    made.work_directory = scratch_.file(made.name);
    std::filesystem::create_directories(made.work_directory);
    made.command.directory = made.work_directory;
    made.command.log = log_of(made.name);
    made.slot = scratch_.file(made.name + ".h5");
    made.inputs = {{"drag", "N", {2}}, {"positions", "m", {2, 2}}};
    made.outputs = {{"velocity", "m/s", {3}}, {"forces", "N", {2, 2}}};
    made.deadline = kLong;
  }
  static std::string faults() { return std::string(SANDGLASS_SOURCE_DIR) + "/tests/faults"; }
  [[nodiscard]] std::string log_of(const std::string& name) const {
    return scratch_.file(name + ".log");
  }
  /// What it was asked, one command a line, without the paths.
  [[nodiscard]] Words asked(const std::string& name) const {
    Words commands;
    std::istringstream log(read_file(log_of(name)));
    for (std::string line; std::getline(log, line);) {
      std::istringstream words(line);
      std::string first;
      std::string command;
      if (words >> first >> command && first == "asked") commands.push_back(command);
    }
    return commands;
  }

  static void set_up(Participant& one) {
    one.start();
    one.wait_until_ready();
  }
  static void give(Participant& one, std::int64_t index) {
    const auto number = static_cast<double>(index);
    one.slot().give(0, Numbers{number, 0.25}, {2});
    // One row in odd windows, two in even ones.
    const std::int64_t rows = index % 2 == 0 ? 2 : 1;
    one.slot().give(1, Numbers(2 * static_cast<size_t>(rows), 0.5), {rows, 2});
  }
  static void compute(Participant& one, std::int64_t index) {
    give(one, index);
    one.begin({index, 1, static_cast<double>(index - 1), static_cast<double>(index)});
    one.finish();
  }
  /// What a scripted participant's state is after so many windows.
  static double state_after(std::int64_t windows) {
    double state = 0;
    for (std::int64_t index = 1; index <= windows; ++index) {
      const auto number = static_cast<double>(index);
      state += (number + 0.25) + (index % 2 == 0 ? 2.0 : 1.0);
      state += number;
    }
    return state;
  }
  static Numbers taken(Participant& one, size_t output) {
    const auto values = one.slot().take(output).values;
    return {values.begin(), values.end()};
  }

  /// Runs one that is told to misbehave until that ends the run; nothing is left of it.
  [[nodiscard]] Error failure(Description made, std::int64_t windows = 3) {
    made.deadline = std::min(made.deadline, deadline_);
    pid_t process = 0;
    const std::string process_file = made.work_directory + "/grandchild";
    Error error = error_of([&] {
      Watch watch;
      Participant one(made, watch);
      if (!made.fresh) set_up(one);
      for (std::int64_t index = 1; index <= windows; ++index) compute(one, index);
      one.stop();
    });
    EXPECT_EQ(error.code(), ExitCode::participant);
    EXPECT_THAT(error.what(), HasSubstr("participant " + made.name));
    EXPECT_THAT(error.what(), HasSubstr(made.command.log)) << "the end of its log";
    if (std::filesystem::exists(process_file)) {
      process = test::process_written_to(process_file);
      EXPECT_TRUE(test::gone(process));
    }
    EXPECT_TRUE(nothing_runs_in(made.work_directory));
    return error;
  }
  /// No process has the folder as its working directory.
  static bool nothing_runs_in(const std::string& folder) {
    return test::comes_true([&] {
      for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
        std::error_code other;
        const auto where = std::filesystem::read_symlink(entry.path() / "cwd", other);
        if (!other && where == std::filesystem::canonical(folder)) return false;
      }
      return true;
    });
  }

  test::Scratch scratch_;
  double deadline_ = kLong;
};

// ---- all is well

TEST_F(ParticipantTest, AdvancesWindowByWindow) {
  Watch watch;
  Participant one(description("fluid"), watch);
  set_up(one);
  EXPECT_THAT(one.abilities(), ElementsAre("disk", "memory"));
  for (std::int64_t index = 1; index <= 4; ++index) {
    compute(one, index);
    const double state = state_after(index);
    EXPECT_THAT(taken(one, 0), ElementsAre(2 * 0 + state, 2 * state, 3 * state)) << index;
    EXPECT_THAT(one.slot().take(0).shape, ElementsAre(3));
    EXPECT_THAT(one.slot().take(1).shape, ElementsAre(2, 2));
  }
  one.stop();
  EXPECT_GT(one.peak_memory_bytes(), 0);
  EXPECT_THAT(asked("fluid"),
              ElementsAre("ready", "advance", "advance", "advance", "advance", "stop"));
  EXPECT_TRUE(nothing_runs_in(scratch_.file("fluid")));
}

TEST_F(ParticipantTest, StoppingTwiceIsStoppingOnce) {
  Watch watch;
  Participant one(description("fluid"), watch);
  one.stop();
  set_up(one);
  one.stop();
  EXPECT_NO_THROW(one.stop());
}

TEST_F(ParticipantTest, SeveralStartAndWorkAtTheSameTime) {
  Watch watch;
  Participant first(description("fluid"), watch);
  Participant second(description("grains"), watch);
  first.start();
  second.start();
  first.wait_until_ready();
  second.wait_until_ready();
  give(first, 1);
  give(second, 1);
  first.begin({1, 1, 0, 1});
  second.begin({1, 1, 0, 1});
  first.finish();
  second.finish();
  EXPECT_EQ(taken(first, 0), taken(second, 0));
  first.stop();
  second.stop();
}

TEST_F(ParticipantTest, FreshInEveryWindowGivesTheSameNumbers) {
  Watch watch;
  Description fresh_description = description("fresh");
  fresh_description.fresh = true;
  Participant fresh(fresh_description, watch);
  Participant resident(description("resident"), watch);
  set_up(resident);
  for (std::int64_t index = 1; index <= 4; ++index) {
    compute(fresh, index);
    compute(resident, index);
    EXPECT_EQ(taken(fresh, 0), taken(resident, 0)) << index;
    EXPECT_TRUE(nothing_runs_in(scratch_.file("fresh"))) << "between windows";
  }
  EXPECT_THAT(asked("fresh"), ElementsAre("ready", "advance", "checkpoint", "stop",          //
                                          "ready", "load", "advance", "checkpoint", "stop",  //
                                          "ready", "load", "advance", "checkpoint", "stop",  //
                                          "ready", "load", "advance", "checkpoint", "stop"));
  std::ptrdiff_t states = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scratch_.file("fresh"))) {
    if (entry.path().filename().string().rfind("state-", 0) == 0) ++states;
  }
  EXPECT_EQ(states, 1) << "the newest state only";
}

TEST_F(ParticipantTest, AStatelessOneNeedsNoStateToBeFresh) {
  Watch watch;
  Description made = description("fluid", {"--abilities", "stateless"});
  made.fresh = true;
  Participant one(made, watch);
  compute(one, 1);
  compute(one, 2);
  EXPECT_THAT(asked("fluid"), ElementsAre("ready", "advance", "stop", "ready", "advance", "stop"));
  EXPECT_NO_THROW(one.save()) << "there is nothing to keep";
}

TEST_F(ParticipantTest, GoesBackToTheStateKeptLast) {
  Watch watch;
  Participant one(description("fluid"), watch);
  set_up(one);
  compute(one, 1);
  one.save();
  compute(one, 2);
  const Numbers first_time = taken(one, 0);
  one.restore();
  compute(one, 2);
  EXPECT_EQ(taken(one, 0), first_time);
  one.checkpoint(scratch_.file("state with a space"));
  compute(one, 3);
  const Numbers third = taken(one, 0);
  one.go_on_from(scratch_.file("state with a space"), 2);
  compute(one, 3);
  EXPECT_EQ(taken(one, 0), third);
  one.stop();
}

TEST_F(ParticipantTest, TheWindowScriptIsToldOnceItIsReadyAndWhenItChanges) {
  Watch watch;
  Description made = description("grains");
  made.window_script = scratch_.file("first.py");
  Participant one(made, watch);
  set_up(one);
  compute(one, 1);
  one.use_window_script(scratch_.file("second.py"));
  compute(one, 2);
  one.stop();
  EXPECT_THAT(asked("grains"),
              ElementsAre("ready", "script", "advance", "script", "advance", "stop"));
  EXPECT_THAT(read_file(log_of("grains")),
              AllOf(HasSubstr(made.window_script), HasSubstr(scratch_.file("second.py"))));
}

TEST_F(ParticipantTest, NotesAndSavingsAreKept) {
  Watch watch;
  Participant one(description("fluid", {"advance@1", "before=note the mesh is coarse: h = 1 mm",
                                        "advance@2", "before=saved solve 12.5", "advance@3",
                                        "before=saved solve 25", "stop", "before=saved mesh 3"}),
                  watch);
  set_up(one);
  for (std::int64_t index = 1; index <= 3; ++index) compute(one, index);
  one.stop();
  EXPECT_THAT(one.notes(), ElementsAre("the mesh is coarse: h = 1 mm"));
  ASSERT_EQ(one.savings().size(), 2U);
  EXPECT_EQ(one.savings()[0].name, "solve");
  EXPECT_EQ(one.savings()[0].seconds, 25) << "in this run so far: the newest counts";
  EXPECT_EQ(one.savings()[1].name, "mesh");
}

TEST_F(ParticipantTest, WithinItsDeadlineItMayTakeItsTime) {
  Watch watch;
  Participant one(description("fluid", {"ready", "late=0.1", "advance@1", "late=0.1"}), watch);
  set_up(one);
  compute(one, 1);
  EXPECT_EQ(taken(one, 0)[0], state_after(1));
  one.stop();
}

TEST_F(ParticipantTest, ThroughThePythonModuleFilesEqualMemory) {
  Watch watch;
  Participant mapped(summing("mapped", true), watch);
  Participant files(summing("files", false), watch);
  mapped.start();
  files.start();
  mapped.wait_until_ready();
  files.wait_until_ready();
  for (std::int64_t index = 1; index <= 3; ++index) {
    compute(mapped, index);
    compute(files, index);
    EXPECT_EQ(taken(mapped, 0)[0], state_after(index));
    for (const size_t output : {0U, 1U}) {
      EXPECT_EQ(taken(mapped, output), taken(files, output));
      EXPECT_EQ(mapped.slot().take(output).shape, files.slot().take(output).shape);
    }
    EXPECT_GT(files.slot().seconds(), 0);
  }
  mapped.stop();
  files.stop();
  EXPECT_TRUE(std::filesystem::is_empty(scratch_.file("files"))) << "used files are gone";
}

// ---- how it ends

TEST_F(ParticipantTest, ThatExitsIsNamedWithWindowStatusAndLog) {
  const Error error = failure(description("fluid", {"advance@2", "exit=3"}));
  EXPECT_THAT(error.what(), AllOf(HasSubstr("fluid, window 2"), HasSubstr("exit status 3"),
                                  HasSubstr("'advance'"), HasSubstr("leaving on purpose")));
}

TEST_F(ParticipantTest, ThatExitsWithStatusZeroHasFailedToo) {
  EXPECT_THAT(failure(description("fluid", {"advance@2", "exit=0"})).what(),
              AllOf(HasSubstr("window 2"), HasSubstr("exit status 0")));
}

TEST_F(ParticipantTest, ThatIsKilledIsNamedWithTheSignal) {
  EXPECT_THAT(failure(description("fluid", {"advance@3", "kill"})).what(),
              AllOf(HasSubstr("window 3"), HasSubstr("killed by signal 9 (SIGKILL)")));
}

TEST_F(ParticipantTest, ThatDiesBetweenWindowsIsFoundAtTheNext) {
  EXPECT_THAT(failure(description("fluid", {"advance@1", "exit-soon=4"})).what(),
              AllOf(HasSubstr("window 2"), HasSubstr("exit status 4")));
}

TEST_F(ParticipantTest, ThatDiesBeforeItIsReady) {
  EXPECT_THAT(failure(description("fluid", {"ready", "exit=1"})).what(),
              HasSubstr("exit status 1"));
}

TEST_F(ParticipantTest, WithAnErrorInItsScriptShowsIt) {
  Description made = description("fluid");
  made.command.arguments = {kPython, "-c", "import no_such_module"};
  EXPECT_THAT(failure(made).what(),
              AllOf(HasSubstr("exit status 1"), HasSubstr("No module named 'no_such_module'")));
}

TEST_F(ParticipantTest, ThatExitsBadlyAfterStop) {
  EXPECT_THAT(failure(description("fluid", {"stop", "exit-soon=5"})).what(),
              HasSubstr("exit status 5"));
}

TEST_F(ParticipantTest, WhoseProgramIsMissingIsTheEnvironmentsFault) {
  Watch watch;
  Description made = description("fluid");
  made.command.arguments = {"no-such-solver"};
  Participant one(made, watch);
  const Error error = error_of([&] { one.start(); });
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("fluid"), HasSubstr("no-such-solver")));
}

TEST_F(ParticipantTest, AnothersDeathIsNamedWhileThisOneIsAwaited) {
  Watch watch;
  Participant fluid(description("fluid", {"advance@2", "stall"}), watch);
  Participant grains(description("grains", {"advance@2", "exit=7"}), watch);
  fluid.start();
  grains.start();
  fluid.wait_until_ready();
  grains.wait_until_ready();
  compute(fluid, 1);
  compute(grains, 1);
  give(fluid, 2);
  give(grains, 2);
  fluid.begin({2, 1, 1, 2});
  grains.begin({2, 1, 1, 2});
  const Error error = error_of([&] { fluid.finish(); });
  EXPECT_EQ(error.code(), ExitCode::participant);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("participant grains"), HasSubstr("window 2"),
                                  HasSubstr("exit status 7"), HasSubstr("while fluid was at work"),
                                  HasSubstr("leaving on purpose")));
}

TEST_F(ParticipantTest, AnothersReasonIsToldWithItsEnd) {
  Watch watch;
  Participant fluid(description("fluid", {"ready", "stall"}), watch);
  Participant grains(
      description("grains", {"ready", "say=error no licence", "ready", "exit-soon=1"}), watch);
  fluid.start();
  grains.start();
  const Error error = error_of([&] { fluid.wait_until_ready(); });
  EXPECT_EQ(error.code(), ExitCode::participant);
  EXPECT_THAT(error.what(), HasSubstr("participant grains ended by itself (exit status 1) before "
                                      "all were ready: no licence"));
}

// ---- silence

TEST_F(ParticipantTest, ThatNeverAnswersMeetsItsDeadline) {
  deadline_ = kShort;
  const Error error = failure(description("fluid", {"advance@2", "stall"}));
  EXPECT_THAT(error.what(), AllOf(HasSubstr("fluid, window 2"), HasSubstr("'advance'"),
                                  HasSubstr("deadline of 2 s"), HasSubstr("asked advance")));
  EXPECT_THAT(test::remedy_of(error), HasSubstr("deadline"));
}

TEST_F(ParticipantTest, ThatIsNeverReadyMeetsItsDeadline) {
  deadline_ = kShort;
  EXPECT_THAT(failure(description("fluid", {"ready", "stall"})).what(), HasSubstr("deadline"));
}

TEST_F(ParticipantTest, ThatIsTooLateMeetsItsDeadline) {
  deadline_ = kShort;
  EXPECT_THAT(failure(description("fluid", {"advance@1", "late=30"})).what(),
              HasSubstr("deadline"));
}

TEST_F(ParticipantTest, ThatWritesHalfALineMeetsItsDeadline) {
  deadline_ = kShort;
  EXPECT_THAT(failure(description("fluid", {"advance@2", "half"})).what(),
              AllOf(HasSubstr("window 2"), HasSubstr("deadline")));
}

TEST_F(ParticipantTest, ThatDiesInTheMiddleOfALine) {
  EXPECT_THAT(failure(description("fluid", {"advance@2", "half-exit=6"})).what(),
              AllOf(HasSubstr("window 2"), HasSubstr("exit status 6")));
}

TEST_F(ParticipantTest, ThatIsDeafAfterStopMeetsItsDeadline) {
  deadline_ = kShort;
  EXPECT_THAT(failure(description("fluid", {"stop", "deaf"})).what(),
              AllOf(HasSubstr("did not exit"), HasSubstr("2 s")));
}

TEST_F(ParticipantTest, ItsOwnChildrenEndWithIt) {
  for (const std::string end : {"exit=3", "stall"}) {
    deadline_ = end == "stall" ? kShort : kLong;
    const Description made = description("fluid", {"advance@1", "grandchild", "advance@2", end});
    static_cast<void>(failure(made));
    ASSERT_TRUE(std::filesystem::exists(made.work_directory + "/grandchild"));
  }
}

TEST_F(ParticipantTest, ThatIsLeftInTheMiddleIsEnded) {
  {
    Watch watch;
    Participant one(description("fluid", {"advance@1", "grandchild", "advance@2", "deaf"}), watch);
    set_up(one);
    compute(one, 1);
    compute(one, 2);
  }
  EXPECT_TRUE(nothing_runs_in(scratch_.file("fluid")));
}

// ---- too much talk

TEST_F(ParticipantTest, ThatTalksWithoutEndMeetsItsDeadlineToo) {
  deadline_ = kShort;
  for (const std::string how : {"drip", "flood"}) {
    EXPECT_THAT(failure(description("fluid", {"advance@2", how})).what(),
                AllOf(HasSubstr("window 2"), HasSubstr("deadline")))
        << how;
  }
}

TEST_F(ParticipantTest, ThatWritesOneEndlessLine) {
  EXPECT_THAT(failure(description("fluid", {"advance@2", "endless"})).what(),
              AllOf(HasSubstr("window 2"), HasSubstr("line without end")));
}

TEST_F(ParticipantTest, ThatAnswersTwiceIsNotHeardAsAnsweringTheNext) {
  EXPECT_THAT(failure(description("fluid", {"advance@1", "say=ok\nok"})).what(),
              AllOf(HasSubstr("'ok'"), HasSubstr("without being asked")));
}

// ---- wrong words

TEST_F(ParticipantTest, ThatSaysErrorIsQuoted) {
  EXPECT_THAT(
      failure(description("fluid", {"advance@2", "say=error the matrix is singular"})).what(),
      AllOf(HasSubstr("fluid, window 2"), HasSubstr("'advance'"),
            HasSubstr("the matrix is singular")));
  EXPECT_THAT(failure(description("mute", {"advance@2", "say=error"})).what(),
              HasSubstr("no reason given"));
}

TEST_F(ParticipantTest, ThatCannotBeSetUpSaysWhy) {
  EXPECT_THAT(failure(description("fluid", {"ready", "say=error no mesh"})).what(),
              AllOf(HasSubstr("could not be set up"), HasSubstr("no mesh")));
}

TEST_F(ParticipantTest, OfAnotherProtocolIsRefused) {
  const Error error = failure(description("fluid", {"ready", "say=ready 2 memory"}));
  EXPECT_THAT(error.what(), AllOf(HasSubstr("'ready 2 memory'"), HasSubstr("'ready 1'")));
  EXPECT_THAT(test::remedy_of(error), HasSubstr("templates/README.md"));
  for (const std::string words : {"ready", "hello", "ok", ""}) {
    static_cast<void>(failure(description("odd", {"ready", "say=" + words})));
  }
}

TEST_F(ParticipantTest, ThatAnswersSomethingElseIsQuoted) {
  for (const std::string words : {"okay", "OK", "", "note", "ready 1"}) {
    EXPECT_THAT(failure(description("fluid", {"advance@2", "say=" + words})).what(),
                AllOf(HasSubstr("window 2"), HasSubstr("'" + words + "'")));
  }
}

TEST_F(ParticipantTest, ThatIsToBeFreshButCannot) {
  Description made = description("fluid", {"--abilities", "memory"});
  made.fresh = true;
  const Error error = failure(made);
  EXPECT_THAT(test::remedy_of(error), HasSubstr("resident"));
  EXPECT_THAT(asked("fluid"), ElementsAre("ready")) << "told before it has computed in vain";
}

TEST_F(ParticipantTest, ThatIsFreshAndFailsInALaterWindow) {
  Description made = description("fluid", {"advance@3", "exit=3"});
  made.fresh = true;
  EXPECT_THAT(failure(made).what(), AllOf(HasSubstr("window 3"), HasSubstr("exit status 3")));
}

// ---- wrong numbers: they arrive as they are, and the coupling judges them

TEST_F(ParticipantTest, ANotANumberArrivesAsIt) {
  Watch watch;
  Participant one(description("fluid", {"advance@1", "value=nan", "advance@2", "value=-inf"}),
                  watch);
  set_up(one);
  compute(one, 1);
  EXPECT_TRUE(std::isnan(taken(one, 0)[0]));
  EXPECT_TRUE(std::isfinite(taken(one, 0)[1]));
  compute(one, 2);
  EXPECT_EQ(taken(one, 0)[0], -std::numeric_limits<double>::infinity());
  one.stop();
}

TEST_F(ParticipantTest, AWrongShapeArrivesAsItIs) {
  Watch watch;
  Participant one(
      description("fluid",
                  {"advance@1", "rows=1", "advance@2", "rows=1000", "advance@3", "columns=9",
                   "advance@4", "rows=-9000000000000000000", "advance@5",
                   "rows=9000000000000000000", "advance@5", "columns=9000000000000000000"}),
      watch);
  set_up(one);
  const exchange::Shape forces[] = {{1, 2},
                                    {1000, 2},
                                    {2, 9},
                                    {-9000000000000000000, 2},
                                    {9000000000000000000, 9000000000000000000}};
  for (std::int64_t index = 1; index <= 5; ++index) {
    compute(one, index);
    EXPECT_EQ(one.slot().take(1).shape, forces[index - 1]);
    EXPECT_LE(one.slot().take(1).values.size(), 4U);
  }
  one.stop();
}

TEST_F(ParticipantTest, WhatItForgetsIsMissingAlsoAfterItWasSentBefore) {
  Watch watch;
  Participant one(description("fluid", {"advance@2", "forget"}), watch);
  set_up(one);
  compute(one, 1);
  EXPECT_EQ(one.slot().take(0).shape.at(0), 3);
  compute(one, 2);
  EXPECT_LT(one.slot().take(0).shape.at(0), 0);
  one.stop();
}

TEST_F(ParticipantTest, ThroughFilesAWrongNumberOfAxesIsSeen) {
  Watch watch;
  Participant one(summing("files", false, {"velocity=1,3"}), watch);
  set_up(one);
  compute(one, 1);
  EXPECT_THAT(one.slot().take(0).shape, ElementsAre(1, 3));
  EXPECT_THAT(one.slot().take(1).shape, ElementsAre(2, 2));
  one.stop();
}

TEST_F(ParticipantTest, ThroughFilesAMissingAnswerIsAFailure) {
  // The scripted one says ok, but it knows nothing of files.
  Description made = description("fluid");
  made.mapped = false;
  EXPECT_THAT(failure(made).what(),
              AllOf(HasSubstr("window 1"), HasSubstr("no readable file"), HasSubstr(".out.h5")));
}

}  // namespace
}  // namespace sandglass::participant
