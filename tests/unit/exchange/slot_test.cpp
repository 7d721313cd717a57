#include "exchange/slot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "../support/errors.hpp"
#include "../support/processes.hpp"
#include "../support/scratch.hpp"
#include "hdf5/hdf5.hpp"

namespace sandglass::exchange {
namespace {

using hdf5::File;
using test::error_of;
using testing::Each;
using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::HasSubstr;
using Numbers = std::vector<double>;
using Counts = std::vector<std::int64_t>;

class SlotTest : public testing::Test {
 protected:
  static const std::vector<FieldLayout>& inputs() {
    static const std::vector<FieldLayout> fields{{"drag", "N", {3}}, {"positions", "m", {4, 2}}};
    return fields;
  }
  static const std::vector<FieldLayout>& outputs() {
    static const std::vector<FieldLayout> fields{{"velocity", "m/s", {2}}, {"forces", "N", {3, 2}}};
    return fields;
  }
  [[nodiscard]] Slot slot(bool mapped = true) const {
    return {path_, "fluid", inputs(), outputs(), mapped};
  }
  /// The file that a participant answers with where no memory is shared.
  [[nodiscard]] std::string answer(const std::string& field, const Shape& shape,
                                   const Numbers& values) const {
    std::string path = scratch_.file("answer.h5");
    File file(path, File::Mode::create);
    file.write("/out/" + field + "/values", shape, values);
    file.write("/seconds", {1}, Numbers{0.25});
    return path;
  }
  static std::vector<double> copy(const Slot::Taken& taken) {
    return {taken.values.begin(), taken.values.end()};
  }

  test::Scratch scratch_;
  std::string path_ = scratch_.file("fluid.h5");
};

TEST_F(SlotTest, IsAnHdf5FileAsDocumented) {
  const Slot made = slot();
  const File file(path_, File::Mode::read);
  EXPECT_EQ(file.text_attribute("/", "filetype"), "sandglass slot");
  EXPECT_THAT(file.count_attribute("/", "version"), ElementsAre(1, 0));
  EXPECT_EQ(file.text_attribute("/", "participant"), "fluid");
  EXPECT_EQ(file.text_attribute("/", "transport"), "mapped");
  EXPECT_THAT(file.list("/"), ElementsAre("in", "out", "seconds", "time", "window"));
  EXPECT_THAT(file.shape("/window"), ElementsAre(2));
  EXPECT_THAT(file.shape("/time"), ElementsAre(2));
  EXPECT_THAT(file.shape("/seconds"), ElementsAre(1));
  EXPECT_THAT(file.list("/in"), ElementsAre("drag", "positions"));
  EXPECT_THAT(file.list("/out"), ElementsAre("forces", "velocity"));
  EXPECT_THAT(file.shape("/in/positions/values"), ElementsAre(4, 2));
  EXPECT_THAT(file.shape("/in/positions/shape"), ElementsAre(2));
  EXPECT_EQ(file.text_attribute("/in/drag/values", "unit"), "N");
  EXPECT_EQ(file.text_attribute("/out/velocity/values", "unit"), "m/s");
}

TEST_F(SlotTest, SaysWhenItIsNotMapped) {
  const Slot made = slot(false);
  EXPECT_EQ(File(path_, File::Mode::read).text_attribute("/", "transport"), "file");
}

TEST_F(SlotTest, IsReadableWithTheNewestNumbersAtEveryMoment) {
  Slot made = slot();
  for (std::int64_t index = 1; index <= 5; ++index) {
    const auto number = static_cast<double>(index);
    made.set_window({index, 2, number - 1, number});
    made.give(0, Numbers{number, 2 * number, 3 * number}, {3});
    const File file(path_, File::Mode::read);
    EXPECT_THAT(file.read_counts("/window"), ElementsAre(index, 2));
    EXPECT_THAT(file.read_numbers("/time"), ElementsAre(number - 1, number));
    EXPECT_THAT(file.read_numbers("/in/drag/values"), ElementsAre(number, 2 * number, 3 * number));
    EXPECT_THAT(file.read_counts("/in/drag/shape"), ElementsAre(3));
  }
  EXPECT_EQ(made.window().index, 5);
  EXPECT_EQ(made.window().iteration, 2);
  EXPECT_EQ(made.window().begin, 4);
  EXPECT_EQ(made.window().end, 5);
}

TEST_F(SlotTest, FewerRowsArePackedAndCounted) {
  Slot made = slot();
  made.give(1, Numbers{1, 2, 3, 4, 5, 6, 7, 8}, {4, 2});
  made.give(1, Numbers{9, 8, 7, 6}, {2, 2});
  {
    const File file(path_, File::Mode::read);
    EXPECT_THAT(file.read_counts("/in/positions/shape"), ElementsAre(2, 2));
    EXPECT_THAT(file.read_numbers("/in/positions/values", 2), ElementsAre(9, 8, 7, 6));
  }
  made.give(1, Numbers{}, {0, 2});
  EXPECT_THAT(File(path_, File::Mode::read).read_counts("/in/positions/shape"), ElementsAre(0, 2));
}

TEST_F(SlotTest, FieldsDoNotTouchEachOther) {
  Slot made = slot();
  made.give(0, Numbers{1, 1, 1}, {3});
  made.give(1, Numbers(8, 2.0), {4, 2});
  made.set_window({7, 1, 3, 4});
  made.clear_outputs();
  const File file(path_, File::Mode::read);
  EXPECT_THAT(file.read_numbers("/in/drag/values"), Each(1));
  EXPECT_THAT(file.read_numbers("/in/positions/values"), Each(2));
  EXPECT_THAT(file.read_numbers("/seconds"), ElementsAre(0));
}

TEST_F(SlotTest, WhatWasNotSentIsMissing) {
  Slot made = slot();
  EXPECT_LT(made.take(0).shape.at(0), 0) << "from the start";
  made.read_fresh(answer("velocity", {2}, {1.5, 2.5}));
  EXPECT_THAT(copy(made.take(0)), ElementsAre(1.5, 2.5));
  EXPECT_THAT(made.take(0).shape, ElementsAre(2));
  EXPECT_LT(made.take(1).shape.at(0), 0) << "not in the answer";
  EXPECT_EQ(made.seconds(), 0.25);
  made.clear_outputs();
  EXPECT_LT(made.take(0).shape.at(0), 0) << "forgotten";
  EXPECT_TRUE(File(path_, File::Mode::read).exists("/out/velocity/values"));
}

TEST_F(SlotTest, FewerRowsComeBackAsTheyAre) {
  Slot made = slot();
  made.read_fresh(answer("forces", {1, 2}, {5, 6}));
  EXPECT_THAT(copy(made.take(1)), ElementsAre(5, 6));
  EXPECT_THAT(made.take(1).shape, ElementsAre(1, 2));
}

TEST_F(SlotTest, AWrongShapeIsToldAsItIs) {
  const Shape wrong[] = {{1}, {3}, {1000}, {2, 1}, {1, 2}, {2, 2, 2}, {}};
  for (const Shape& shape : wrong) {
    Slot made = slot();
    const Numbers values(static_cast<size_t>(hdf5::count_of(shape)), 1.0);
    made.read_fresh(answer("velocity", shape, values));
    EXPECT_THAT(made.take(0).shape, ElementsAreArray(shape));
    EXPECT_LE(made.take(0).values.size(), 2U) << "never more than there is room for";
    made.clear_outputs();
    EXPECT_THAT(made.take(0).shape, ElementsAre(-1));
  }
}

TEST_F(SlotTest, AFreshFileHoldsTheActualShapes) {
  Slot made = slot(false);
  made.set_window({3, 2, 0.5, 0.75});
  made.give(0, Numbers{1, 2, 3}, {3});
  made.give(1, Numbers{4, 5}, {1, 2});
  const std::string path = scratch_.file("window.in.h5");
  made.write_fresh(path);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  const File file(path, File::Mode::read);
  EXPECT_EQ(file.text_attribute("/", "filetype"), "sandglass slot");
  EXPECT_THAT(file.read_counts("/window"), ElementsAre(3, 2));
  EXPECT_THAT(file.read_numbers("/time"), ElementsAre(0.5, 0.75));
  EXPECT_THAT(file.read_numbers("/in/drag/values"), ElementsAre(1, 2, 3));
  EXPECT_THAT(file.shape("/in/positions/values"), ElementsAre(1, 2));
  EXPECT_THAT(file.read_counts("/in/positions/shape"), ElementsAre(1, 2));
  EXPECT_EQ(file.text_attribute("/in/positions/values", "unit"), "m");
}

TEST_F(SlotTest, AnAnswerThatIsNoFileIsAnError) {
  Slot made = slot(false);
  EXPECT_THROW(made.read_fresh(scratch_.file("none.h5")), Error);
  std::ofstream(scratch_.file("half.h5")) << "\211HDF\r\n\032\n";
  EXPECT_THROW(made.read_fresh(scratch_.file("half.h5")), Error);
}

TEST_F(SlotTest, AnAnswerOfAnotherTypeIsAnError) {
  Slot made = slot(false);
  const std::string path = scratch_.file("answer.h5");
  {
    File file(path, File::Mode::create);
    file.write("/out/velocity/values/inside", {2}, Numbers{1, 2});
  }
  EXPECT_THAT(error_of([&] { made.read_fresh(path); }).what(), HasSubstr("/out/velocity/values"));
}

TEST_F(SlotTest, AFileThatWasMadeShorterIsFoundWithoutTouchingIt) {
  Slot made = slot();
  made.set_window({7, 1, 0, 1});
  made.require_whole();
  std::filesystem::resize_file(path_, 100);
  const Error error = test::error_of([&] { made.require_whole(); });
  EXPECT_EQ(error.code(), ExitCode::participant);
  EXPECT_THAT(error.what(), testing::HasSubstr("participant fluid"));
  EXPECT_THAT(error.what(), testing::HasSubstr(path_));
  EXPECT_EQ(made.window().index, 7);
}

TEST_F(SlotTest, NoFieldsAreFineToo) {
  const Slot made(path_, "clock", {}, {}, true);
  EXPECT_THAT(File(path_, File::Mode::read).list("/"), ElementsAre("seconds", "time", "window"));
}

TEST_F(SlotTest, AFullDiskIsFoundAtTheStart) {
  EXPECT_EQ(test::run_elsewhere([&] {
              test::limit_file_size(1 << 20);
              try {
                const Slot made(path_, "fluid", {{"huge", "m", {1 << 20}}}, {}, true);
              } catch (const Error& error) {
                return error.code() == ExitCode::environment && !test::remedy_of(error).empty() ? 0
                                                                                                : 1;
              }
              return 2;
            }),
            0);
}

TEST_F(SlotTest, TakesItsSpaceOnTheDiskAtTheStart) {
  const Slot made(path_, "fluid", {{"large", "m", {1 << 17}}}, {}, true);
  struct stat status {};
  ASSERT_EQ(::stat(path_.c_str(), &status), 0);
  EXPECT_GE(status.st_blocks * 512, 1 << 20) << "a hole would be a deadly signal on a full disk";
}

TEST(ShapeText, ReadsLikeAList) {
  EXPECT_EQ(shape_text({3, 2}), "[3, 2]");
  EXPECT_EQ(shape_text({}), "[]");
}

}  // namespace
}  // namespace sandglass::exchange
