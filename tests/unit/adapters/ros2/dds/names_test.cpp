// ROS 2 names: namespaces and remapping as rcl documents them (REP 144 and the design article on remapping).
#include "adapters/ros2/dds/names.h"

#include <gtest/gtest.h>

namespace fire3dv::ros2 {
namespace {

Names make(std::string_view ns, std::initializer_list<const char*> rules = {}) {
  Result<Names> names = Names::create(ns, "viewer");
  EXPECT_TRUE(names.ok());
  for (const char* rule : rules) EXPECT_TRUE(names->remap(rule).ok()) << rule;
  return *names;
}

TEST(Ros2Names, NamesAreExpanded) {
  EXPECT_EQ(make("").resolve("joint_states"), "/joint_states");
  EXPECT_EQ(make("robot1").resolve("joint_states"), "/robot1/joint_states");
  EXPECT_EQ(make("/a/b").resolve("/tf"), "/tf");
  EXPECT_EQ(make("/a/b").resolve("~/image"), "/a/b/viewer/image");
  EXPECT_EQ(make("/").resolve("~/image"), "/viewer/image");
}

TEST(Ros2Names, TheFirstMatchingRuleCounts) {
  const Names names = make("/robot1", {"/tf:=tf", "/tf:=/other", "joint_states:=/js"});
  EXPECT_EQ(names.resolve("/tf"), "/robot1/tf");
  EXPECT_EQ(names.resolve("/tf_static"), "/tf_static");
  EXPECT_EQ(names.resolve("joint_states"), "/js");
  EXPECT_EQ(names.resolve("/joint_states"), "/joint_states");
}

TEST(Ros2Names, RulesSetNamespaceAndNode) {
  Names names = make("", {"tf2:=/x", "__ns:=/fleet", "__node:=eye", "eye:a:=b", "mouth:a:=c"});
  EXPECT_EQ(names.ns(), "/fleet");
  EXPECT_EQ(names.node(), "eye");
  EXPECT_EQ(names.resolve("tf2"), "/x");
  EXPECT_EQ(names.resolve("a"), "/fleet/b");
  EXPECT_EQ(names.resolve("~/a"), "/fleet/eye/a");
}

TEST(Ros2Names, RefusesWhatIsNotName) {
  Names names;
  for (const char* rule :
       {"a", "a=b", ":=b", "a:=", "a b:=c", "a:=/", "a//b:=c", "1a:=b", "__ns:=a-b", "__node:=a/b"})
    EXPECT_FALSE(names.remap(rule).ok()) << rule;
  EXPECT_FALSE(Names::create("a//b", "n").ok());
  EXPECT_FALSE(Names::create("a", "n n").ok());
  EXPECT_TRUE(is_valid_name("/a/_b2"));
  for (const char* name : {"", "/", "a/", "~", "~a", "a b", "ä"}) EXPECT_FALSE(is_valid_name(name)) << name;
}

TEST(Ros2Names, TopicsMapToDds) {
  EXPECT_EQ(dds_topic_name("/a/b"), "rt/a/b");
  EXPECT_EQ(ros_topic_name("rt/a/b"), "/a/b");
  EXPECT_EQ(ros_topic_name("rq/a/bRequest"), "");
  EXPECT_EQ(ros_type_name("tf2_msgs::msg::dds_::TFMessage_"), "tf2_msgs/msg/TFMessage");
  EXPECT_EQ(ros_type_name("Square"), "Square");
}

}  // namespace
}  // namespace fire3dv::ros2
