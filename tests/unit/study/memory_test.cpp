#include "study/memory.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "../support/scratch.hpp"
#include "base/file.hpp"

namespace sandglass::study {
namespace {

class Memory : public testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(file) << text; }

  test::Scratch scratch;
  std::string file = scratch.file("solver");
  std::string kept = scratch.file("memory.json");
};

TEST_F(Memory, GivesTheDigestOfTheFile) {
  write("one");
  EXPECT_EQ(FileMemory(kept).digest(file), digest_of_text("one"));
  EXPECT_EQ(FileMemory(kept).digest(scratch.file("missing")), "");
}

TEST_F(Memory, AFileThatLooksTheSameIsNotReadAgain) {
  write("one");
  FileMemory first(kept);
  (void)first.digest(file);
  first.keep();
  // The kept digest is replaced by another text: it must come back, since the file was not touched.
  std::string text = read_file(kept);
  const std::string digest = digest_of_text("one");
  write_file(kept, text.replace(text.find(digest), digest.size(), "remembered"));
  EXPECT_EQ(FileMemory(kept).digest(file), "remembered");
  write("two");
  EXPECT_EQ(FileMemory(kept).digest(file), digest_of_text("two"));
}

TEST_F(Memory, SeesChangedReplacedMissingAndNewFiles) {
  write("one");
  FileMemory memory(kept);
  (void)memory.digest(file);
  memory.look(scratch.file("later"));
  memory.keep();
  EXPECT_TRUE(FileMemory(kept).all_unchanged());
  write_file(scratch.file("later"), "there now");
  EXPECT_FALSE(FileMemory(kept).all_unchanged());
  std::filesystem::remove(scratch.file("later"));
  EXPECT_TRUE(FileMemory(kept).all_unchanged());
  // The same size and the same time of change: another file nevertheless.
  const auto time = std::filesystem::last_write_time(file);
  std::ofstream(scratch.file("other")) << "two";
  std::filesystem::rename(scratch.file("other"), file);
  std::filesystem::last_write_time(file, time);
  EXPECT_FALSE(FileMemory(kept).all_unchanged());
}

TEST_F(Memory, AnIllegibleMemoryIsEmpty) {
  write_file(kept, "{\"files\": 3");
  EXPECT_FALSE(FileMemory(kept).all_unchanged());
  write("one");
  EXPECT_EQ(FileMemory(kept).digest(file), digest_of_text("one"));
}

}  // namespace
}  // namespace sandglass::study
