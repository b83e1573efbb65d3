#include "adapters/ros2/renderers.h"

#include <algorithm>
#include <utility>

#include "protocol/base/log.h"
#include "protocol/base/plural.h"

namespace fire3dv::ros2 {
namespace {

constexpr char kRobotNode[] = "robot_description";
constexpr size_t kSceneBudgetBytes = size_t{256} << 20;
constexpr std::chrono::seconds kSettled{1};  // a message that a later one replaces at once is not reported

// ROS is Z up, the renderer's world Y up.
const std::vector<double> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};

template <typename Call>
Result<void> call_client(const char* what, const std::string& uri, Call&& call) {
  try {
    call();
  } catch (const ClientError& error) {
    return Error{std::string(what) + " " + uri + ": " + error.what()};
  }
  return {};
}

}  // namespace

Result<Renderers> Renderers::open(const std::vector<std::string>& uris, const Security& security) {
  Renderers renderers;
  for (const std::string& uri : uris) {
    const Result<void> opened = call_client("cannot publish to", uri, [&] {
      renderers.targets_.push_back({uri, Stream(uri, "ros2", security, kSceneBudgetBytes)});
    });
    if (!opened) return opened.error();
  }
  return renderers;
}

Result<void> Renderers::describe(const std::vector<std::string>& names, const std::vector<Pose>& offsets) {
  Description description;
  description.node_names = names;
  description.body_from_node = offsets;
  description.world_from_stream = kWorldFromStream;
  for (Target& target : targets_) {
    const Result<void> described = call_client("cannot describe the frames to", target.uri,
                                               [&] { target.stream.describe(description); });
    if (!described) return described;
    target.message.clear();
  }
  name_count_ = names.size();
  last_poses_.clear();
  is_described_ = true;
  return {};
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

void Renderers::set_robot(std::vector<uint8_t> glb) {
  robot_ = std::move(glb);
  for (Target& target : targets_)
    if (std::exchange(target.has_robot, false)) {
      const Result<void> added = add_robot(target);
      if (!added) target.message = warning(added.error().message);
    }
}

Result<void> Renderers::add_robot(Target& target) {
  target.has_robot = true;  // a robot beyond the budget is not tried again
  return call_client("cannot send the robot to", target.uri, [&] {
    fire3dv_node node{};
    node.asset_glb = robot_.data();
    node.asset_glb_bytes = robot_.size();
    target.stream.add_node(kRobotNode, node);
  });
}

Result<void> Renderers::poll(const std::function<void(const std::string&)>& log) {
  const auto now = std::chrono::steady_clock::now();
  for (Target& target : targets_) {
    fire3dv_status status{};
    const Result<void> polled =
        call_client("cannot poll", target.uri, [&] { status = target.stream.poll(); });
    if (!polled) return polled;
    bool needs_frame = status.renderers > target.renderers;
    target.renderers = status.renderers;
    if (!robot_.empty() && !target.has_robot && status.welcome == 0 &&
        2 * size_t{status.unmatched_names} > name_count_) {
      if (Result<void> added = add_robot(target); !added) log(warning(added.error().message));
      else log("the robot was sent to " + target.uri + ", whose scene does not have it");
      needs_frame = true;
    }
    if (target.message != status.welcome_message) {
      target.message = status.welcome_message;
      target.message_since = now;
    } else if (!target.message.empty() && target.message != target.reported &&
               now - target.message_since >= kSettled) {
      target.reported = target.message;
      log(target.uri + ": " + target.message);
    }
    // Frames that stand still are not sent again and again; a renderer that comes later needs one.
    if (needs_frame && !last_poses_.empty()) {
      const Result<void> sent = call_client("cannot publish to", target.uri, [&] {
        target.stream.publish(std::chrono::nanoseconds(last_time_ns_), last_poses_);
      });
      if (!sent) return sent;
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
