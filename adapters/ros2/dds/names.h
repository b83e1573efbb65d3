// ROS 2 names: namespaces, remapping rules and the names of DDS topics, as rcl and rmw form them.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace fire3dv::ros2 {

// True for a valid topic name: tokens of letters, digits and underscores that do not begin with a digit,
// separated by single slashes; absolute ("/a/b"), relative ("a/b") or private ("~/a").
bool is_valid_name(std::string_view name);

// Namespace, node name and remapping rules of one node.
class Names {
 public:
  Names() = default;
  // ns: absolute or without its slash; "" and "/" are the root.
  static Result<Names> create(std::string_view ns, std::string_view node);

  const std::string& ns() const { return ns_; }      // "/" or "/a/b"
  const std::string& node() const { return node_; }  // "fire3dv_ros2"

  // Adds a rule of --remap: "from:=to", "__ns:=/a", "__node:=name", "NODE:from:=to". Rules for another node
  // are ignored.
  Result<void> remap(std::string_view rule);

  // Absolute name of a topic after expansion and the first rule that matches. `name` is valid.
  std::string resolve(std::string_view name) const;

 private:
  std::string expand(std::string_view name) const;

  std::string ns_ = "/";
  std::string node_ = "fire3dv_ros2";
  std::vector<std::pair<std::string, std::string>> rules_;
};

// DDS topic of an absolute ROS topic: "/a/b" is "rt/a/b".
std::string dds_topic_name(std::string_view absolute);

// ROS topic of a DDS topic; empty for topics that are not ROS topics.
std::string ros_topic_name(std::string_view dds_topic);

// "tf2_msgs::msg::dds_::TFMessage_" is "tf2_msgs/msg/TFMessage". Other names are unchanged.
std::string ros_type_name(std::string_view dds_type);

}  // namespace fire3dv::ros2
