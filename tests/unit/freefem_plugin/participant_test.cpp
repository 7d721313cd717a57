#include "participant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "hdf5_file.hpp"

namespace sandglass {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

template <class Number>
void put(const std::string& path, const std::string& name, hid_t type,
         const std::vector<hsize_t>& shape, const std::vector<Number>& values,
         H5D_alloc_time_t when = H5D_ALLOC_TIME_EARLY) {
  const hid_t file = std::filesystem::exists(path)
                         ? H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT)
                         : H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t links = H5Pcreate(H5P_LINK_CREATE), layout = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  H5Pset_alloc_time(layout, when);
  const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
  const hid_t set = H5Dcreate2(file, name.c_str(), type, space, links, layout, H5P_DEFAULT);
  if (!values.empty()) H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(set), H5Sclose(space), H5Pclose(layout), H5Pclose(links), H5Fclose(file);
}

/// A slot that receives `grains` [at most 4 x 3] and sends `drag` [2], and both ends of two pipes.
class FreefemParticipant : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("sandglass_freefem_plugin_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    ASSERT_EQ(pipe(command_pipe_), 0);
    ASSERT_EQ(pipe(reply_pipe_), 0);
  }
  void TearDown() override {
    for (const int end : {command_pipe_[0], command_pipe_[1], reply_pipe_[0], reply_pipe_[1]})
      close(end);
    std::filesystem::remove_all(folder_);
  }

  [[nodiscard]] std::string slot(const std::string& transport = "mapped") const {
    std::string path = folder_ / "slot.h5";
    put<std::int64_t>(path, "/window", H5T_STD_I64LE, {2}, {7, 1});
    put<double>(path, "/time", H5T_IEEE_F64LE, {2}, {0.5, 0.75});
    put<double>(path, "/seconds", H5T_IEEE_F64LE, {1}, {-1});
    put<double>(path, "/in/grains/values", H5T_IEEE_F64LE, {4, 3},
                {1, 2, 3, 4, 5, 6, 0, 0, 0, 0, 0, 0});
    put<std::int64_t>(path, "/in/grains/shape", H5T_STD_I64LE, {2}, {2, 3});
    put<double>(path, "/out/drag/values", H5T_IEEE_F64LE, {2}, {0, 0});
    put<std::int64_t>(path, "/out/drag/shape", H5T_STD_I64LE, {1}, {2});
    hdf5_file::set_attribute(path, "/", "filetype", "sandglass slot");
    hdf5_file::set_attribute(path, "/", "transport", transport);
    hdf5_file::set_attribute(path, "/in/grains/values", "unit", "m/s");
    hdf5_file::set_attribute(path, "/out/drag/values", "unit", "N");
    return path;
  }
  [[nodiscard]] Participant participant(const std::string& path) const {
    return {command_pipe_[0], reply_pipe_[1], path};
  }
  void command(const std::string& text) const {
    ASSERT_EQ(write(command_pipe_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  [[nodiscard]] std::string replies() const {
    char text[512];
    const ssize_t got = read(reply_pipe_[0], text, sizeof text);
    return {text, static_cast<std::size_t>(got > 0 ? got : 0)};
  }

  std::filesystem::path folder_;
  int command_pipe_[2] = {}, reply_pipe_[2] = {};
};

TEST_F(FreefemParticipant, TakesTheRowsThatAreFilledAndAnswersInTheSlot) {
  const std::string path = slot();
  Participant us = participant(path);
  us.ready("memory disk");
  command("advance\n");
  EXPECT_EQ(us.next(), "advance");
  EXPECT_EQ(us.window(0), 7);
  EXPECT_EQ(us.time(1), 0.75);
  const auto grains = us.receive("grains");
  EXPECT_THAT(grains.shape, ElementsAre(2, 3));
  EXPECT_THAT(grains.values, ElementsAre(1, 2, 3, 4, 5, 6));
  us.send("drag", {8, 9});
  us.done();
  EXPECT_EQ(replies(), "ready 1 memory disk\nok\n");
  EXPECT_THAT(hdf5_file::read<double>(path, "/out/drag/values").values, ElementsAre(8, 9));
  EXPECT_GE(hdf5_file::read<double>(path, "/seconds").values.at(0), 0);
}

TEST_F(FreefemParticipant, SaysTheShapeItReallySentAndCutsOffTheRest) {
  const std::string path = slot();
  Participant us = participant(path);
  command("advance\n");
  us.next();
  us.send("drag", {1, 2, 3});
  us.done();
  EXPECT_THAT(hdf5_file::read<std::int64_t>(path, "/out/drag/shape").values, ElementsAre(3));
  EXPECT_THAT(hdf5_file::read<double>(path, "/out/drag/values").values, ElementsAre(1, 2));
}

TEST_F(FreefemParticipant, WritesAFreshFileUnderItsNameAtTheEndOnly) {
  const std::string path = slot("file");
  Participant us = participant(path);
  const std::string in = folder_ / "in.h5", out = folder_ / "out.h5";
  hdf5_file::write<std::int64_t>(in, "/window", {{2}, {3, 2}});
  hdf5_file::write<double>(in, "/time", {{2}, {1, 2}});
  hdf5_file::write<double>(in, "/in/grains/values", {{1, 3}, {1, 2, 3}});
  command("advance " + in + " " + out + "\n");
  us.next();
  EXPECT_THAT(us.receive("grains").shape, ElementsAre(1, 3));
  EXPECT_EQ(us.window(1), 2);
  us.send("drag", {NAN, 1});
  EXPECT_FALSE(std::filesystem::exists(out));
  us.done();
  EXPECT_EQ(replies(), "ok\n");
  EXPECT_TRUE(std::isnan(hdf5_file::read<double>(out, "/out/drag/values").values.at(0)));
  EXPECT_THAT(hdf5_file::read<std::int64_t>(out, "/window").values, ElementsAre(3, 2));
  EXPECT_EQ(hdf5_file::text_attribute(out, "/out/drag/values", "unit"), "N");
}

TEST_F(FreefemParticipant, ReadsCommandsThatArriveInPieces) {
  Participant us = participant(slot());
  command("checkpoint a folder/state.h5\nsa");
  EXPECT_EQ(us.next(), "checkpoint");
  EXPECT_EQ(us.path(), "a folder/state.h5");
  us.done();
  command("ve\n");
  EXPECT_EQ(us.next(), "save");
}

TEST_F(FreefemParticipant, KnowsTheEndOfCommands) {
  Participant us = participant(slot());
  close(command_pipe_[1]);
  command_pipe_[1] = dup(0);
  EXPECT_EQ(us.next(), "");
}

TEST_F(FreefemParticipant, RefusesToAnswerWithoutTheFieldsItOwes) {
  Participant us = participant(slot());
  command("advance\n");
  us.next();
  EXPECT_THAT([&] { us.done(); }, ThrowsMessage<std::runtime_error>(HasSubstr("'drag'")));
}

TEST_F(FreefemParticipant, NamesTheFieldsThereAre) {
  Participant us = participant(slot());
  command("advance\n");
  us.next();
  EXPECT_THAT([&] { return us.receive("grain"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("the workflow names: grains")));
}

TEST_F(FreefemParticipant, TellsAnErrorInOneLine) {
  Participant us = participant(slot());
  command("advance\n");
  us.next();
  us.fail("no\nconvergence");
  EXPECT_EQ(replies(), "error no convergence\n");
}

TEST_F(FreefemParticipant, RefusesASlotWhoseBytesCouldMove) {
  const std::string path = slot();
  put<double>(path, "/in/late/values", H5T_IEEE_F64LE, {2}, {}, H5D_ALLOC_TIME_LATE);
  put<std::int64_t>(path, "/in/late/shape", H5T_STD_I64LE, {1}, {2});
  hdf5_file::set_attribute(path, "/in/late/values", "unit", "m");
  EXPECT_THAT([&] { return participant(path); },
              ThrowsMessage<std::runtime_error>(HasSubstr("could move")));
}

TEST(ShapeSent, CutsIntoRowsWhenItCan) {
  EXPECT_THAT(shape_sent({4, 3}, 6), ElementsAre(2, 3));
  EXPECT_THAT(shape_sent({4, 3}, 5), ElementsAre(5, 1));
  EXPECT_THAT(shape_sent({4}, 9), ElementsAre(9));
}

}  // namespace
}  // namespace sandglass
