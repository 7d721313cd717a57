#include "participant/replies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sandglass::participant {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Optional;

TEST(Replies, AnAnswerIsALineThatIsNeitherNoteNorSaving) {
  Replies replies;
  replies.unread() = "note first\nsaved solve 1.5\nok\nnote second\nerror what\nhal";
  EXPECT_TRUE(replies.holds_line());
  EXPECT_THAT(replies.next_answer(), Optional(std::string("ok")));
  EXPECT_THAT(replies.notes(), ElementsAre("first"));
  EXPECT_THAT(replies.next_answer(), Optional(std::string("error what")));
  EXPECT_EQ(replies.next_answer(), std::nullopt);
  EXPECT_FALSE(replies.holds_line());
  replies.unread() += "f\n";
  EXPECT_THAT(replies.next_answer(), Optional(std::string("half")));
  EXPECT_THAT(replies.notes(), ElementsAre("first", "second"));
  ASSERT_EQ(replies.savings().size(), 1U);
  EXPECT_EQ(replies.savings()[0].name, "solve");
  EXPECT_EQ(replies.savings()[0].seconds, 1.5);
}

TEST(Replies, TheNewestSavingOfAName) {
  Replies replies;
  replies.unread() = "saved a 1\nsaved b 2\nsaved a 3\nsaved\nsaved a many\n";
  EXPECT_EQ(replies.next_answer(), "saved");
  EXPECT_EQ(replies.next_answer(), std::nullopt);
  ASSERT_EQ(replies.savings().size(), 2U);
  EXPECT_EQ(replies.savings()[0].seconds, 0) << "what is no number counts as nothing";
  EXPECT_EQ(replies.savings()[1].seconds, 2);
}

TEST(Replies, MemoryIsBounded) {
  Replies replies;
  for (int n = 0; n < 5000; ++n) {
    replies.unread() += "note n\nsaved s" + std::to_string(n) + " 1\n";
    EXPECT_EQ(replies.next_answer(), std::nullopt);
  }
  EXPECT_EQ(replies.notes().size(), 1000U);
  EXPECT_EQ(replies.savings().size(), 1000U);
  EXPECT_FALSE(replies.endless());
  replies.unread() = std::string(70000, 'x');
  EXPECT_TRUE(replies.endless());
  replies.clear();
  EXPECT_FALSE(replies.endless());
}

TEST(Replies, Abilities) {
  EXPECT_THAT(abilities_in("ready 1"), Optional(IsEmpty()));
  EXPECT_THAT(abilities_in("ready 1 memory  disk"), Optional(ElementsAre("disk", "memory")));
  for (const char* line : {"", "ready", "ready 2 memory", "ready1", "Ready 1", "ok"}) {
    EXPECT_EQ(abilities_in(line), std::nullopt) << line;
  }
}

}  // namespace
}  // namespace sandglass::participant
