// Bridge from ROS 2 to renderers: /tf, /clock, joint_states, robot_description. One thread; DDS has its own.
// More than 60 members: it holds one part for each topic and passes what one learns to the others.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "adapters/ros2/dds/discovery.h"
#include "adapters/ros2/dds/participant.h"
#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/images/image_output.h"
#include "adapters/ros2/limited_log.h"
#include "adapters/ros2/markers/marker_input.h"
#include "adapters/ros2/options.h"
#include "adapters/ros2/renderers.h"
#include "adapters/ros2/robot/conversion.h"
#include "adapters/ros2/robot/joint_scalars.h"
#include "adapters/ros2/robot/robot_links.h"
#include "adapters/ros2/tf/clock_watch.h"
#include "adapters/ros2/tf/frames.h"
#include "adapters/ros2/tf/pose_sampler.h"

namespace fire3dv::ros2 {

// Source of frames that are computed from joint states. Handles of publishers are random.
constexpr SourceId kJointSource = 1;

inline int64_t stamp_ns(const builtin_interfaces_msg_dds__Time_& time) {
  return int64_t{time.sec} * 1'000'000'000 + int64_t{time.nanosec};
}
inline const char* text_of(const char* text) {
  return text ? text : "";
}

class Bridge {
 public:
  static Result<std::unique_ptr<Bridge>> open(Options options, DomainSettings settings);

  // Returns when `stop` is set, or with an error of the link to a renderer.
  Result<void> run(const std::atomic<bool>& stop);

 private:
  struct Readers {
    Reader<TfMessage> tf, tf_static;
    Reader<ClockMessage> clock;
    Reader<JointStateMessage> joint_states;
    Reader<StringMessage> description;
  };

  Bridge(Options options, std::unique_ptr<Participant> participant, Discovery discovery, Readers readers,
         Entity waitset, Renderers renderers);
  static Result<Readers> open_readers(const Participant& participant, const Options& options);

  void watch(std::vector<WatchedTopic> topics);
  std::string description_topic() const { return options_.names.resolve("robot_description"); }
  void take_messages();
  void take_transforms(const TfMessage& message, bool is_static, SourceId source);
  bool insert_all(const TfMessage& message, bool is_static, SourceId source);
  void take_clock(const ClockMessage& message, SourceId source);
  void take_joint_state(const JointStateMessage& message);
  void show_joint_state(const JointStateMessage& message);
  bool waits_for_description() const;
  void take_description(const char* text);
  void start_conversion();
  void insert_link_poses(int64_t stamp_ns);
  void choose_source_of_links();
  void restart(const std::string& reason);
  Result<void> poll_conversion();
  Result<void> use_robot(ConvertedRobot&& robot);
  Result<void> publish();
  Result<void> open_images();
  void poll_images();
  Result<void> open_markers();
  void take_markers();
  std::chrono::milliseconds wait_time() const;
  std::vector<Pose> offsets(const std::vector<std::string>& names) const;
  Result<void> look_around();  // ten times a second
  void report_publishers();
  void report_missing_links();
  void report_faults();  // once a second
  void report_conflicts();
  void report_silence();
  std::string source_text(SourceId source) const;
  std::string frame_text(FrameId frame) const;

  Options options_;
  std::unique_ptr<Participant> participant_;
  Discovery discovery_;
  Readers readers_;
  Entity waitset_;
  std::vector<WatchedTopic> watched_;
  Renderers renderers_;
  LimitedLog log_;

  FrameBuffer buffer_;
  PoseSampler sampler_;
  ClockWatch clock_;
  int64_t now_ns_ = 0, begun_ns_ = 0;
  int64_t next_look_ns_ = 0, next_report_ns_ = 0;
  int64_t last_transform_ns_ = 0, last_restart_ns_ = 0;
  size_t publishers_reported_ = 0;
  uint64_t seen_structure_ = 0;
  int64_t structure_since_ns_ = 0;
  bool has_reported_silence_ = false, has_reported_fixed_frame_ = false, has_reported_links_ = false;

  std::unique_ptr<ImageOutput> images_;   // null: no cameras
  std::unique_ptr<MarkerInput> markers_;  // null: no topics
  FrameTree marker_tree_;

  std::string description_;          // last text
  bool is_description_new_ = false;  // not converted yet
  int64_t next_conversion_ns_ = 0;
  std::optional<Conversion> conversion_;
  std::optional<RobotLinks> links_;
  std::vector<std::string> link_frames_;  // of links_, with the prefix
  int64_t first_joint_ns_ = 0;
  bool uses_joints_ = false;
  JointScalars joint_scalars_;
};

}  // namespace fire3dv::ros2
