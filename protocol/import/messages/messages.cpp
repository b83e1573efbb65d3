#include "protocol/import/messages/messages.h"

#include <algorithm>
#include <string_view>

#include "base/text.h"
#include "protocol/import/messages/cdr.h"
#include "protocol/import/messages/foxglove.h"

namespace fire3dv::imported {
namespace {

constexpr std::string_view kCdr = "cdr", kProtobuf = "protobuf", kJson = "json";

// "tf2_msgs/msg/TFMessage" and "tf2_msgs/TFMessage" are one type.
std::string without_msg(std::string type) {
  if (const size_t at = type.find("/msg/"); at != std::string::npos) type.erase(at, 4);
  return type;
}

bool is_foxglove(const std::string& type) {
  return type == "foxglove.FrameTransform" || type == "foxglove.FrameTransforms";
}

bool has_many(const std::string& type) {
  return type == "tf2_msgs/TFMessage" || type == "foxglove.FrameTransforms";
}

}  // namespace

Content content_of(const Topic& topic) {
  const std::string type = without_msg(topic.type);
  if (type == "tf2_msgs/TFMessage" || type == "geometry_msgs/TransformStamped" || is_foxglove(type))
    return Content::transforms;
  return type == "sensor_msgs/JointState" ? Content::joint_states : Content::other;
}

Result<void> check_encoding(const Topic& topic) {
  const bool is_read = is_foxglove(topic.type) ? topic.encoding == kProtobuf || topic.encoding == kJson
                                               : topic.encoding == kCdr;
  if (is_read) return {};
  return Error{
      "topic " + quote(topic.name) + ": messages of " + quote(topic.type) + " in " + quote(topic.encoding) +
      " cannot be read; " +
      (is_foxglove(topic.type) ? "record them as protobuf or json" : "record them by ROS 2, as cdr")};
}

Result<void> decode(const Topic& topic, std::span<const std::byte> message,
                    std::vector<TransformSample>& samples) {
  samples.clear();
  const bool many = has_many(without_msg(topic.type));
  if (topic.encoding == kCdr) return decode_cdr_transforms(message, many, samples);
  if (topic.encoding == kJson) return decode_json_transforms(message, many, samples);
  return decode_protobuf_transforms(message, many, samples);
}

Result<void> decode(const Topic&, std::span<const std::byte> message, JointState& state) {
  return decode_cdr_joint_state(message, state);
}

}  // namespace fire3dv::imported
