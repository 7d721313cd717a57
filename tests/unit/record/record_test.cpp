#include "record/record.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "../support/errors.hpp"
#include "../support/processes.hpp"
#include "../support/scratch.hpp"
#include "hdf5/hdf5.hpp"

namespace sandglass::record {
namespace {

using hdf5::File;
using test::error_of;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using Numbers = std::vector<double>;

/// A record of two fields, one of them with a changing number of rows; every number in it follows
/// from its window.
class RecordTest : public testing::Test {
 protected:
  [[nodiscard]] Record record(std::int64_t windows) const {
    return {path_,
            windows,
            {{"velocity", "m/s", "grains", "fluid", {2}, false},
             {"positions", "m", "grains", "", {3, 2}, true}},
            {"grains", "exchange"}};
  }
  static std::int64_t rows(std::int64_t window) { return window % 4; }
  static void append(Record& record, std::int64_t window) {
    const auto number = static_cast<double>(window);
    const Numbers velocity{number, -number};
    const Numbers positions(2 * static_cast<size_t>(rows(window)), 100 * number);
    record.append({0.5 * (number - 1),
                   0.5 * number,
                   window + 1,
                   {{velocity, 2}, {positions, rows(window)}},
                   {number * 1e-3, number * 1e-6}});
  }
  /// Reads the file as anybody would, through HDF5: `windows` whole windows are in it.
  static void expect_windows(const std::string& path, std::int64_t windows) {
    const File file(path, File::Mode::read);
    ASSERT_THAT(file.read_counts("/windows"), ElementsAre(windows));
    const auto time = file.read_numbers("/time", windows);
    const auto iterations = file.read_counts("/iterations", windows);
    const auto velocity = file.read_numbers("/fields/velocity", windows);
    const auto positions = file.read_numbers("/fields/positions", windows);
    const auto counts = file.read_counts("/counts/positions", windows);
    const auto grains = file.read_numbers("/timings/grains", windows);
    const auto exchange = file.read_numbers("/timings/exchange", windows);
    ASSERT_EQ(time.size(), 2 * static_cast<size_t>(windows));
    ASSERT_EQ(positions.size(), 6 * static_cast<size_t>(windows));
    for (std::int64_t window = 1; window <= windows; ++window) {
      const auto k = static_cast<size_t>(window - 1);
      const auto number = static_cast<double>(window);
      ASSERT_EQ(time[2 * k], 0.5 * (number - 1));
      ASSERT_EQ(time[2 * k + 1], 0.5 * number);
      ASSERT_EQ(iterations[k], window + 1);
      ASSERT_EQ(velocity[2 * k], number);
      ASSERT_EQ(velocity[2 * k + 1], -number);
      ASSERT_EQ(counts[k], rows(window));
      for (size_t i = 0; i < 2 * static_cast<size_t>(rows(window)); ++i) {
        ASSERT_EQ(positions[6 * k + i], 100 * number);
      }
      ASSERT_EQ(grains[k], number * 1e-3);
      ASSERT_EQ(exchange[k], number * 1e-6);
    }
  }
  [[nodiscard]] std::int64_t bytes_on_disk() const {
    struct stat status {};
    EXPECT_EQ(::stat(path_.c_str(), &status), 0);
    return status.st_blocks * 512;
  }

  test::Scratch scratch_;
  std::string path_ = scratch_.file("record.h5");
};

TEST_F(RecordTest, IsLaidOutAsDocumented) {
  Record made = record(7);
  const File file(path_, File::Mode::read);
  EXPECT_EQ(file.text_attribute("/", "filetype"), "sandglass record");
  EXPECT_THAT(file.count_attribute("/", "version"), ElementsAre(1, 0));
  EXPECT_THAT(file.list("/"),
              ElementsAre("counts", "fields", "iterations", "time", "timings", "windows"));
  EXPECT_THAT(file.shape("/windows"), ElementsAre(1));
  EXPECT_THAT(file.shape("/time"), ElementsAre(7, 2));
  EXPECT_THAT(file.shape("/iterations"), ElementsAre(7));
  EXPECT_THAT(file.shape("/fields/velocity"), ElementsAre(7, 2));
  EXPECT_THAT(file.shape("/fields/positions"), ElementsAre(7, 3, 2));
  EXPECT_THAT(file.shape("/timings/exchange"), ElementsAre(7));
  EXPECT_THAT(file.list("/counts"), ElementsAre("positions"));
  EXPECT_EQ(file.text_attribute("/fields/velocity", "unit"), "m/s");
  EXPECT_EQ(file.text_attribute("/fields/velocity", "from"), "grains");
  EXPECT_EQ(file.text_attribute("/fields/velocity", "to"), "fluid");
  EXPECT_EQ(file.text_attribute("/fields/positions", "to"), "");
  EXPECT_THAT(file.read_counts("/windows"), ElementsAre(0));
}

TEST_F(RecordTest, IsReadableAtEveryMoment) {
  Record made = record(20);
  for (std::int64_t window = 1; window <= 20; ++window) {
    append(made, window);
    made.flush();
    EXPECT_EQ(made.windows(), window);
    expect_windows(path_, window);
  }
  made.close();
  expect_windows(path_, 20);
  EXPECT_THAT(File(path_, File::Mode::read).shape("/time"), ElementsAre(20, 2));
}

TEST_F(RecordTest, ARunThatEndedEarlyIsCutToWhatWasDone) {
  Record made = record(1'000'000);
  for (std::int64_t window = 1; window <= 9; ++window) append(made, window);
  made.close();
  expect_windows(path_, 9);
  const File file(path_, File::Mode::read);
  EXPECT_THAT(file.shape("/time"), ElementsAre(9, 2));
  EXPECT_THAT(file.shape("/iterations"), ElementsAre(9));
  EXPECT_THAT(file.shape("/fields/positions"), ElementsAre(9, 3, 2));
  EXPECT_THAT(file.shape("/counts/positions"), ElementsAre(9));
  EXPECT_THAT(file.shape("/timings/grains"), ElementsAre(9));
  EXPECT_EQ(file.text_attribute("/fields/velocity", "unit"), "m/s");
  EXPECT_EQ(file.text_attribute("/", "filetype"), "sandglass record");
  EXPECT_LT(std::filesystem::file_size(path_), 1U << 16);
  EXPECT_FALSE(std::filesystem::exists(path_ + ".part"));
}

TEST_F(RecordTest, WithoutAWindowItIsEmptyButWhole) {
  Record made = record(5);
  made.close();
  expect_windows(path_, 0);
  EXPECT_THAT(File(path_, File::Mode::read).shape("/fields/velocity"), ElementsAre(0, 2));
}

TEST_F(RecordTest, ClosingTwiceIsClosingOnce) {
  Record made = record(2);
  append(made, 1);
  made.close();
  EXPECT_NO_THROW(made.close());
  expect_windows(path_, 1);
}

TEST_F(RecordTest, AHugePlanCostsNothing) {
  {
    Record made = record(1'000'000'000);
    EXPECT_LT(bytes_on_disk(), 1 << 20);
    for (std::int64_t window = 1; window <= 3; ++window) append(made, window);
    made.flush();
    EXPECT_LT(bytes_on_disk(), 1 << 20);
    expect_windows(path_, 3);
    made.close();
  }
  expect_windows(path_, 3);
}

TEST_F(RecordTest, AKilledProcessLeavesWholeWindows) {
  constexpr std::int64_t done = 13;
  EXPECT_EQ(test::run_elsewhere([&] {
              Record made = record(1000);
              for (std::int64_t window = 1; window <= done; ++window) append(made, window);
              made.flush();
              ::kill(::getpid(), SIGKILL);
              return 0;
            }),
            -SIGKILL);
  expect_windows(path_, done);
}

TEST_F(RecordTest, KilledAtAnyMomentItHoldsOnlyWholeWindows) {
  for (std::int64_t delay = 1; delay <= 5; ++delay) {
    std::filesystem::remove(path_);
    const pid_t writer = test::start_elsewhere([&] {
      Record made = record(100'000'000);
      for (std::int64_t window = 1;; ++window) append(made, window);
      return 0;
    });
    ASSERT_TRUE(test::comes_true([&] {
      try {
        return File(path_, File::Mode::read).read_counts("/windows").at(0) > 100 * delay;
      } catch (const Error&) {
        return false;  // not there yet
      }
    }));
    ::kill(writer, SIGKILL);
    EXPECT_EQ(test::end_of(writer), -SIGKILL);
    const std::int64_t windows = File(path_, File::Mode::read).read_counts("/windows").at(0);
    EXPECT_GT(windows, 100 * delay);
    expect_windows(path_, windows);
  }
}

TEST_F(RecordTest, WhatIsAppendedIsWrittenUnasked) {
  Record made = record(20);
  for (std::int64_t window = 1; window <= 20; ++window) {
    append(made, window);
    if (window % 3 == 0) {
      EXPECT_TRUE(test::comes_true([&] { return made.windows() == window; }));
      expect_windows(path_, window);
    }
  }
}

TEST_F(RecordTest, ManyWindowsAtOnceAreAllWritten) {
  constexpr std::int64_t windows = 100'000;
  Record made = record(windows);
  for (std::int64_t window = 1; window <= windows; ++window) append(made, window);
  made.close();
  EXPECT_EQ(made.windows(), windows);
  expect_windows(path_, windows);
}

TEST_F(RecordTest, LargeWindowsFasterThanTheDiskAreHeldBackAndAllWritten) {
  constexpr std::int64_t windows = 60;
  constexpr std::int64_t size = 1'000'000;  // 8 MB: far more than waits in memory
  Record made(path_, windows, {{"large", "m", "grains", "", {size}, false}}, {});
  for (std::int64_t window = 1; window <= windows; ++window) {
    const Numbers values(size, static_cast<double>(window));
    made.append({0, 1, 1, {{values, size}}, {}});
  }
  made.close();
  const Numbers all = File(path_, File::Mode::read).read_numbers("/fields/large");
  ASSERT_EQ(all.size(), static_cast<size_t>(windows * size));
  for (size_t k = 0; k < all.size(); k += 999) {
    ASSERT_EQ(all[k], static_cast<double>(k / size + 1)) << k;
  }
}

TEST_F(RecordTest, AFailureThatNoAppendMetIsToldByClosing) {
  EXPECT_EQ(test::run_elsewhere([&] {
              Record made(path_, 1000, {{"large", "m", "grains", "", {1000}, false}}, {});
              const Numbers values(1000, 1.0);
              made.append({0, 1, 1, {{values, 1000}}, {}});
              made.flush();
              test::limit_file_size(100);
              made.append({0, 1, 1, {{values, 1000}}, {}});
              try {
                made.close();
              } catch (const Error& error) {
                return error.code() == ExitCode::environment ? static_cast<int>(made.windows()) : 2;
              }
              return 0;
            }),
            1);
}

TEST_F(RecordTest, AFullDiskLosesNothingThatWasRecorded) {
  const int whole = test::run_elsewhere([&] {
    Record made(path_, 1000, {{"large", "m", "grains", "", {1000}, false}}, {});
    const Numbers values(1000, 1.0);
    // Room for somewhat more than a hundred windows of 8 kB.
    test::limit_file_size(1'000'000);
    try {
      for (;;) made.append({0, 1, 1, {{values, 1000}}, {}});
    } catch (const Error& error) {
      if (error.code() != ExitCode::environment) return 1;
      if (test::remedy_of(error).empty()) return 2;
      if (std::string(error.what()).find(path_) == std::string::npos) return 3;
    }
    made.close();
    return static_cast<int>(made.windows());
  });
  EXPECT_GT(whole, 100) << "the failing window, or a number of what the error lacks";
  const File file(path_, File::Mode::read);
  EXPECT_THAT(file.read_counts("/windows"), ElementsAre(whole));
  EXPECT_THAT(file.read_numbers("/fields/large", whole), Each(1.0));
  EXPECT_FALSE(std::filesystem::exists(path_ + ".part"));
}

TEST_F(RecordTest, WhereItCannotBeCutItStaysAsItIs) {
  EXPECT_EQ(test::run_elsewhere([&] {
              Record made = record(1000);
              for (std::int64_t window = 1; window <= 9; ++window) append(made, window);
              made.flush();
              test::limit_file_size(16);
              made.close();
              return 0;
            }),
            0);
  expect_windows(path_, 9);
  EXPECT_FALSE(std::filesystem::exists(path_ + ".part"));
}

TEST_F(RecordTest, APlaceThatCannotBeWrittenIsNamed) {
  const Error error =
      error_of([&] { const Record made(scratch_.file("nowhere/record.h5"), 1, {}, {}); });
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), HasSubstr("nowhere/record.h5"));
}

}  // namespace
}  // namespace sandglass::record
