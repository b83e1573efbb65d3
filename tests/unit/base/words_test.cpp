// Test of words of text.
#include "base/words.h"

#include <gtest/gtest.h>

#include <array>

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

TEST(Words, AShellReadsTheWordThatIsMeant) {
  EXPECT_EQ(shell_word("/a/b-1.json:@x,y=%"), "/a/b-1.json:@x,y=%");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("$(id)'x"), "'$(id)'\\''x'");
  EXPECT_EQ(shell_word("~"), "'~'");
}

TEST(Words, JoinedByASeparator) {
  EXPECT_EQ(joined(std::array<std::string_view, 0>{}), "");
  EXPECT_EQ(joined(std::array<std::string_view, 3>{"a", "", "c"}), "a, , c");
  EXPECT_EQ(joined(std::array<std::string_view, 2>{"a", "c"}, ":"), "a:c");
}

}  // namespace
}  // namespace fire3dv
