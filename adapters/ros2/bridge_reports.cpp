// Messages of the bridge: faults of frames, conflicts of publishers, silence.
#include <utility>

#include "adapters/ros2/bridge.h"
#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kReportSecondNs = 1'000'000'000, kReportPatienceNs = 3 * kReportSecondNs;
constexpr size_t kMaxPublishersReported = 50;

}  // namespace

std::string Bridge::source_text(SourceId source) const {
  return source == kJointSource ? "joint states" : discovery_.publisher_text(source);
}

// With the publisher, for a frame that has one.
std::string Bridge::frame_text(FrameId id) const {
  const Frame& frame = buffer_.frames()[id];
  return quote(frame.name) + (frame.source == 0 ? "" : " of " + source_text(frame.source));
}

void Bridge::report_conflicts() {
  for (const FrameConflict& conflict : buffer_.take_conflicts()) {
    if (conflict.first == kJointSource || conflict.second == kJointSource) continue;
    log_.warn("frames with two publishers", "frame " + quote(buffer_.frames()[conflict.frame].name) +
                                                " has two publishers, " + source_text(conflict.first) +
                                                " and " + source_text(conflict.second) +
                                                ": it jumps between them");
  }
}

void Bridge::report_publishers() {
  for (const WatchedTopic& watched : watched_)
    for (const Discovery::News& news : discovery_.new_publishers(watched.topic, watched.type)) {
      if (news.is_wrong_type)
        log_.warn("types", news.text);
      else if (++publishers_reported_ <= kMaxPublishersReported)
        log_line(news.text);
    }
}

// Links without a transform stay at rest, as when robot_state_publisher is missing or the prefix is another
// one.
void Bridge::report_missing_links() {
  if (!links_ || has_reported_links_ || buffer_.frames().empty()) return;
  size_t missing = 0;
  std::string first;
  for (const std::string& name : link_frames_) {
    if (buffer_.find(name) != kNoFrame) continue;
    if (missing++ == 0) first = name;
  }
  if (missing == 0) return;
  has_reported_links_ = true;
  log_line(warning(std::to_string(missing) + " of " + counted(link_frames_.size(), "link") +
                   " of the robot, such as " + quote(first) +
                   ", have no transform and stay where they are: is robot_state_publisher running, and is "
                   "--frame-prefix right?"));
}

void Bridge::report_faults() {
  for (const WatchedTopic& watched : watched_) {
    if (const std::string policy = new_incompatible_policy(watched.reader); !policy.empty())
      log_.warn("quality of service", "a publisher of " + watched.topic + " has another " + policy +
                                          " than ROS 2's: nothing is received from it");
  }
  if (buffer_.structure_version() != seen_structure_) {
    seen_structure_ = buffer_.structure_version();
    structure_since_ns_ = now_ns_;
  }
  const bool patient = now_ns_ - structure_since_ns_ >= kReportPatienceNs;
  if (patient) report_missing_links();
  const std::string& wanted = options_.frames.fixed_frame;
  if (patient && !wanted.empty() && !buffer_.frames().empty() && buffer_.find(wanted) == kNoFrame) {
    if (!std::exchange(has_reported_fixed_frame_, true))
      log_line(warning("there is no frame " + quote(wanted) + " (--fixed-frame); another one is " +
                       quote(buffer_.frames().front().name)));
    return;
  }
  for (const FrameFault& fault : sampler_.new_faults(buffer_, patient)) {
    const std::string frame = "frame " + frame_text(fault.frame);
    switch (fault.kind) {
      case FrameFault::Kind::unconnected:
        log_.warn(
            "unconnected frames",
            frame + " has no path to the fixed frame " +
                (sampler_.fixed_frame() == kNoFrame ? "\"\""
                                                    : quote(buffer_.frames()[sampler_.fixed_frame()].name)) +
                ": nobody publishes a parent of " + quote(buffer_.frames()[fault.other].name));
        break;
      case FrameFault::Kind::loop:
        log_.warn("loops", frame + " is part of, or below, a loop of parents with " +
                               frame_text(fault.other) + ": it is not drawn");
        break;
      case FrameFault::Kind::other_clock:
        log_.warn("clocks", frame + " has stamps more than 10 s away from those of " +
                                (fault.other == kNoFrame ? "other frames" : frame_text(fault.other)) +
                                ": are there two clocks (use_sim_time)? Its newest transform is shown");
        break;
      case FrameFault::Kind::no_stamp:
        log_.warn("stamps", frame + " has the stamp 0: its newest transform is shown");
        break;
    }
  }
}

void Bridge::report_silence() {
  const bool is_heard = last_transform_ns_ != 0;
  const int64_t silent_ns = now_ns_ - (is_heard ? last_transform_ns_ : begun_ns_);
  if (silent_ns < kReportPatienceNs) {
    has_reported_silence_ = false;
    return;
  }
  if (std::exchange(has_reported_silence_, true)) return;
  if (is_heard) {
    // Static frames alone are silent for good.
    for (const Frame& frame : buffer_.frames())
      if (frame.is_stamped()) {
        log_line("no transform for 3 s: the last poses stay");
        return;
      }
    return;
  }
  log_line(warning("no transform was received for 3 s in " + domain_text(participant_->settings()) + "; " +
                   discovery_.summary() +
                   ". Check --domain, ROS_DOMAIN_ID and the discovery range of both sides; rmw_zenoh is not "
                   "DDS and cannot be received"));
}

}  // namespace fire3dv::ros2
