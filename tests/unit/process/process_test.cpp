#include "process/process.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "../support/errors.hpp"
#include "../support/processes.hpp"
#include "../support/scratch.hpp"
#include "base/file.hpp"
#include "process/interrupt.hpp"

namespace sandglass {
namespace {

using test::error_of;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kLong = 60;  // s; nothing here takes that long unless it hangs

class RunToEnd : public testing::Test {
 protected:
  [[nodiscard]] Command command(std::vector<std::string> arguments) const {
    return {std::move(arguments), scratch_.path(), {}, log_};
  }
  /// A program of the test's own, in the language of the shell; nobody but it calls the shell.
  [[nodiscard]] Command script(const std::string& text) const {
    std::ofstream(scratch_.file("program")) << "#!/bin/sh\n" << text;
    ::chmod(scratch_.file("program").c_str(), 0755);
    return command({scratch_.file("program")});
  }
  [[nodiscard]] std::string log() const { return read_file(log_); }

  test::Scratch scratch_;
  std::string log_ = scratch_.file("program.log");
};

TEST_F(RunToEnd, ArgumentsArriveAsTheyAre) {
  const std::vector<std::string> given{
      "plain",           "with space",   "",           "\"quoted\" 'both'",
      "$(touch hacked)", "`id`;&|<>*?~", "two\nlines", "back\\slash",
      "--option=value",  "ümläut"};
  std::vector<std::string> arguments{"printf", "%s\\001"};
  arguments.insert(arguments.end(), given.begin(), given.end());
  run_to_end("printf", command(arguments), kLong);
  std::string expected;
  for (const std::string& argument : given) expected += argument + '\001';
  EXPECT_EQ(log(), expected);
  EXPECT_FALSE(std::filesystem::exists(scratch_.file("hacked")));
}

TEST_F(RunToEnd, OutputAndErrorsGoToTheLogOneAfterTheOther) {
  run_to_end("both", script("echo one; echo two >&2; echo three\n"), kLong);
  run_to_end("again", script("echo four\n"), kLong);
  EXPECT_EQ(log(), "one\ntwo\nthree\nfour\n");
}

TEST_F(RunToEnd, WithoutALogNothingIsWrittenAnywhere) {
  Command quiet = script("echo one; echo two >&2\n");
  quiet.log.clear();
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  run_to_end("quiet", quiet, kLong);
  EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
}

TEST_F(RunToEnd, ItStartsInItsDirectoryWithItsEnvironmentAndNoInput) {
  ::setenv("SANDGLASS_TEST_INHERITED", "from above", 1);
  ::setenv("SANDGLASS_TEST_CHANGED", "old", 1);
  ::setenv("SANDGLASS_COMMANDS", "77", 1);
  std::filesystem::create_directory(scratch_.file("inside it"));
  Command with = script(
      "pwd -P; echo \"$SANDGLASS_TEST_INHERITED, $SANDGLASS_TEST_CHANGED, $SANDGLASS_TEST_NEW, "
      "${SANDGLASS_COMMANDS-none}\"; cat; echo end\n");
  with.directory = scratch_.file("inside it");
  with.environment = {{"SANDGLASS_TEST_CHANGED", "new"}, {"SANDGLASS_TEST_NEW", "a=b c"}};
  run_to_end("script", with, kLong);
  EXPECT_EQ(log(), std::filesystem::canonical(with.directory).string() +
                       "\nfrom above, new, a=b c, none\nend\n");
  for (const char* name : {"INHERITED", "CHANGED"}) {
    ::unsetenv((std::string("SANDGLASS_TEST_") + name).c_str());
  }
  ::unsetenv("SANDGLASS_COMMANDS");
}

TEST_F(RunToEnd, ARelativeProgramIsSoughtWhereWeAre) {
  static_cast<void>(script("echo found\n"));
  const auto here = std::filesystem::current_path();
  std::filesystem::create_directory(scratch_.file("elsewhere"));
  std::filesystem::current_path(scratch_.path());
  Command relative = command({"./program"});
  relative.directory = scratch_.file("elsewhere");
  EXPECT_NO_THROW(run_to_end("program", relative, kLong));
  std::filesystem::current_path(here);
  EXPECT_EQ(log(), "found\n");
}

TEST_F(RunToEnd, TheEndIsReported) {
  const Exit ended = run_to_end("script", script("exit 0\n"), kLong);
  EXPECT_TRUE(ended.good());
  EXPECT_GT(ended.peak_memory_bytes, 0);
}

TEST_F(RunToEnd, AFailureNamesWhoHowAndTheEndOfTheLog) {
  const Error error = error_of([&] {
    run_to_end("stage mesh", script("for i in $(seq 100); do echo line $i; done; exit 3\n"), kLong);
  });
  EXPECT_EQ(error.code(), ExitCode::participant);
  EXPECT_THAT(error.what(),
              AllOf(HasSubstr("stage mesh"), HasSubstr("exit status 3"), HasSubstr(log_),
                    HasSubstr("line 100"), HasSubstr("line 86"), Not(HasSubstr("line 85"))));
}

TEST_F(RunToEnd, ADeathBySignalIsNamed) {
  const Error error = error_of([&] { run_to_end("script", script("kill -9 $$\n"), kLong); });
  EXPECT_EQ(error.code(), ExitCode::participant);
  EXPECT_THAT(error.what(), HasSubstr("killed by signal 9 (SIGKILL)"));
  EXPECT_THAT((Exit{true, SIGSEGV, 0}.text()), HasSubstr("(SIGSEGV)"));
  EXPECT_THAT((Exit{true, 60, 0}.text()), HasSubstr("signal 60"));
}

TEST_F(RunToEnd, AMissingProgramIsTheEnvironmentsFault) {
  for (const std::string program : {"no-such-program-at-all", "/no/such/program"}) {
    const Error error = error_of([&] { run_to_end("stage mesh", command({program}), kLong); });
    EXPECT_EQ(error.code(), ExitCode::environment);
    EXPECT_EQ(static_cast<int>(error.code()), 7);
    EXPECT_THAT(error.what(), AllOf(HasSubstr("stage mesh"), HasSubstr(program)));
    EXPECT_THAT(test::remedy_of(error), HasSubstr("doctor"));
  }
}

TEST_F(RunToEnd, WhatCannotBeExecutedSaysWhy) {
  std::ofstream(scratch_.file("program")) << "#!/no/such/interpreter\n";
  ::chmod(scratch_.file("program").c_str(), 0755);
  const Error error =
      error_of([&] { run_to_end("tool", command({scratch_.file("program")}), kLong); });
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), AllOf(HasSubstr("tool"), HasSubstr(scratch_.file("program")),
                                  HasSubstr("No such file or directory")));
}

TEST_F(RunToEnd, AMissingDirectoryIsNotBlamedOnTheProgram) {
  Command lost = command({"true"});
  lost.directory = scratch_.file("nowhere");
  const Error error = error_of([&] { run_to_end("tool", lost, kLong); });
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), HasSubstr(lost.directory));
}

TEST_F(RunToEnd, ALogThatCannotBeWrittenIsNamed) {
  Command lost = command({"true"});
  lost.log = scratch_.file("nowhere/x.log");
  const Error error = error_of([&] { run_to_end("tool", lost, kLong); });
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), HasSubstr(lost.log));
}

TEST_F(RunToEnd, TheDeadlineEndsTheWholeGroup) {
  const Command slow =
      script("sleep 1000 & echo $! > grandchild\necho $$ > child\necho began\nwait\n");
  // Time enough to start, not to sleep.
  const Error error = error_of([&] { run_to_end("stage mesh", slow, 0.5); });
  EXPECT_EQ(error.code(), ExitCode::participant);
  EXPECT_THAT(error.what(),
              AllOf(HasSubstr("stage mesh"), HasSubstr("deadline of 0.5 s"), HasSubstr("began")));
  EXPECT_THAT(test::remedy_of(error), HasSubstr("deadline"));
  for (const char* who : {"child", "grandchild"}) {
    const pid_t process = test::process_written_to(scratch_.file(who));
    ASSERT_GT(process, 0);
    EXPECT_TRUE(test::gone(process)) << who;
  }
}

TEST_F(RunToEnd, WhatAProgramLeavesRunningIsEndedWithIt) {
  run_to_end("script", script("sleep 1000 &\necho $! > grandchild\n"), kLong);
  EXPECT_TRUE(test::gone(test::process_written_to(scratch_.file("grandchild"))));
}

TEST_F(RunToEnd, OfOurDescriptorsItGetsNone) {
  // One that we have ourselves inherited, from a careless shell: not marked close-on-exec.
  const int careless = ::open("/dev/null", O_RDONLY);
  ASSERT_GE(careless, 0);
  ASSERT_EQ(::fcntl(careless, F_DUPFD, 100), 100);
  run_to_end("ls", script("ls /proc/$$/fd\n"), kLong);
  ::close(careless);
  ::close(100);
  // 10 is the shell's own: the script that it reads.
  EXPECT_THAT(log(), testing::AnyOf("0\n1\n10\n2\n", "0\n1\n2\n"));
}

TEST_F(RunToEnd, FailedStartsLeaveNoDescriptors) {
  const Command bad = command({scratch_.file("program")});
  std::ofstream(scratch_.file("program")) << "#!/no/such/interpreter\n";
  ::chmod(scratch_.file("program").c_str(), 0755);
  error_of([&] { run_to_end("tool", bad, kLong); });
  const int before = test::open_descriptors();
  for (int i = 0; i < 5; ++i) error_of([&] { run_to_end("tool", bad, kLong); });
  run_to_end("true", command({"true"}), kLong);
  EXPECT_EQ(test::open_descriptors(), before);
}

TEST_F(RunToEnd, ItMeetsSignalsAsAFreshProgramDoes) {
  const Command shows = script("grep SigIgn /proc/self/status\n");
  EXPECT_EQ(test::run_elsewhere([&] {
              Interrupt::install();
              ::signal(SIGINT, SIG_IGN);
              return run_to_end("grep", shows, kLong).good() ? 0 : 1;
            }),
            0);
  const std::uint64_t ignored = std::stoull(log().substr(log().find(':') + 1), nullptr, 16);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) {
    EXPECT_EQ(ignored >> (number - 1) & 1U, 0U) << strsignal(number);
  }
}

TEST_F(RunToEnd, AnInterruptEndsTheProgramFirst) {
  const Command slow = script("sleep 1000 & echo $! > grandchild\necho $$ > child\nwait\n");
  for (const int signal_number : {SIGINT, SIGTERM}) {
    const pid_t orchestrator = test::start_elsewhere([&] {
      Interrupt::install();
      run_to_end("slow", slow, kLong);
      return 0;
    });
    const pid_t child = test::process_written_to(scratch_.file("child"));
    const pid_t grandchild = test::process_written_to(scratch_.file("grandchild"));
    ASSERT_GT(child, 0);
    ::kill(orchestrator, signal_number);
    EXPECT_EQ(test::end_of(orchestrator), 130);
    EXPECT_TRUE(test::gone(child));
    EXPECT_TRUE(test::gone(grandchild));
    std::filesystem::remove(scratch_.file("child"));
    std::filesystem::remove(scratch_.file("grandchild"));
  }
}

TEST_F(RunToEnd, AKilledOrchestratorTakesItsProgramAlong) {
  const Command slow = script("echo $$ > child\nexec sleep 1000\n");
  const pid_t orchestrator = test::start_elsewhere([&] {
    run_to_end("slow", slow, kLong);
    return 0;
  });
  const pid_t child = test::process_written_to(scratch_.file("child"));
  ASSERT_GT(child, 0);
  EXPECT_TRUE(test::alive(child));
  ::kill(orchestrator, SIGKILL);
  EXPECT_EQ(test::end_of(orchestrator), -SIGKILL);
  EXPECT_TRUE(test::gone(child));
}

class LastLines : public RunToEnd {
 protected:
  [[nodiscard]] std::string of(const std::string& text, int count) const {
    std::ofstream(log_, std::ios::binary) << text;
    return last_lines(log_, count);
  }
};

TEST_F(LastLines, AreTheLastOnes) {
  EXPECT_EQ(of("a\nb\nc\n", 2), "b\nc");
  EXPECT_EQ(of("a\nb\nc", 1), "c");
  EXPECT_EQ(of("a\nb\nc\n", 3), "a\nb\nc");
  EXPECT_EQ(of("a\nb\nc\n", 10), "a\nb\nc");
  EXPECT_EQ(of("a\n\nc\n\n\n", 2), "\nc");
  EXPECT_EQ(of("", 2), "");
  EXPECT_EQ(of("\n\n", 2), "");
  EXPECT_EQ(last_lines(scratch_.file("none")), "");
  EXPECT_EQ(last_lines(""), "");
}

TEST_F(LastLines, OfAHugeLineTheEnd) {
  const std::string end = of(std::string(1 << 20, 'x') + "END", 15);
  EXPECT_TRUE(end.ends_with("xEND"));
  EXPECT_LT(end.size(), 100'000U);
}

}  // namespace
}  // namespace sandglass
