#include "hdf5/hdf5.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>

#include "../support/errors.hpp"
#include "../support/processes.hpp"
#include "../support/scratch.hpp"

namespace sandglass::hdf5 {
namespace {

using test::error_of;
using testing::ElementsAre;
using testing::HasSubstr;
using Numbers = std::vector<double>;
using Counts = std::vector<std::int64_t>;

class Hdf5 : public testing::Test {
 protected:
  /// What another program would do that knows only where the bytes are.
  static void put(const std::string& path, std::uint64_t offset, const void* bytes, size_t count) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    ASSERT_GE(file, 0);
    EXPECT_EQ(::pwrite(file, bytes, count, static_cast<off_t>(offset)),
              static_cast<ssize_t>(count));
    ::close(file);
  }

  test::Scratch scratch_;
  std::string path_ = scratch_.file("a file.h5");
};

TEST_F(Hdf5, WhatIsWrittenIsReadBack) {
  const Numbers numbers{0.1, -2e300, 5e-324, -0.0, std::numeric_limits<double>::infinity(), 7};
  const Counts counts{std::numeric_limits<std::int64_t>::min(), 9'007'199'254'740'993};
  {
    File file(path_, File::Mode::create);
    file.write("/a/b/numbers", {3, 2}, numbers);
    file.write("/a/counts", {2}, counts);
    file.write("/none", {0, 3}, Numbers{});
    file.close();
  }
  const File file(path_, File::Mode::read);
  EXPECT_EQ(file.read_numbers("/a/b/numbers"), numbers);
  EXPECT_EQ(file.read_counts("/a/counts"), counts);
  EXPECT_THAT(file.shape("/a/b/numbers"), ElementsAre(3, 2));
  EXPECT_THAT(file.shape("/none"), ElementsAre(0, 3));
  EXPECT_TRUE(file.read_numbers("/none").empty());
  EXPECT_THAT(file.list("/"), ElementsAre("a", "none"));
  EXPECT_THAT(file.list("/a"), ElementsAre("b", "counts"));
}

TEST_F(Hdf5, ANotANumberSurvives) {
  File(path_, File::Mode::create)
      .write("/x", {1}, Numbers{std::numeric_limits<double>::quiet_NaN()});
  EXPECT_TRUE(std::isnan(File(path_, File::Mode::read).read_numbers("/x").at(0)));
}

TEST_F(Hdf5, KnowsWhatExists) {
  File file(path_, File::Mode::create);
  file.write("/a/b/x", {1}, Numbers{1});
  EXPECT_TRUE(file.exists("/a"));
  EXPECT_TRUE(file.exists("/a/b/x"));
  EXPECT_FALSE(file.exists("/a/c"));
  EXPECT_FALSE(file.exists("/no/such/way"));
}

TEST_F(Hdf5, AttributesAreReplacedAndReadBack) {
  {
    File file(path_, File::Mode::create);
    file.write("/x", {1}, Numbers{1});
    file.set_attribute("/", "title", "first, and much longer than the second");
    file.set_attribute("/", "title", "Größe in µm");
    file.set_attribute("/x", "unit", "");
    file.set_attribute("/", "version", Counts{1, 0});
    file.set_attribute("/", "seed", Counts{-3});
  }
  const File file(path_, File::Mode::read);
  EXPECT_EQ(file.text_attribute("/", "title"), "Größe in µm");
  EXPECT_EQ(file.text_attribute("/x", "unit"), "");
  EXPECT_THAT(file.count_attribute("/", "version"), ElementsAre(1, 0));
  EXPECT_THAT(file.count_attribute("/", "seed"), ElementsAre(-3));
}

TEST_F(Hdf5, AReservedDatasetIsWhereItSaysItIs) {
  Location numbers_at;
  Location counts_at;
  {
    File file(path_, File::Mode::create);
    numbers_at = file.reserve("/in/drag/values", Type::float64, {2, 3});
    counts_at = file.reserve("/in/drag/shape", Type::int64, {2});
    for (int i = 0; i < 50; ++i) file.reserve("/more/" + std::to_string(i), Type::float64, {7});
    file.close();
  }
  EXPECT_EQ(numbers_at.bytes, 48U);
  EXPECT_EQ(counts_at.bytes, 16U);
  EXPECT_EQ(numbers_at.offset % alignof(double), 0U);
  EXPECT_EQ(counts_at.offset % alignof(std::int64_t), 0U);
  {
    const File file(path_, File::Mode::read);
    EXPECT_EQ(file.read_numbers("/in/drag/values"), Numbers(6, 0.0)) << "not written: zeros";
  }
  const Numbers numbers{1, 2, 3, 4, 5, 6.5};
  const Counts counts{2, 3};
  put(path_, numbers_at.offset, numbers.data(), numbers_at.bytes);
  put(path_, counts_at.offset, counts.data(), counts_at.bytes);
  const File file(path_, File::Mode::read);
  EXPECT_EQ(file.read_numbers("/in/drag/values"), numbers);
  EXPECT_EQ(file.read_counts("/in/drag/shape"), counts);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(file.read_numbers("/more/" + std::to_string(i)), Numbers(7, 0.0)) << i;
  }
}

TEST_F(Hdf5, AChangedFileIsReadThroughAnOpenOneOfAnotherProcess) {
  Location at;
  {
    File file(path_, File::Mode::create);
    at = file.reserve("/x", Type::float64, {1});
  }
  const File open_all_the_time(path_, File::Mode::read);
  const double value = 2.5;
  put(path_, at.offset, &value, sizeof value);
  EXPECT_THAT(File(path_, File::Mode::read).read_numbers("/x"), ElementsAre(2.5));
}

TEST_F(Hdf5, AReservedDatasetWithoutValuesHasNoBytes) {
  File file(path_, File::Mode::create);
  EXPECT_EQ(file.reserve("/nothing", Type::float64, {0, 3}).bytes, 0U);
}

TEST_F(Hdf5, ReservingTakesNoSpaceOnTheDisk) {
  constexpr std::int64_t count = 1'000'000'000;
  {
    File file(path_, File::Mode::create);
    file.reserve("/huge", Type::float64, {count, 2});
    file.close();
  }
  struct stat status {};
  ASSERT_EQ(::stat(path_.c_str(), &status), 0);
  EXPECT_GE(status.st_size, count * 16);
  EXPECT_LT(status.st_blocks * 512, 1 << 20);
  EXPECT_THAT(File(path_, File::Mode::read).read_numbers("/huge", 1), ElementsAre(0, 0));
}

TEST_F(Hdf5, TheFirstRowsAreReadAlone) {
  Numbers numbers(12);
  std::iota(numbers.begin(), numbers.end(), 1.0);
  File file(path_, File::Mode::create);
  file.write("/x", {4, 3}, numbers);
  file.write("/n", {4}, Counts{1, 2, 3, 4});
  EXPECT_THAT(file.read_numbers("/x", 2), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(file.read_counts("/n", 3), ElementsAre(1, 2, 3));
  EXPECT_TRUE(file.read_numbers("/x", 0).empty());
  EXPECT_EQ(file.read_numbers("/x", 4), numbers);
  EXPECT_EQ(file.read_numbers("/x", 99), numbers);
}

TEST_F(Hdf5, CreatingReplaces) {
  File(path_, File::Mode::create).write("/old", {1}, Numbers{1});
  File(path_, File::Mode::create).write("/new", {1}, Numbers{1});
  EXPECT_THAT(File(path_, File::Mode::read).list("/"), ElementsAre("new"));
}

TEST_F(Hdf5, ChangingKeepsWhatIsThere) {
  File(path_, File::Mode::create).write("/old", {1}, Numbers{1});
  File(path_, File::Mode::change).write("/new", {1}, Numbers{2});
  EXPECT_THAT(File(path_, File::Mode::read).list("/"), ElementsAre("new", "old"));
}

TEST_F(Hdf5, ClosingTwiceIsClosingOnce) {
  File file(path_, File::Mode::create);
  file.close();
  EXPECT_NO_THROW(file.close());
}

// ---- what goes wrong

TEST_F(Hdf5, AMissingFileIsNamedWithTheReason) {
  testing::internal::CaptureStderr();
  const Error error = error_of([&] { const File file(path_, File::Mode::read); });
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "nothing below the verbs prints";
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), HasSubstr(path_));
  EXPECT_THAT(error.what(), HasSubstr("No such file or directory"));
}

TEST_F(Hdf5, AnotherKindOfFileIsRefused) {
  std::ofstream(path_) << "time,velocity\n0,1\n";
  const Error error = error_of([&] { const File file(path_, File::Mode::read); });
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), HasSubstr(path_));
  EXPECT_THAT(error.what(), HasSubstr("signature"));
}

TEST_F(Hdf5, ACutFileIsRefused) {
  {
    File file(path_, File::Mode::create);
    file.write("/x", {1000}, Numbers(1000, 1.0));
  }
  std::filesystem::resize_file(path_, 1500);
  const Error error = error_of([&] { const File file(path_, File::Mode::read); });
  EXPECT_EQ(error.code(), ExitCode::environment);
  EXPECT_THAT(error.what(), HasSubstr("truncated"));
}

TEST_F(Hdf5, AMissingDatasetIsNamed) {
  File file(path_, File::Mode::create);
  for (const Error& error : {error_of([&] { static_cast<void>(file.read_numbers("/in/drag")); }),
                             error_of([&] { static_cast<void>(file.shape("/in/drag")); })}) {
    EXPECT_EQ(error.code(), ExitCode::environment);
    EXPECT_THAT(error.what(), HasSubstr("/in/drag"));
    EXPECT_THAT(error.what(), HasSubstr(path_));
    EXPECT_THAT(error.what(), HasSubstr("can't find object"));
  }
  EXPECT_THROW(static_cast<void>(file.list("/nowhere")), Error);
  EXPECT_THROW(file.set_attribute("/nowhere", "unit", "m"), Error);
  EXPECT_THROW(static_cast<void>(file.text_attribute("/", "unit")), Error);
}

TEST_F(Hdf5, AnErrorSpeaksOfItselfOnly) {
  File file(path_, File::Mode::create);
  error_of([&] { static_cast<void>(file.read_numbers("/first")); });
  const Error second = error_of([&] { static_cast<void>(file.read_numbers("/second")); });
  EXPECT_THAT(second.what(), testing::Not(HasSubstr("first")));
}

TEST_F(Hdf5, AnExistingDatasetIsNotOverwritten) {
  File file(path_, File::Mode::create);
  file.write("/x", {1}, Numbers{1});
  EXPECT_THAT(error_of([&] { file.write("/x", {1}, Numbers{2}); }).what(), HasSubstr("exists"));
}

TEST_F(Hdf5, AsManyValuesAsTheShapeSays) {
  File file(path_, File::Mode::create);
  const Error error = error_of([&] { file.write("/x", {2, 2}, Numbers{1, 2, 3}); });
  EXPECT_THAT(error.what(), HasSubstr("3 values"));
  EXPECT_FALSE(file.exists("/x"));
}

TEST_F(Hdf5, AFolderThatCannotBeWrittenIsNamed) {
  ASSERT_EQ(::chmod(scratch_.path().c_str(), 0555), 0);
  EXPECT_EQ(test::run_elsewhere([&] {
              test::become_ordinary_user();
              try {
                const File file(path_, File::Mode::create);
              } catch (const Error& error) {
                const std::string text = error.what();
                const bool told = text.find(path_) != std::string::npos &&
                                  text.find("Permission denied") != std::string::npos &&
                                  !test::remedy_of(error).empty();
                return told && error.code() == ExitCode::environment ? 0 : 1;
              }
              return 2;
            }),
            0);
  ::chmod(scratch_.path().c_str(), 0755);
}

TEST_F(Hdf5, AFullDiskIsAnErrorWithARemedy) {
  EXPECT_EQ(test::run_elsewhere([&] {
              test::limit_file_size(100'000);
              File file(path_, File::Mode::create);
              try {
                file.write("/x", {100'000}, Numbers(100'000, 1.0));
                file.close();
              } catch (const Error& error) {
                const bool told = !test::remedy_of(error).empty();
                return told && error.code() == ExitCode::environment ? 0 : 1;
              }
              return 2;
            }),
            0);
}

TEST(Hdf5Library, HasAVersion) {
  EXPECT_THAT(library_version(), testing::MatchesRegex("1\\.[0-9]+\\.[0-9]+"));
}

}  // namespace
}  // namespace sandglass::hdf5
