// Unit test of the hints at existing names.
#include "base/nearest_names.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace fire3dv {
namespace {

using Names = std::vector<std::string>;

TEST(NearestNames, AreWithinAThirdOfTheLetters) {
  EXPECT_EQ(nearest_names("needel", {"clamp", "needle", "Needle"}), (Names{"Needle", "needle"}));
  EXPECT_EQ(nearest_names("arm", {"left_arm", "leg", "am"}), (Names{"am", "left_arm"}));
  EXPECT_EQ(nearest_names("gripper", {"a", "finger"}), Names());
  EXPECT_EQ(nearest_names("x", {"y", "xy", ""}), (Names{"xy", "y"}));
  EXPECT_EQ(nearest_names("part_9", {"part_1", "part_2", "part_3", "part_4"}, 2),
            (Names{"part_1", "part_2"}));
}

TEST(NearestNames, LongNamesCostLittle) {
  const std::string longest(1'000'000, 'a');
  EXPECT_EQ(nearest_names(longest, {longest, std::string(100, 'a')}), (Names{std::string(100, 'a')}));
}

TEST(NameHint, ListsNearNamesOrSome) {
  EXPECT_EQ(name_hint("nedle", {"needle", "clamp"}, "nodes"), "; did you mean \"needle\"?");
  EXPECT_EQ(name_hint("part_9", {"part_1", "part_2", "x"}, "nodes"),
            "; did you mean \"part_1\" or \"part_2\"?");
  EXPECT_EQ(name_hint("q", {"", "clamp", "needle", "clamp"}, "nodes"), "; there are \"clamp\", \"needle\"");
  EXPECT_EQ(name_hint("q", {"clamp"}, "nodes"), "; there is \"clamp\"");
  EXPECT_EQ(name_hint("q", {""}, "nodes"), "; there are no nodes");
  Names many;
  for (int i = 10; i < 30; ++i) many.push_back("body " + std::to_string(i));
  EXPECT_TRUE(name_hint("q", many, "nodes").ends_with("\"body 17\" and 12 more"));
  EXPECT_EQ(name_hint("q", {"a\nb"}, "nodes"), "; there is \"a?b\"");
}

}  // namespace
}  // namespace fire3dv
