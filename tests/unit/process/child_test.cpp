#include "process/child.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "../support/errors.hpp"
#include "../support/processes.hpp"
#include "../support/scratch.hpp"
#include "base/file.hpp"
#include "process/interrupt.hpp"

namespace sandglass {
namespace {

constexpr double kLong = 60;  // s

/// Programs that talk, written in the language of the shell.
class Conversation : public testing::Test {
 protected:
  static void SetUpTestSuite() { Interrupt::install(); }

  [[nodiscard]] Command script(const std::string& name, const std::string& text) const {
    std::ofstream(scratch_.file(name)) << "#!/bin/sh\n" << text;
    ::chmod(scratch_.file(name).c_str(), 0755);
    return {{scratch_.file(name)}, scratch_.path(), {}, scratch_.file(name + ".log")};
  }
  /// Everything that it says until `line` is in it.
  static std::string hear(Child& child, const std::string& line) {
    std::string text;
    Watch watch;
    while (text.find(line) == std::string::npos) {
      if (watch.wait(child.reply_descriptor(), kLong).event != Watch::Event::ready) break;
      if (!child.read_replies(text)) break;
    }
    return text;
  }

  test::Scratch scratch_;
};

TEST_F(Conversation, CommandsAndRepliesCross) {
  Child child("echo",
              script("echo",
                     "eval \"exec <&$SANDGLASS_COMMANDS >&$SANDGLASS_REPLIES\"\n"
                     "while read -r line; do echo \"heard $line\"; done\nexit 5\n"),
              true);
  EXPECT_TRUE(child.write_command("advance 1\n"));
  EXPECT_EQ(hear(child, "\n"), "heard advance 1\n");
  child.close_commands();
  Watch watch;
  watch.add(&child);
  EXPECT_EQ(watch.wait(-1, kLong).event, Watch::Event::exited);
  const auto ended = child.poll_exit();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->text(), "exit status 5");
  std::string rest;
  EXPECT_FALSE(child.read_replies(rest)) << "the end of the replies";
}

TEST_F(Conversation, ItGetsTheTwoPipesAndNothingElse) {
  const int before = test::open_descriptors();
  {
    Child first("first", script("first", "sleep 1000\n"), true);
    Child child("ls", script("ls", "ls /proc/$$/fd; echo done\n"), true);
    Watch watch;
    watch.add(&child);
    EXPECT_EQ(watch.wait(-1, kLong).event, Watch::Event::exited);
  }
  EXPECT_THAT(read_file(scratch_.file("ls.log")),
              testing::AnyOf("0\n1\n10\n2\n3\n4\ndone\n", "0\n1\n2\n3\n4\ndone\n"));
  EXPECT_EQ(test::open_descriptors(), before) << "and we keep none";
}

TEST_F(Conversation, TheDestructorLeavesNoProcess) {
  pid_t child_process = 0;
  pid_t grandchild = 0;
  {
    // Deaf to everything that can be ignored.
    Child child("deaf",
                script("deaf",
                       "trap '' TERM INT HUP\n(trap '' TERM INT HUP; sleep 1000) &\n"
                       "echo $! > grandchild\nwait\nsleep 1000\n"),
                true);
    grandchild = test::process_written_to(scratch_.file("grandchild"));
    child_process = child.process_id();
    EXPECT_TRUE(test::alive(child_process));
    EXPECT_TRUE(test::alive(grandchild));
  }
  EXPECT_FALSE(test::alive(child_process)) << "reaped, not only asked to go";
  EXPECT_TRUE(test::gone(grandchild));
}

TEST_F(Conversation, WritingToOneThatHasGoneIsSeen) {
  Child child("brief", script("brief", "exit 0\n"), true);
  Watch watch;
  watch.add(&child);
  watch.wait(-1, kLong);
  EXPECT_FALSE(child.write_command("advance\n"));
}

TEST_F(Conversation, AFloodIsTakenInPortions) {
  Child child("flood", script("flood", "exec yes note flood >&$SANDGLASS_REPLIES\n"), true);
  hear(child, "\n");
  for (int i = 0; i < 10; ++i) {
    std::string text;
    EXPECT_TRUE(child.read_replies(text));
    EXPECT_LE(text.size(), size_t{1} << 20);
  }
}

TEST_F(Conversation, AReplyBeforeTheExitCountsAsReady) {
  Child child("last word", script("last", "echo ok >&$SANDGLASS_REPLIES\n"), true);
  ASSERT_TRUE(test::comes_true([&] { return !test::alive(child.process_id()); }));
  Watch watch;
  watch.add(&child);
  EXPECT_EQ(watch.wait(child.reply_descriptor(), kLong).event, Watch::Event::ready);
  std::string text;
  child.read_replies(text);
  EXPECT_EQ(text, "ok\n");
}

TEST_F(Conversation, TheOneThatDiesIsNamedWhileAnotherIsAwaited) {
  Child awaited("awaited", script("awaited", "sleep 1000\n"), true);
  Child dying("dying", script("dying", "exit 9\n"), true);
  Watch watch;
  watch.add(&awaited);
  watch.add(&dying);
  const Watch::Outcome outcome = watch.wait(awaited.reply_descriptor(), kLong);
  EXPECT_EQ(outcome.event, Watch::Event::exited);
  ASSERT_EQ(outcome.child, &dying);
  EXPECT_EQ(dying.poll_exit()->number, 9);
  watch.remove(&dying);
  EXPECT_EQ(watch.wait(awaited.reply_descriptor(), 0.05).event, Watch::Event::late);
}

TEST_F(Conversation, NothingToWaitForIsLate) {
  Watch watch;
  EXPECT_EQ(watch.wait(-1, 0.0).event, Watch::Event::late);
  EXPECT_EQ(watch.wait(-1, 0.01).event, Watch::Event::late);
}

TEST_F(Conversation, KillingReports) {
  Child child("slow", script("slow", "sleep 1000\n"), true);
  EXPECT_FALSE(child.poll_exit());
  EXPECT_EQ(child.kill().text(), "killed by signal 9 (SIGKILL)");
  EXPECT_EQ(child.poll_exit()->number, SIGKILL) << "asked again, the same";
}

}  // namespace
}  // namespace sandglass
