// Test of words of text.
#include "base/words.h"

#include <gtest/gtest.h>

namespace fire3dv {
namespace {

TEST(Words, TrimmedKeepsInnerBlanks) {
  EXPECT_EQ(trimmed(" \t\v\f\r\na b\n"), "a b");
  EXPECT_EQ(trimmed("a"), "a");
  EXPECT_EQ(trimmed(" \n"), "");
  EXPECT_EQ(trimmed(""), "");
  EXPECT_EQ(trimmed("\na \n", " "), "\na \n");
}

TEST(Words, NextWordLeavesWhatFollows) {
  std::string_view text = " solid\nname";
  EXPECT_EQ(next_word(text), "solid");
  EXPECT_EQ(text, "\nname") << "the line end is still there";
  EXPECT_EQ(next_word(text), "name");
  EXPECT_EQ(next_word(text), "");
  std::string_view line = "a\rb c";
  EXPECT_EQ(next_word(line, " "), "a\rb");
}

TEST(Words, CountedByBlanks) {
  EXPECT_EQ(count_words(""), 0u);
  EXPECT_EQ(count_words(" \n"), 0u);
  EXPECT_EQ(count_words("1 2\t3\n4"), 4u);
}

}  // namespace
}  // namespace fire3dv
