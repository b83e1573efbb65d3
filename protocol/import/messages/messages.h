// Transforms and joint states of messages of other programs, and their decoders: ROS 2's CDR, Foxglove's
// Protocol Buffers and JSON. Messages are untrusted: lengths and types are checked, values are not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/frames/transform.h"

namespace fire3dv::imported {

// Topic of a file. type: name of the schema, as in the file. encoding: of its messages, such as "cdr".
struct Topic {
  std::string name, type, encoding;
};

// Transforms or joints of one message; more are an error. Bounds the memory, which is many times that of the
// message.
constexpr size_t kMaxElements = 65'536;

enum class Content : uint8_t { other, transforms, joint_states };

// stamp_ns: time of the message's header; 0: none.
struct TransformSample {
  std::string parent, child;
  int64_t stamp_ns = 0;
  frames::Transform parent_from_child;
};

// Positions in radians and metres, one for each name.
struct JointState {
  int64_t stamp_ns = 0;
  std::vector<std::string> names;
  std::vector<double> positions;  // empty: velocities or efforts alone
};

// By the name of the type alone.
Content content_of(const Topic& topic);
// Fails for a topic of transforms or joint states whose encoding has no decoder.
Result<void> check_encoding(const Topic& topic);

// Replace the contents of `samples` and `state`. The error says what is wrong within the message. For topics
// of that content that check_encoding() accepts.
Result<void> decode(const Topic& topic, std::span<const std::byte> message,
                    std::vector<TransformSample>& samples);
Result<void> decode(const Topic& topic, std::span<const std::byte> message, JointState& state);

}  // namespace fire3dv::imported
