#include "tests/unit/adapters/ros2/tf/tf2_oracle.h"

#include <console_bridge/console.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>

namespace fire3dv::ros2 {

struct Tf2Oracle::Buffer {
  tf2::BufferCore core{ros::Duration(10)};
};

Tf2Oracle::Tf2Oracle() : buffer_(std::make_unique<Buffer>()) {
  console_bridge::setLogLevel(console_bridge::CONSOLE_BRIDGE_LOG_NONE);  // tests insert what it warns of
}
Tf2Oracle::~Tf2Oracle() = default;

bool Tf2Oracle::set(const std::string& parent, const std::string& child, int64_t stamp_ns,
                    const std::array<double, 3>& translation, const std::array<double, 4>& rotation,
                    bool is_static) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.header.stamp.fromNSec(static_cast<uint64_t>(stamp_ns));
  message.transform.translation.x = translation[0];
  message.transform.translation.y = translation[1];
  message.transform.translation.z = translation[2];
  message.transform.rotation.x = rotation[0];
  message.transform.rotation.y = rotation[1];
  message.transform.rotation.z = rotation[2];
  message.transform.rotation.w = rotation[3];
  return buffer_->core.setTransform(message, "test", is_static);
}

std::optional<Tf2Oracle::Result> Tf2Oracle::look_up(const std::string& target, const std::string& source,
                                                    int64_t stamp_ns) const {
  try {
    const geometry_msgs::TransformStamped found =
        buffer_->core.lookupTransform(target, source, ros::Time().fromNSec(static_cast<uint64_t>(stamp_ns)));
    const auto& t = found.transform;
    return Result{static_cast<int64_t>(found.header.stamp.toNSec()),
                  {t.translation.x, t.translation.y, t.translation.z},
                  {t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w}};
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

}  // namespace fire3dv::ros2
