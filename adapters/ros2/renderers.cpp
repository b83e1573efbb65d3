#include "adapters/ros2/renderers.h"

#include <fire3dv/scalars.h>

#include <algorithm>
#include <utility>

#include "adapters/generic/call_client.h"
#include "adapters/ros2/robot/node_paths.h"
#include "base/log.h"
#include "base/plural.h"

namespace fire3dv::ros2 {
namespace {

constexpr char kRobotNode[] = "robot_description";
constexpr char kRemedy[] =
    "; it is not sent: write it to a file (--write-scene), and give that to the renderer";
// A message that a later one replaces is not reported: the nodes of an added robot are missing until it is
// loaded.
constexpr std::chrono::seconds kSettled{1}, kLoaded{5};

// ROS is Z up, the renderer's world Y up.
const std::vector<double> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};

}  // namespace

Result<Renderers> Renderers::open(const std::vector<std::string>& uris, const Security& security,
                                  size_t scene_budget_bytes) {
  Renderers renderers;
  renderers.scene_budget_bytes_ = scene_budget_bytes;
  for (const std::string& uri : uris) {
    const Result<void> opened = call_client("cannot publish to", uri, [&] {
      renderers.targets_.push_back({uri, Stream(uri, "ros2", security, scene_budget_bytes)});
    });
    if (!opened) return opened.error();
  }
  return renderers;
}

Result<void> Renderers::describe(std::vector<std::string> names, std::vector<Pose> offsets) {
  names_ = std::move(names);
  offsets_ = std::move(offsets);
  last_poses_.clear();
  is_described_ = true;
  for (Target& target : targets_)
    if (Result<void> described = describe_or_drop_robot(target); !described) return described;
  return {};
}

// The paths of its nodes may be too long.
Result<void> Renderers::describe_or_drop_robot(Target& target) {
  Result<void> described = describe(target);
  if (described || !target.has_robot) return described;
  drop_robot(target, described.error().message);
  return describe(target);
}

// Nodes of an added asset have paths only.
std::string Renderers::name_in_scene(const Target& target, const std::string& node) const {
  const auto path = robot_paths_.find(node);
  if (!target.has_robot || path == robot_paths_.end()) return node;
  return kRobotNode + ("/" + path->second);
}

Result<void> Renderers::describe(Target& target) {
  Description description;
  description.node_names = names_;
  description.body_from_node = offsets_;
  description.world_from_stream = kWorldFromStream;
  for (std::string& name : description.node_names) name = name_in_scene(target, name);
  target.message.clear();
  return call_client("cannot describe the frames to", target.uri,
                     [&] { target.stream.describe(description); });
}

Result<void> Renderers::publish(int64_t time_ns, const std::vector<Pose>& poses, bool is_discontinuity) {
  for (Target& target : targets_) {
    const Result<void> sent = call_client("cannot publish to", target.uri, [&] {
      target.stream.publish(std::chrono::nanoseconds(time_ns), poses,
                            is_discontinuity ? FIRE3DV_FRAME_DISCONTINUITY : 0);
    });
    if (!sent) return sent;
    ++target.frames_published;
  }
  last_poses_ = poses;
  last_time_ns_ = time_ns;
  return {};
}

Result<void> Renderers::set_robot(std::vector<uint8_t> glb) {
  if (glb.size() > scene_budget_bytes_) {
    targets_.front().warning = "the robot has " + std::to_string(glb.size()) +
                               " bytes, and a stream at most " + std::to_string(scene_budget_bytes_) +
                               kRemedy;
    glb.clear();
  }
  robot_ = std::move(glb);
  robot_paths_ = node_paths(robot_);
  for (Target& target : targets_) {
    target.is_robot_refused = false;
    if (target.has_robot)
      if (Result<void> offered = offer_robot(target); !offered) return offered;
  }
  return {};
}

// The light that the converter gives a robot is not for a scene with lights of its own.
Result<void> Renderers::add_robot(Target& target) {
  return call_client("cannot send the robot to", target.uri, [&] {
    fire3dv_node node{};
    node.asset_glb = robot_.data();
    node.asset_glb_bytes = robot_.size();
    target.stream.add_node(kRobotNode, node);
    if (const auto light = robot_paths_.find("light from above"); light != robot_paths_.end())
      target.stream.remove_node(kRobotNode + ("/" + light->second));
  });
}

void Renderers::drop_robot(Target& target, const std::string& reason) {
  target.has_robot = false;
  target.is_robot_refused = true;
  if (!reason.empty()) target.warning = reason + kRemedy;
  (void)call_client("cannot remove the robot from", target.uri,
                    [&] { target.stream.clear(kRobotNode, FIRE3DV_PROPERTY_NODE); });
}

Result<void> Renderers::offer_robot(Target& target) {
  if (robot_.empty()) {
    drop_robot(target, "");
  } else {
    const Result<void> added = add_robot(target);
    target.has_robot = added.ok();
    if (!added) drop_robot(target, added.error().message);
  }
  if (!is_described_) return {};
  const Result<void> described = describe_or_drop_robot(target);
  return described ? repeat_frame(target) : described;
}

Result<void> Renderers::repeat_frame(Target& target) {
  if (last_poses_.empty() || !last_time_ns_) return {};
  return call_client("cannot publish to", target.uri,
                     [&] { target.stream.publish(std::chrono::nanoseconds(*last_time_ns_), last_poses_); });
}

Result<void> Renderers::show_marker(const std::string& name, const fire3dv_marker* marker) {
  for (const Target& target : targets_) {
    fire3dv_stream* const stream = target.stream.get();
    const int code = marker ? fire3dv_set_marker(stream, name.c_str(), marker)
                            : fire3dv_clear_marker(stream, name.c_str());
    if (code != FIRE3DV_OK) return Error{fire3dv_last_error()};
  }
  return {};
}

Result<void> Renderers::show_scalars(ScalarGroup& group) {
  std::vector<const char*> names, units;
  if (!group.is_declared) {
    for (const std::string& name : group.names) names.push_back(name.c_str());
    for (const std::string& unit : group.units) units.push_back(unit.c_str());
  }
  const fire3dv_scalars scalars{sizeof scalars, names.data(), units.data(), names.size()};
  Result<void> result;
  bool is_declared = group.is_declared;
  for (const Target& target : targets_) {  // a target that fails keeps nothing from the others
    fire3dv_stream* const stream = target.stream.get();
    if ((group.is_declared || fire3dv_declare_scalars(stream, group.name.c_str(), &scalars) == FIRE3DV_OK) &&
        fire3dv_set_scalars(stream, group.name.c_str(), group.time_ns, group.values.data(),
                            group.values.size()) == FIRE3DV_OK) {
      is_declared = true;
    } else if (result) {
      result = Error{fire3dv_last_error()};
    }
  }
  group.is_declared = is_declared;
  return result;
}

Result<void> Renderers::poll(const std::function<void(const std::string&)>& log) {
  const auto now = std::chrono::steady_clock::now();
  for (Target& target : targets_) {
    fire3dv_status status{};
    const Result<void> polled =
        call_client("cannot poll", target.uri, [&] { status = target.stream.poll(); });
    if (!polled) return polled;
    // Frames that stand still are not sent again and again; a renderer that comes later needs one.
    if (status.renderers > target.renderers)
      if (Result<void> sent = repeat_frame(target); !sent) return sent;
    target.renderers = status.renderers;
    if (!robot_.empty() && !target.has_robot && !target.is_robot_refused && status.welcome == 0 &&
        2 * size_t{status.unmatched_names} > names_.size()) {
      if (Result<void> offered = offer_robot(target); !offered) return offered;
      if (target.has_robot) {
        log("the robot was sent to " + target.uri + ", whose scene does not have it");
        continue;
      }
    }
    if (!target.warning.empty()) log(warning(std::exchange(target.warning, {})));
    if (target.message != status.welcome_message) {
      target.message = status.welcome_message;
      target.message_since = now;
    } else if (!target.message.empty() && target.message != target.reported &&
               now - target.message_since >= (target.has_robot ? kLoaded : kSettled)) {
      target.reported = target.message;
      log(target.uri + ": " + target.message);
    }
  }
  return {};
}

void Renderers::log_result(const std::function<void(const std::string&)>& log) const {
  for (const Target& target : targets_) {
    log(target.uri + ": " + counted(target.frames_published, "frame") + " published");
  }
}

}  // namespace fire3dv::ros2
