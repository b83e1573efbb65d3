#include "protocol/robot/robot_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/files.h"
#include "protocol/robot/robot_json.h"
#include "protocol/wire/check.h"

namespace fire3dv::robot {
namespace {

constexpr uint64_t kMaxJsonBytes = uint64_t{64} << 20;
constexpr size_t kMaxNodes = 1'000'000, kMaxBodies = 100'000, kMaxPoses = 256;
constexpr int kVersion = 1;

// --- nodes of the scene

class Nodes {
 public:
  explicit Nodes(const Json& document) {
    const Json* const nodes = member(document, "nodes");
    if (!nodes || !nodes->is_array()) throw Fault("it has no nodes");
    if (nodes->size() > kMaxNodes) throw Fault("it has more than " + std::to_string(kMaxNodes) + " nodes");
    nodes_ = nodes;
    parents_.resize(nodes->size());
    for (size_t i = 0; i < nodes->size(); ++i) {
      const Json& node = (*nodes)[i];
      if (const Json* name = member(node, "name"); name && name->is_string())
        by_name_.emplace(name->get_ref<const std::string&>(), i);
      find_robot(node, i);
      const Json* const children = member(node, "children");
      if (!children || !children->is_array()) continue;
      for (const Json& child : *children)
        if (child.is_number_unsigned() && child.get<uint64_t>() < parents_.size())
          parents_[child.get<uint64_t>()] = i;
    }
  }

  const Json* robot() const { return robot_; }  // null: the file holds none

  // Global transform of the robot's node, whose frame is the model's.
  Transform world_from_model() const {
    Transform world_from;
    size_t steps = 0;
    for (std::optional<size_t> at = robot_node_; at; at = parents_[*at]) {
      if (++steps > parents_.size()) throw Fault("its nodes are children of themselves");
      world_from = local(*at) * world_from;
    }
    return world_from;
  }

  // Empty: no such node.
  std::optional<Vector> scale_of(const std::string& name) const {
    const auto found = by_name_.find(name);
    if (found == by_name_.end()) return std::nullopt;
    const Json& node = (*nodes_)[found->second];
    const std::string json_path = "node " + in_quotes(name);
    if (const auto matrix = numbers_of<16>(node, "matrix", json_path)) {
      const auto& m = *matrix;  // column-major
      return Vector{std::hypot(m[0], m[1], m[2]), std::hypot(m[4], m[5], m[6]),
                    std::hypot(m[8], m[9], m[10])};
    }
    return numbers_of<3>(node, "scale", json_path).value_or(Vector{1, 1, 1});
  }

 private:
  void find_robot(const Json& node, size_t index) {
    const Json* const extras = member(node, "extras");
    const Json* const own = extras ? member(*extras, "fire3dv") : nullptr;
    const Json* const robot = own ? member(*own, "robot") : nullptr;
    if (!robot) return;
    if (robot_) throw Fault("it holds the joints of several robots: keep one robot in a file");
    robot_ = robot;
    robot_node_ = index;
  }

  Transform local(size_t index) const {
    const Json& node = (*nodes_)[index];
    const std::string json_path = "node " + std::to_string(index);
    if (const auto matrix = numbers_of<16>(node, "matrix", json_path)) {
      Transform t;
      for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column) t.m[row * 4 + column] = (*matrix)[column * 4 + row];
      return t;
    }
    Transform t = rigid_of(node, json_path);
    const Vector scale = numbers_of<3>(node, "scale", json_path).value_or(Vector{1, 1, 1});
    for (size_t row = 0; row < 3; ++row)
      for (size_t column = 0; column < 3; ++column) t.m[row * 4 + column] *= scale[column];
    return t;
  }

  const Json* nodes_ = nullptr;
  const Json* robot_ = nullptr;
  size_t robot_node_ = 0;
  std::vector<std::optional<size_t>> parents_;
  std::map<std::string, size_t> by_name_;
};

// --- bodies and joints

const Json& list_of(const Json& robot, const char* name) {
  const Json* const list = member(robot, name);
  const std::string json_path = std::string("robot.") + name;
  if (!list || !list->is_array()) throw Fault(json_path + " is not a list");
  if (list->size() > kMaxBodies)
    throw Fault(json_path + " has more than " + std::to_string(kMaxBodies) + " entries");
  return *list;
}

std::vector<RobotBody> read_bodies(const Json& robot, const Nodes& nodes,
                                   std::map<std::string, size_t>& index_of) {
  const Json& list = list_of(robot, "bodies");
  std::vector<RobotBody> bodies;
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string json_path = "robot.bodies[" + std::to_string(i) + "]";
    RobotBody body;
    body.node = text_of(list[i], "node", json_path);
    if (member(list[i], "parent")) {
      const std::string& parent = text_of(list[i], "parent", json_path);
      const auto known = index_of.find(parent);
      if (known == index_of.end())
        throw Fault(json_path + ".parent is " + in_quotes(parent) + ", which is not a body before it");
      body.parent = known->second;
    }
    if (!index_of.emplace(body.node, i).second) throw Fault("there are two bodies " + in_quotes(body.node));
    body.parent_from_body = rigid_of(list[i], json_path);
    body.scale = nodes.scale_of(body.node);
    bodies.push_back(std::move(body));
  }
  return bodies;
}

JointType type_of(const std::string& name, const std::string& json_path) {
  for (const JointType type : {JointType::fixed, JointType::revolute, JointType::prismatic, JointType::planar,
                               JointType::ball, JointType::floating})
    if (name == name_of(type)) return type;
  throw Fault(json_path + ".type is " + in_quotes(name) + ", which this version does not know");
}

bool is_scalar(const RobotJoint& joint) {
  return joint.type == JointType::revolute || joint.type == JointType::prismatic;
}

std::vector<double> initial_of(const Json& from, const RobotJoint& joint, const std::string& json_path) {
  const size_t count = position_count_of(joint.type);
  std::vector<double> initial(count, 0);
  if (is_scalar(joint)) initial[0] = joint.reference;
  if (count >= 4) initial.back() = 1;  // quaternion x y z w
  const Json* const given = member(from, "initial");
  if (!given) return initial;
  if (!given->is_array() || given->size() != count)
    throw Fault(json_path + ".initial is not a list of " + std::to_string(count) + " numbers");
  for (size_t i = 0; i < count; ++i) initial[i] = number_of((*given)[i], json_path + ".initial");
  return initial;
}

RobotJoint read_joint(const Json& from, const std::map<std::string, size_t>& bodies,
                      const std::string& json_path) {
  RobotJoint joint;
  joint.name = text_of(from, "name", json_path);
  joint.type = type_of(text_of(from, "type", json_path), json_path);
  const std::string& node = text_of(from, "node", json_path);
  const auto body = bodies.find(node);
  if (body == bodies.end()) throw Fault(json_path + ".node is " + in_quotes(node) + ", which is not a body");
  joint.body = body->second;
  joint.axis = numbers_of<3>(from, "axis", json_path).value_or(joint.axis);
  const double size = length(joint.axis);
  if (!(size > 1e-9)) throw Fault(json_path + ".axis has no length");
  for (double& number : joint.axis) number /= size;
  joint.anchor = numbers_of<3>(from, "anchor", json_path).value_or(joint.anchor);
  joint.reference = number_of(from, "reference", 0, json_path);
  if (const auto limits = numbers_of<2>(from, "limits", json_path); limits && is_scalar(joint)) {
    if (!((*limits)[0] <= (*limits)[1])) throw Fault(json_path + ".limits are not in order");
    joint.has_limits = true;
    joint.lower = (*limits)[0];
    joint.upper = (*limits)[1];
  }
  joint.initial = initial_of(from, joint, json_path);
  return joint;
}

std::vector<RobotJoint> read_joints(const Json& robot, const std::map<std::string, size_t>& bodies,
                                    bool follows_mimic) {
  const Json& list = list_of(robot, "joints");
  std::vector<RobotJoint> joints;
  std::map<std::string, size_t> index_of;
  const auto joint_path = [](size_t i) { return "robot.joints[" + std::to_string(i) + "]"; };
  for (size_t i = 0; i < list.size(); ++i) {
    joints.push_back(read_joint(list[i], bodies, joint_path(i)));
    if (!index_of.emplace(joints[i].name, i).second)
      throw Fault("there are two joints " + in_quotes(joints[i].name));
  }
  for (size_t i = 0; follows_mimic && i < list.size(); ++i) {
    const Json* const mimic = member(list[i], "mimic");
    if (!mimic) continue;
    const std::string json_path = joint_path(i) + ".mimic";
    const auto leader = index_of.find(text_of(*mimic, "joint", json_path));
    if (leader == index_of.end() || !is_scalar(joints[leader->second]) || !is_scalar(joints[i]))
      throw Fault(json_path + ": only revolute and prismatic joints follow each other");
    joints[i].leader = leader->second;
    joints[i].multiplier = number_of(*mimic, "multiplier", 1, json_path);
    joints[i].offset = number_of(*mimic, "offset", 0, json_path);
  }
  return joints;
}

// Poses in a file have the positions of all joints, also of those that follow others.
Result<void> add_poses(const Json& robot, Robot& made) {
  if (!member(robot, "poses")) return {};
  const Json& list = list_of(robot, "poses");
  if (list.size() > kMaxPoses)
    throw Fault("robot.poses has more than " + std::to_string(kMaxPoses) + " entries");
  size_t count = 0;
  for (const RobotJoint& joint : made.joints()) count += position_count_of(joint.type);
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string json_path = "robot.poses[" + std::to_string(i) + "]";
    const Json* const given = member(list[i], "positions");
    if (!given || !given->is_array() || given->size() != count)
      throw Fault(json_path + ".positions is not a list of " + std::to_string(count) + " numbers");
    NamedPose pose{text_of(list[i], "name", json_path), {}};
    size_t at = 0;
    for (const RobotJoint& joint : made.joints()) {
      for (size_t k = 0; k < position_count_of(joint.type); ++k, ++at)
        if (joint.position_count != 0)
          pose.positions.push_back(number_of((*given)[at], json_path + ".positions"));
    }
    if (Result<void> done = made.add_named_pose(std::move(pose)); !done) return done;
  }
  return {};
}

constexpr const char* kHoldsNone =
    "it holds no joints: convert the robot's URDF, SDF, MJCF or AMBF file by this version of fire3dv-convert";

// Empty: the document holds no robot.
Result<std::optional<Robot>> read_json(std::span<const std::byte> text, bool follows_mimic) {
  try {
    if (text.size() > kMaxJsonBytes) throw Fault("its JSON is larger than 64 MiB");
    const Json document = parse_json(text, "nodes");
    const Nodes nodes(document);
    if (!nodes.robot()) return std::optional<Robot>();
    const Json& robot = *nodes.robot();
    const Json* const version = member(robot, "version");
    if (!version || !version->is_number_integer() || version->get<int64_t>() != kVersion)
      throw Fault("robot.version is not " + std::to_string(kVersion) +
                  ": use programs and library of one version");
    std::map<std::string, size_t> index_of;
    std::vector<RobotBody> bodies = read_bodies(robot, nodes, index_of);
    Result<Robot> made =
        Robot::make(std::move(bodies), read_joints(robot, index_of, follows_mimic), nodes.world_from_model());
    if (!made) return made.error();
    if (Result<void> done = add_poses(robot, *made); !done) return done.error();
    return std::optional<Robot>(std::move(*made));
  } catch (const Fault& fault) {
    return Error{fault.what()};
  }
}

// --- container

struct Extent {
  uint64_t offset = 0, bytes = 0;
};

constexpr size_t kHeaderBytes = 20;  // of the file and of its first chunk

// Extent of the JSON, by the first bytes of a file.
Result<Extent> json_extent(std::span<const std::byte> head, uint64_t file_bytes) {
  if (head.size() < 4 || std::memcmp(head.data(), "glTF", 4) != 0) return Extent{0, file_bytes};
  std::array<uint32_t, 5> words{};
  if (head.size() < kHeaderBytes) return Error{"it ends within its header"};
  std::memcpy(words.data(), head.data(), kHeaderBytes);
  if (words[1] != 2) return Error{"it is glTF " + std::to_string(words[1]) + "; version 2 is needed"};
  if (words[4] != 0x4E4F534A) return Error{"its first chunk is no JSON"};
  if (words[3] > file_bytes - kHeaderBytes) return Error{"its JSON is truncated"};
  return Extent{kHeaderBytes, words[3]};
}

}  // namespace

Result<Robot> read_robot(std::span<const std::byte> glb_or_json, bool follows_mimic) {
  const Result<Extent> extent =
      json_extent(glb_or_json.first(std::min(glb_or_json.size(), kHeaderBytes)), glb_or_json.size());
  if (!extent) return extent.error();
  Result<std::optional<Robot>> robot =
      read_json(glb_or_json.subspan(extent->offset, extent->bytes), follows_mimic);
  if (!robot) return robot.error();
  if (!*robot) return Error{kHoldsNone};
  return std::move(**robot);
}

namespace {

// searches: a file that may hold no robot; a JSON too large for one holds none.
Result<std::optional<Robot>> read_file(const std::filesystem::path& file, bool follows_mimic, bool searches) {
  const Result<OpenFile> opened = OpenFile::open(file, UINT64_MAX);
  if (!opened) return opened.error();
  const auto fault = [&](const std::string& what) {
    return Error{"\"" + wire::printable(file.string(), 1024) + "\": " + what};
  };
  std::array<std::byte, kHeaderBytes> head{};
  const std::span<std::byte> begin(head.data(), std::min<uint64_t>(opened->size(), kHeaderBytes));
  if (!opened->read(0, begin)) return fault("it cannot be read");
  const Result<Extent> extent = json_extent(begin, opened->size());
  if (!extent) return fault(extent.error().message);
  if (extent->bytes > kMaxJsonBytes) {
    if (searches) return std::optional<Robot>();
    return fault("its JSON is larger than 64 MiB");
  }
  std::vector<std::byte> json(extent->bytes);
  if (!opened->read(extent->offset, json)) return fault("it cannot be read");
  constexpr std::string_view kMember = "\"robot\"";  // large scenes without it need not be parsed
  const std::string_view text(reinterpret_cast<const char*>(json.data()), json.size());
  if (text.find(kMember) == text.npos) return std::optional<Robot>();
  Result<std::optional<Robot>> robot = read_json(json, follows_mimic);
  if (!robot) return fault(robot.error().message);
  return robot;
}

}  // namespace

Result<std::optional<Robot>> find_robot(const std::filesystem::path& file, bool follows_mimic) {
  return read_file(file, follows_mimic, true);
}

Result<Robot> read_robot_file(const std::filesystem::path& file, bool follows_mimic) {
  Result<std::optional<Robot>> robot = read_file(file, follows_mimic, false);
  if (!robot) return robot.error();
  if (!*robot) return Error{"\"" + wire::printable(file.string(), 1024) + "\": " + kHoldsNone};
  return std::move(**robot);
}

}  // namespace fire3dv::robot
