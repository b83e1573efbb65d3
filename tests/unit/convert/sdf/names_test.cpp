// Node names of SDF scenes: scopes, escapes, uniqueness.
#include "convert/sdf/names.h"

#include <gtest/gtest.h>

#include <string>

namespace fire3dv::convert {
namespace {

TEST(SdfNames, NamesAreJoined) {
  const std::string robot = scoped_sdf_name("", "robot", SdfEntity::model);
  const std::string arm = scoped_sdf_name(robot, "arm", SdfEntity::model);
  const std::string wrist = scoped_sdf_name(arm, "wrist", SdfEntity::link);
  EXPECT_EQ(robot, "robot");
  EXPECT_EQ(scoped_sdf_name(wrist, "visual", SdfEntity::visual), "robot/arm/wrist/visual");
  EXPECT_EQ(scoped_sdf_name(wrist, "", SdfEntity::light), "robot/arm/wrist/light");
}

TEST(SdfNames, SlashesAreEscaped) {
  EXPECT_EQ(scoped_sdf_name("a", "b/c", SdfEntity::link), "a/b~1c");
  EXPECT_EQ(scoped_sdf_name("a", "b~1c", SdfEntity::link), "a/b~01c");
  EXPECT_EQ(scoped_sdf_name("", "x::y z", SdfEntity::model), "x::y z");
}

TEST(SdfNames, KeepWhatStreamsRefuseOut) {
  EXPECT_EQ(escaped_sdf_name("a\nb\x7f\xff"), "a?b??");
  EXPECT_EQ(escaped_sdf_name("\xc3\xa9"), "\xc3\xa9");
}

TEST(SdfNames, AreUnique) {
  SdfNames names;
  EXPECT_EQ(names.take("a/lamp", SdfEntity::link), "a/lamp");
  EXPECT_EQ(names.take("a/lamp", SdfEntity::light), "a/lamp light");
  EXPECT_EQ(names.take("a/lamp", SdfEntity::light), "a/lamp light 2");
  EXPECT_EQ(names.take("a/lamp", SdfEntity::sensor), "a/lamp sensor");
  names.release("a/lamp");
  EXPECT_EQ(names.take("a/lamp", SdfEntity::link), "a/lamp");
}

TEST(SdfNames, LookUpIsLinear) {
  SdfNames names;
  std::string last;
  for (int i = 0; i < 200'000; ++i)
    last = names.take("a", SdfEntity::link);  // hours, if each began at the first
  EXPECT_EQ(last, "a link 199999");
}

TEST(SdfNames, FitIntoAStream) {
  SdfNames names;
  const std::string longest(3000, 'x');
  EXPECT_EQ(names.take(longest, SdfEntity::model), std::string(1024, 'x'));
  EXPECT_EQ(names.take(longest, SdfEntity::model), std::string(1018, 'x') + " model");
}

}  // namespace
}  // namespace fire3dv::convert
