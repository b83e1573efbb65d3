// The robot of the bridge: its description, and link poses from joint states.
#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include "adapters/ros2/bridge.h"
#include "base/files.h"
#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kRobotSecondNs = 1'000'000'000;
constexpr size_t kMaxDescriptionBytes = size_t{64} << 20;

}  // namespace

// A stamp of 0 is none: the values belong to the newest poses.
void Bridge::show_joint_state(const JointStateMessage& message) {
  if (!options_.shows_joints || waits_for_description()) return;
  int64_t stamp = stamp_ns(message.header.stamp);
  if (stamp == 0 && !renderers_.published_time_ns()) return;
  if (stamp == 0) stamp = *renderers_.published_time_ns();
  std::vector<std::string_view> names;
  for (uint32_t i = 0; i < message.name._length; ++i) names.emplace_back(text_of(message.name._buffer[i]));
  const auto numbers = [](const auto& sequence) {
    return std::span<const double>(sequence._buffer, sequence._length);
  };
  const Result<std::vector<ScalarGroup*>> groups = joint_scalars_.take(
      {names, numbers(message.position), numbers(message.velocity), numbers(message.effort), stamp});
  if (!groups) return log_.warn("joint scalars", "joint states are not plotted: " + groups.error().message);
  for (ScalarGroup* const group : *groups) {
    const Result<void> shown = renderers_.show_scalars(*group);
    group->is_refused = !shown && !group->is_declared;
    if (!shown)
      log_.warn("joint scalars", group->name + " of joint states are not plotted: " + shown.error().message);
  }
}

void Bridge::take_joint_state(const JointStateMessage& message) {
  show_joint_state(message);
  if (!links_) return;
  const uint32_t count = std::min(message.name._length, message.position._length);
  bool has_changed = false;
  for (uint32_t i = 0; i < count; ++i)
    has_changed |= links_->set_joint(text_of(message.name._buffer[i]), message.position._buffer[i]);
  if (!has_changed) return;
  if (first_joint_ns_ == 0) first_joint_ns_ = now_ns_;
  if (uses_joints_) insert_link_poses(stamp_ns(message.header.stamp));
}

void Bridge::insert_link_poses(int64_t stamp) {
  const Result<std::vector<Transform>> transforms = links_->root_from_links();
  if (!transforms) {
    log_.warn("joint states", transforms.error().message);
    return;
  }
  last_transform_ns_ = now_ns_;
  for (size_t i = 0; i < transforms->size(); ++i)
    buffer_.insert(link_frames_[0], link_frames_[i + 1], stamp, (*transforms)[i], false, kJointSource,
                   now_ns_);
  if (buffer_.has_jumped_back(now_ns_)) restart("the stamps of joint states");
}

// Joint states count as long as nobody publishes a link as a frame. The root is another matter: odometry
// moves it.
void Bridge::choose_source_of_links() {
  if (!links_ || first_joint_ns_ == 0) return;
  const auto is_on_tf = [&](const std::string& name) {
    const FrameId id = buffer_.find(name);
    if (id == kNoFrame || buffer_.frames()[id].is_root()) return false;
    const Frame& frame = buffer_.frames()[id];
    return frame.source != kJointSource || (frame.other_source != 0 && frame.other_source != kJointSource);
  };
  const bool tf_has_links = std::any_of(link_frames_.begin() + 1, link_frames_.end(), is_on_tf);
  if (tf_has_links && std::exchange(uses_joints_, false)) {
    log_line("the robot's links are published on /tf now: joint states are not used");
    buffer_.remove_source(kJointSource);
  }
  if (!tf_has_links && !uses_joints_ && now_ns_ - first_joint_ns_ > kRobotSecondNs) {
    log_line("no link of the robot is published on /tf: its poses are computed from joint states");
    uses_joints_ = true;
  }
}

void Bridge::take_description(const char* text) {
  if (description_ == text) return;
  description_ = text;
  if (description_.size() > kMaxDescriptionBytes) {
    log_.warn("robot descriptions", description_topic() + " is longer than 64 MiB and not read");
    return;
  }
  if (images_) images_->set_description(description_);
  is_description_new_ = true;
}

// The newest description, not each: two publishers may alternate.
void Bridge::start_conversion() {
  if (conversion_ || !is_description_new_ || now_ns_ < next_conversion_ns_) return;
  is_description_new_ = false;
  next_conversion_ns_ = now_ns_ + 2 * kRobotSecondNs;
  Result<Conversion> started = Conversion::start(description_, options_.package_folders, description_topic());
  if (started)
    conversion_ = std::move(*started);
  else
    log_line(error_line(started.error().message));
}

Result<void> Bridge::poll_conversion() {
  start_conversion();
  if (!conversion_) return {};
  std::optional<Result<ConvertedRobot>> converted = conversion_->poll();
  if (!converted) return {};
  conversion_.reset();
  if (!*converted) {
    log_line(error_line((*converted).error().message));
    return {};
  }
  return use_robot(std::move(**converted));
}

Result<void> Bridge::use_robot(ConvertedRobot&& robot) {
  for (const std::string& text : robot.warnings) log_line(warning(text));
  if (uses_joints_) buffer_.remove_source(kJointSource);
  uses_joints_ = false;
  first_joint_ns_ = 0;
  has_reported_links_ = false;
  link_frames_.clear();
  if (Result<RobotLinks> links = RobotLinks::read(robot.glb)) {
    links_ = std::move(*links);
    for (const std::string& name : links_->names())
      link_frames_.push_back(options_.frames.frame_prefix + name);
    sampler_.set_links(links_->names());
    joint_scalars_.set_joint_types(links_->joint_types());
    log_line("the robot has " + counted(links_->names().size(), "link"));
  } else {
    links_.reset();
    joint_scalars_.set_joint_types({});
    sampler_.set_links(std::nullopt);
    log_line("the robot has no joints: the poses of all frames are sent");
  }
  if (options_.scene_file.empty()) {
    if (Result<void> sent = renderers_.set_robot(std::move(robot.glb)); !sent) return sent;
  } else {
    if (Result<void> written = write_whole_file(options_.scene_file, robot.glb); !written)
      log_.warn("--write-scene", written.error().message +
                                     "; poses go on, and the next robot description is "
                                     "tried again");
    else
      log_line("wrote " + options_.scene_file + "; to draw it: fire3dv " + options_.scene_file +
               " --listen " + options_.uris.front());
  }
  // Without poses the robot is shown, too, at rest.
  if (renderers_.is_described() || !links_) return {};
  return renderers_.describe(links_->names(), offsets(links_->names()));
}

std::vector<Pose> Bridge::offsets(const std::vector<std::string>& names) const {
  std::vector<Pose> offsets;
  if (!links_ || !links_->body_from_node(links_->names().front())) return offsets;
  for (const std::string& name : names) {
    const Pose* offset = links_->body_from_node(name);
    offsets.push_back(offset ? *offset : Pose{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  }
  return offsets;
}

}  // namespace fire3dv::ros2
