// C entry points of joints.h.
#include "fire3dv/joints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "call.h"
#include "fire3dv/scalars.h"
#include "protocol/robot/robot.h"
#include "protocol/robot/robot_file.h"
#include "protocol/wire/check.h"
#include "stream.h"

using fire3dv::client::fail;
using fire3dv::client::guarded;
using fire3dv::robot::JointType;
using fire3dv::robot::Robot;
using fire3dv::robot::RobotJoint;

struct fire3dv_robot {
  Robot robot;
  std::vector<const char*> node_names;  // of the robot, for descriptions
  std::vector<float> published;         // poses of the last frame
  // Positions that are scalars, and their declarations by stream and group. Streams may be gone: each use
  // compares with what the stream has.
  struct Scalar {
    size_t position;
    std::string name;
    const char* unit;
  };
  std::vector<Scalar> scalars;
  std::map<std::pair<const fire3dv_stream*, std::string>, uint64_t> scalar_declarations;
  mutable std::recursive_mutex mutex;  // held during each call; before that of a stream
};

namespace {

constexpr uint32_t kRobotFlags = FIRE3DV_ROBOT_NO_MIMIC;
constexpr uint32_t kPositionFlags = FIRE3DV_POSITIONS_CLAMP | FIRE3DV_POSITIONS_WXYZ;
constexpr double kMaxBaseNumber = 1e12;
static_assert(FIRE3DV_JOINT_FIXED == static_cast<int>(JointType::fixed) &&
              FIRE3DV_JOINT_REVOLUTE == static_cast<int>(JointType::revolute) &&
              FIRE3DV_JOINT_PRISMATIC == static_cast<int>(JointType::prismatic) &&
              FIRE3DV_JOINT_PLANAR == static_cast<int>(JointType::planar) &&
              FIRE3DV_JOINT_BALL == static_cast<int>(JointType::ball) &&
              FIRE3DV_JOINT_FLOATING == static_cast<int>(JointType::floating));

fire3dv::robot::PositionRules rules_of(uint32_t flags) {
  return {.clamps = (flags & FIRE3DV_POSITIONS_CLAMP) != 0, .is_wxyz = (flags & FIRE3DV_POSITIONS_WXYZ) != 0};
}

int fail_null(const char* name) {
  return fail(FIRE3DV_ERROR_ARGUMENT, std::string(name) + " is NULL");
}

int fail_count(const char* name, size_t given, size_t needed) {
  return fail(FIRE3DV_ERROR_ARGUMENT, std::string(name) + " is " + std::to_string(given) + "; " +
                                          std::to_string(needed) + " is needed");
}

int fail_flags(uint32_t flags, const char* known) {
  return fail(FIRE3DV_ERROR_ARGUMENT,
              "flags is " + std::to_string(flags) + "; only " + known + " bits may be set");
}

int finish(const fire3dv::Result<void>& done) {
  return done ? int{FIRE3DV_OK} : fail(FIRE3DV_ERROR_ARGUMENT, done.error().message);
}

std::vector<fire3dv_robot::Scalar> scalars_of(const Robot& robot) {
  std::vector<fire3dv_robot::Scalar> scalars;
  for (const RobotJoint& joint : robot.joints()) {
    if (joint.position_count == 0) continue;
    const auto add = [&](size_t number, const char* suffix, const char* unit) {
      scalars.push_back({joint.position_index + number, joint.name + suffix, unit});
    };
    switch (joint.type) {
      case JointType::revolute:
        add(0, "", "rad");
        break;
      case JointType::prismatic:
        add(0, "", "m");
        break;
      case JointType::planar:
        add(0, "/x", "m");
        add(1, "/y", "m");
        add(2, "/angle", "rad");
        break;
      case JointType::floating:
        add(0, "/x", "m");
        add(1, "/y", "m");
        add(2, "/z", "m");
        break;
      case JointType::ball:
      case JointType::fixed:
        break;
    }
  }
  return scalars;
}

int set_joint_scalars(fire3dv_stream* stream, fire3dv_robot* robot, const char* group, int64_t sim_time_ns) {
  if (robot->scalars.empty()) return FIRE3DV_OK;
  const std::string name = group ? group : "joint_positions";
  constexpr size_t kMaxDeclarations = 1024;  // more than anybody needs
  const auto known = stream->scalar_groups.find(name);
  const auto ours = robot->scalar_declarations.find({stream, name});
  const bool is_declared = known != stream->scalar_groups.end() && ours != robot->scalar_declarations.end() &&
                           known->second.declaration == ours->second;
  if (!is_declared) {
    std::vector<const char*> names, units;
    for (const fire3dv_robot::Scalar& scalar : robot->scalars) {
      names.push_back(scalar.name.c_str());
      units.push_back(scalar.unit);
    }
    const fire3dv_scalars declaration{sizeof declaration, names.data(), units.data(), names.size()};
    if (const int code = fire3dv_declare_scalars(stream, name.c_str(), &declaration)) return code;
    if (robot->scalar_declarations.size() >= kMaxDeclarations) robot->scalar_declarations.clear();
    robot->scalar_declarations[{stream, name}] = stream->scalar_groups.at(name).declaration;
  }
  std::vector<double> values;
  for (const fire3dv_robot::Scalar& scalar : robot->scalars)
    values.push_back(robot->robot.positions()[scalar.position]);
  return fire3dv_set_scalars(stream, name.c_str(), sim_time_ns, values.data(), values.size());
}

// guarded() for functions of a robot.
template <typename Body>
int guarded_robot(const fire3dv_robot* robot, Body&& body) noexcept {
  if (!robot) return fail_null("robot");
  return guarded([&] {
    const std::lock_guard lock(robot->mutex);
    return int{std::forward<Body>(body)()};
  });
}

template <typename Read>
fire3dv_robot* open(uint32_t flags, Read&& read) {
  fire3dv_robot* made = nullptr;
  guarded([&] {
    if ((flags & ~kRobotFlags) != 0) return fail_flags(flags, "FIRE3DV_ROBOT_*");
    fire3dv::Result<Robot> robot = read((flags & FIRE3DV_ROBOT_NO_MIMIC) == 0);
    if (!robot) return fail(FIRE3DV_ERROR_ARGUMENT, robot.error().message);
    made = new fire3dv_robot{std::move(*robot), {}, {}, {}, {}, {}};
    made->scalars = scalars_of(made->robot);
    for (const std::string& name : made->robot.node_names()) made->node_names.push_back(name.c_str());
    return int{FIRE3DV_OK};
  });
  return made;
}

int get_joint(const fire3dv_robot* robot, size_t index, fire3dv_joint* joint) {
  if (!joint) return fail_null("joint");
  if (joint->struct_size < sizeof *joint)
    return fail(FIRE3DV_ERROR_ARGUMENT, "joint.struct_size is " + std::to_string(joint->struct_size) +
                                            "; set it to sizeof(fire3dv_joint) (" +
                                            std::to_string(sizeof *joint) +
                                            " in this version of the library)");
  const std::vector<RobotJoint>& all = robot->robot.joints();
  if (index >= all.size())
    return fail(FIRE3DV_ERROR_ARGUMENT, "index is " + std::to_string(index) + "; the robot has " +
                                            std::to_string(all.size()) + " joints");
  const RobotJoint& from = all[index];
  joint->name = from.name.c_str();
  joint->node = robot->robot.bodies()[from.body].node.c_str();
  joint->type = static_cast<int32_t>(from.type);
  joint->followed_joint = from.leader ? static_cast<int32_t>(*from.leader) : -1;
  joint->multiplier = from.multiplier;
  joint->offset = from.offset;
  joint->position_index = from.position_index;
  joint->position_count = from.position_count;
  std::copy(from.axis.begin(), from.axis.end(), joint->axis);
  std::copy(from.anchor.begin(), from.anchor.end(), joint->anchor);
  joint->has_limits = from.has_limits;
  joint->lower = from.lower;
  joint->upper = from.upper;
  return FIRE3DV_OK;
}

int set_joint(fire3dv_robot* robot, size_t index, const double* positions, size_t count, uint32_t flags) {
  if (!positions && count > 0) return fail_null("positions");
  if ((flags & ~kPositionFlags) != 0) return fail_flags(flags, "FIRE3DV_POSITIONS_*");
  if (index >= robot->robot.joints().size())
    return fail(FIRE3DV_ERROR_ARGUMENT, "index is " + std::to_string(index) + "; the robot has " +
                                            std::to_string(robot->robot.joints().size()) + " joints");
  return finish(robot->robot.set_joint(index, {positions, count}, rules_of(flags)));
}

int set_positions(fire3dv_robot* robot, const double* positions, size_t count, uint32_t flags) {
  if (!positions && count > 0) return fail_null("positions");
  if ((flags & ~kPositionFlags) != 0) return fail_flags(flags, "FIRE3DV_POSITIONS_*");
  return finish(robot->robot.set_positions({positions, count}, rules_of(flags)));
}

int get_positions(const fire3dv_robot* robot, double* positions, size_t count) {
  const std::vector<double>& all = robot->robot.positions();
  if (count != all.size()) return fail_count("count", count, all.size());
  if (!positions && count > 0) return fail_null("positions");
  std::copy(all.begin(), all.end(), positions);
  return FIRE3DV_OK;
}

int set_base(fire3dv_robot* robot, const double* stream_from_model) {
  fire3dv::robot::Transform base;
  for (size_t i = 0; stream_from_model && i < base.m.size(); ++i) {
    base.m[i] = stream_from_model[i];
    if (!(std::abs(base.m[i]) <= kMaxBaseNumber))
      return fail(FIRE3DV_ERROR_ARGUMENT,
                  "stream_from_model[" + std::to_string(i) + "] is not finite, or larger than 1e12");
  }
  robot->robot.set_base(base);
  return FIRE3DV_OK;
}

int get_description(const fire3dv_robot* robot, fire3dv_description* description) {
  if (!description) return fail_null("description");
  if (description->struct_size < sizeof *description)
    return fail_count("description.struct_size", description->struct_size, sizeof *description);
  const Robot& from = robot->robot;
  description->node_names = robot->node_names.data();
  description->node_count = robot->node_names.size();
  description->world_from_stream = from.world_from_model().m.data();
  description->body_from_node = from.body_from_node().empty() ? nullptr : from.body_from_node().data();
  description->body_from_node_count = from.body_from_node().size() / 12;
  return FIRE3DV_OK;
}

int get_poses(fire3dv_robot* robot, float* stream_from_node, size_t pose_count) {
  if (pose_count != robot->node_names.size())
    return fail_count("pose_count", pose_count, robot->node_names.size());
  if (!stream_from_node && pose_count > 0) return fail_null("stream_from_node");
  robot->robot.write_poses({stream_from_node, 12 * pose_count});
  return FIRE3DV_OK;
}

int get_node_pose(fire3dv_robot* robot, const char* node, double* stream_from_node) {
  if (!node) return fail_null("node");
  if (!stream_from_node) return fail_null("stream_from_node");
  const std::optional<size_t> body = robot->robot.body_called(node);
  if (!body)
    return fail(FIRE3DV_ERROR_ARGUMENT, "the robot has no body \"" + fire3dv::wire::printable(node) + "\"");
  const auto& pose = robot->robot.poses()[*body].m;
  std::copy(pose.begin(), pose.end(), stream_from_node);
  return FIRE3DV_OK;
}

int publish(fire3dv_stream* stream, fire3dv_robot* robot, int64_t sim_time_ns, uint32_t flags) {
  const size_t count = robot->node_names.size();
  robot->published.resize(12 * count);
  robot->robot.write_poses(robot->published);
  return fire3dv_publish(stream, sim_time_ns, robot->published.data(), count, flags);
}

}  // namespace

fire3dv_robot* fire3dv_open_robot(const char* file, uint32_t flags) {
  if (!file) {
    fail_null("file");
    return nullptr;
  }
  return open(flags, [&](bool follows) { return fire3dv::robot::read_robot_file(file, follows); });
}

fire3dv_robot* fire3dv_read_robot(const void* bytes, size_t byte_count, uint32_t flags) {
  if (!bytes) {
    fail_null("bytes");
    return nullptr;
  }
  const std::span data(static_cast<const std::byte*>(bytes), byte_count);
  return open(flags, [&](bool follows) { return fire3dv::robot::read_robot(data, follows); });
}

void fire3dv_close_robot(fire3dv_robot** robot) {
  if (!robot) return;
  delete *robot;
  *robot = nullptr;
}

size_t fire3dv_joint_count(const fire3dv_robot* robot) {
  return robot ? robot->robot.joints().size() : 0;
}

size_t fire3dv_position_count(const fire3dv_robot* robot) {
  return robot ? robot->robot.positions().size() : 0;
}

int fire3dv_get_joint(const fire3dv_robot* robot, size_t index, fire3dv_joint* joint) {
  return guarded_robot(robot, [&] { return get_joint(robot, index, joint); });
}

int fire3dv_set_positions(fire3dv_robot* robot, const double* positions, size_t count, uint32_t flags) {
  return guarded_robot(robot, [&] { return set_positions(robot, positions, count, flags); });
}

int fire3dv_set_joint(fire3dv_robot* robot, size_t index, const double* positions, size_t count,
                      uint32_t flags) {
  return guarded_robot(robot, [&] { return set_joint(robot, index, positions, count, flags); });
}

int fire3dv_get_positions(const fire3dv_robot* robot, double* positions, size_t count) {
  return guarded_robot(robot, [&] { return get_positions(robot, positions, count); });
}

int fire3dv_set_base(fire3dv_robot* robot, const double* stream_from_model) {
  return guarded_robot(robot, [&] { return set_base(robot, stream_from_model); });
}

int fire3dv_get_robot_description(const fire3dv_robot* robot, fire3dv_description* description) {
  return guarded_robot(robot, [&] { return get_description(robot, description); });
}

int fire3dv_get_poses(fire3dv_robot* robot, float* stream_from_node, size_t pose_count) {
  return guarded_robot(robot, [&] { return get_poses(robot, stream_from_node, pose_count); });
}

int fire3dv_get_node_pose(fire3dv_robot* robot, const char* node, double* stream_from_node) {
  return guarded_robot(robot, [&] { return get_node_pose(robot, node, stream_from_node); });
}

int fire3dv_set_joint_scalars(fire3dv_stream* stream, fire3dv_robot* robot, const char* group,
                              int64_t sim_time_ns) {
  return guarded_robot(robot, [&] {
    return guarded(stream, [&] { return set_joint_scalars(stream, robot, group, sim_time_ns); });
  });
}

int fire3dv_publish_robot(fire3dv_stream* stream, fire3dv_robot* robot, int64_t sim_time_ns, uint32_t flags) {
  return guarded_robot(robot, [&] { return publish(stream, robot, sim_time_ns, flags); });
}
