#include "record/run_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "../support/errors.hpp"
#include "../support/processes.hpp"
#include "../support/scratch.hpp"

namespace sandglass::record {
namespace {

using test::error_of;
using testing::EndsWith;
using testing::HasSubstr;

class RunDirectoryTest : public testing::Test {
 protected:
  [[nodiscard]] RunDirectory next() const { return RunDirectory::create("", runs_, "sphere"); }
  [[nodiscard]] RunDirectory at(const std::string& path) const {
    return RunDirectory::create(path, runs_, "sphere");
  }
  static void put_something_in(const std::string& path) {
    std::filesystem::create_directories(path);
    std::ofstream(path + "/something") << "old";
  }
  static void expect_environment(const Error& error, const std::string& path,
                                 const std::string& what) {
    EXPECT_EQ(error.code(), ExitCode::environment);
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr(path), HasSubstr(what)));
  }

  test::Scratch scratch_;
  std::string runs_ = scratch_.file("deep/runs");
};

TEST_F(RunDirectoryTest, AreNumberedFromOne) {
  EXPECT_THAT(next().path(), EndsWith("/sphere-0001"));
  EXPECT_THAT(next().path(), EndsWith("/sphere-0002"));
  EXPECT_EQ(RunDirectory::create("", runs_, "other").path(), runs_ + "/other-0001");
}

TEST_F(RunDirectoryTest, TheNumberGoesOnFromTheHighest) {
  for (const char* name : {"sphere-0041", "sphere-9", "sphere-0050x", "sphere", "sphere--60",
                           "sphere-", "ball-0070", "sphere-99999999999999999999"}) {
    std::filesystem::create_directories(runs_ + "/" + name);
  }
  EXPECT_THAT(next().path(), EndsWith("/sphere-0042"));
  std::filesystem::create_directories(runs_ + "/sphere-12345");
  EXPECT_THAT(next().path(), EndsWith("/sphere-12346"));
}

TEST_F(RunDirectoryTest, TheHighestNumberOfAllIsNoTrap) {
  std::filesystem::create_directories(runs_ + "/sphere-2147483647");
  EXPECT_NO_THROW(static_cast<void>(next()));
}

TEST_F(RunDirectoryTest, AFileOfThatNameIsPassedOver) {
  std::filesystem::create_directories(runs_);
  std::ofstream(runs_ + "/sphere-0001") << "a file";
  EXPECT_THAT(next().path(), EndsWith("/sphere-0002"));
}

TEST_F(RunDirectoryTest, SeveralProcessesGetSeveralNumbers) {
  std::vector<pid_t> processes;
  processes.reserve(4);
  for (int i = 0; i < 4; ++i) {
    processes.push_back(test::start_elsewhere([&] {
      for (int k = 0; k < 25; ++k) {
        const RunDirectory mine = next();
        // Nobody else's: it holds what we put there, and nothing was there before.
        if (std::filesystem::exists(mine.file("mine"))) return 1;
        std::ofstream(mine.file("mine")) << i;
      }
      return 0;
    }));
  }
  for (const pid_t process : processes) EXPECT_EQ(test::end_of(process), 0);
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(runs_)) {
    names.insert(entry.path().filename().string());
  }
  EXPECT_EQ(names.size(), 100U);
  EXPECT_TRUE(names.contains("sphere-0100"));
}

TEST_F(RunDirectoryTest, AGivenPlaceIsTakenAsItIs) {
  const std::string path = scratch_.file("my runs/größer");
  const RunDirectory made = at(path + "/");
  EXPECT_EQ(made.path(), path);
  EXPECT_EQ(made.file("record.h5"), path + "/record.h5");
  EXPECT_EQ(made.folder("work/fluid"), path + "/work/fluid");
  EXPECT_TRUE(std::filesystem::is_directory(path + "/work/fluid"));
}

TEST_F(RunDirectoryTest, ThePathIsAbsolute) {
  const auto here = std::filesystem::current_path();
  std::filesystem::current_path(scratch_.path());
  const RunDirectory made = at("./x/../relative");
  std::filesystem::current_path(here);
  EXPECT_EQ(made.path(), std::filesystem::canonical(scratch_.path()).string() + "/relative");
}

TEST_F(RunDirectoryTest, AnEmptyFolderMayBeUsed) {
  std::filesystem::create_directories(scratch_.file("empty"));
  EXPECT_NO_THROW(static_cast<void>(at(scratch_.file("empty"))));
}

TEST_F(RunDirectoryTest, InUseByAnotherProcess) {
  const std::string path = scratch_.file("run");
  const pid_t other = test::start_elsewhere([&] {
    const RunDirectory theirs = at(path);
    std::ofstream(theirs.file("started")) << ::getpid() << '\n';
    ::pause();
    return 0;
  });
  ASSERT_GT(test::process_written_to(path + "/started"), 0);
  EXPECT_TRUE(in_use(path));
  const Error created = error_of([&] { static_cast<void>(at(path)); });
  expect_environment(created, path, "in use");
  EXPECT_FALSE(test::remedy_of(created).empty());
  expect_environment(error_of([&] { static_cast<void>(RunDirectory::open(path)); }), path,
                     "in use");
  ::kill(other, SIGKILL);
  EXPECT_EQ(test::end_of(other), -SIGKILL);
  EXPECT_FALSE(in_use(path)) << "a dead process holds nothing";
  expect_environment(error_of([&] { static_cast<void>(at(path)); }), path, "already used");
  EXPECT_NO_THROW(static_cast<void>(RunDirectory::open(path)));
}

TEST_F(RunDirectoryTest, AskingIsNotTaking) {
  const std::string path = scratch_.file("run");
  static_cast<void>(at(path));
  const pid_t asking = test::start_elsewhere([&] {
    std::ofstream(path + "/asking") << ::getpid() << '\n';
    for (;;) static_cast<void>(in_use(path));
    return 0;
  });
  ASSERT_GT(test::process_written_to(path + "/asking"), 0);
  for (int k = 0; k < 20'000; ++k) EXPECT_NO_THROW(static_cast<void>(RunDirectory::open(path)));
  ::kill(asking, SIGKILL);
  test::end_of(asking);
}

TEST_F(RunDirectoryTest, InUseByOurselves) {
  const RunDirectory mine = next();
  EXPECT_TRUE(in_use(mine.path()));
  expect_environment(error_of([&] { static_cast<void>(RunDirectory::open(mine.path())); }),
                     mine.path(), "in use");
}

TEST_F(RunDirectoryTest, AreFreeAfterwards) {
  std::string path;
  {
    RunDirectory first = next();
    const RunDirectory moved = std::move(first);
    path = moved.path();
    EXPECT_TRUE(in_use(path));
  }
  EXPECT_FALSE(in_use(path));
}

TEST_F(RunDirectoryTest, ChildrenDoNotInheritTheLock) {
  const std::string path = scratch_.file("run");
  const pid_t owner = test::start_elsewhere([&] {
    const RunDirectory mine = at(path);
    const pid_t child = ::fork();
    if (child == 0) {
      // A solver that lives on, as execve would leave it: only close-on-exec matters.
      ::execlp("sleep", "sleep", "60", nullptr);
      ::_exit(127);
    }
    std::ofstream(mine.file("child")) << child << '\n';
    ::pause();
    return 0;
  });
  const pid_t child = test::process_written_to(path + "/child");
  ASSERT_GT(child, 0);
  ::kill(owner, SIGKILL);
  test::end_of(owner);
  EXPECT_TRUE(test::comes_true([&] { return !in_use(path); }));
  EXPECT_TRUE(test::alive(child));
  ::kill(child, SIGKILL);
}

TEST_F(RunDirectoryTest, AlreadyUsedIsRefusedAndNotTouched) {
  const std::string path = scratch_.file("thesis");
  put_something_in(path);
  const Error error = error_of([&] { static_cast<void>(at(path)); });
  expect_environment(error, path, "not empty");
  EXPECT_THAT(test::remedy_of(error), HasSubstr("--out"));
  EXPECT_FALSE(std::filesystem::exists(path + "/lock")) << "somebody's own folder is left alone";
  EXPECT_FALSE(in_use(path));
}

TEST_F(RunDirectoryTest, AFileIsNoFolder) {
  std::ofstream(scratch_.file("file")) << "text";
  for (const std::string& path : {scratch_.file("file"), scratch_.file("file/below")}) {
    expect_environment(error_of([&] { static_cast<void>(at(path)); }), path, "Not a directory");
  }
}

TEST_F(RunDirectoryTest, OpeningNeedsOneThatIsThere) {
  expect_environment(
      error_of([&] { static_cast<void>(RunDirectory::open(scratch_.file("none"))); }),
      scratch_.file("none"), "no run directory");
  EXPECT_FALSE(in_use(scratch_.file("none")));
}

/// What an ordinary user meets in folders that are not theirs.
class NotPermitted : public RunDirectoryTest {
 protected:
  /// 0 when `act` says permission was denied, for this path, and what to do.
  template <typename Act>
  int denied(const std::string& path, Act act) {
    return test::run_elsewhere([&] {
      test::become_ordinary_user();
      try {
        act();
      } catch (const Error& error) {
        const std::string text = error.what();
        if (error.code() != ExitCode::environment) return 2;
        if (text.find(path) == std::string::npos) return 3;
        if (text.find("Permission denied") == std::string::npos) return 4;
        return test::remedy_of(error).empty() ? 5 : 0;
      }
      return 1;
    });
  }
  void SetUp() override {
    ::chmod(scratch_.path().c_str(), 0755);
    std::filesystem::create_directories(runs_);
  }
};

TEST_F(NotPermitted, ToMakeIt) {
  ::chmod(runs_.c_str(), 0555);
  EXPECT_EQ(denied(runs_ + "/sphere-0001", [&] { static_cast<void>(next()); }), 0);
  EXPECT_EQ(denied(runs_ + "/mine", [&] { static_cast<void>(at(runs_ + "/mine")); }), 0);
}

TEST_F(NotPermitted, ToWriteInIt) {
  const std::string path = scratch_.file("read only");
  std::filesystem::create_directories(path);
  ::chmod(path.c_str(), 0555);
  EXPECT_EQ(denied(path, [&] { static_cast<void>(at(path)); }), 0);
  EXPECT_EQ(denied(path, [&] { static_cast<void>(RunDirectory::open(path)); }), 0);
}

TEST_F(NotPermitted, ToLookIntoIt) {
  const std::string path = scratch_.file("closed");
  std::filesystem::create_directories(path);
  ::chmod(path.c_str(), 0300);
  ::chmod(runs_.c_str(), 0300);
  EXPECT_EQ(denied(path, [&] { static_cast<void>(at(path)); }), 0);
  EXPECT_EQ(denied(runs_, [&] { static_cast<void>(next()); }), 0);
  ::chmod(path.c_str(), 0755);
  ::chmod(runs_.c_str(), 0755);
}

}  // namespace
}  // namespace sandglass::record
