// ROS 2 messages in CDR (OMG's Common Data Representation, XCDR version 1), of either byte order:
// tf2_msgs/TFMessage, geometry_msgs/TransformStamped and sensor_msgs/JointState.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/error.h"
#include "protocol/import/messages/messages.h"

namespace fire3dv::imported {

// many: the message is a list of transforms.
Result<void> decode_cdr_transforms(std::span<const std::byte> message, bool many,
                                   std::vector<TransformSample>& samples);
Result<void> decode_cdr_joint_state(std::span<const std::byte> message, JointState& state);

}  // namespace fire3dv::imported
