// Protocol messages as plain C++ structs. protocol/SPEC.md is normative.
// A matrix `a_from_b` maps coordinates of frame b to frame a. Matrices are 3x4, row-major, in metres and
// radians unless world_from_stream defines another unit. Times are nanoseconds.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "protocol/wire/affine.h"
#include "protocol/wire/image.h"
#include "protocol/wire/input.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::wire {

constexpr uint16_t kProtocolMajor = 1;   // peers with different majors refuse each other, with a reply
constexpr uint16_t kProtocolMinor = 10;  // peers with different minors interoperate

// Relation of the publisher's clocks, for ordering its frames against other clocks.
struct ClockInfo {
  std::string boot_id;                // equal boot ids: publish times share one monotonic clock
  uint64_t monotonic_at_open_ns = 0;  // read together with realtime_at_open_ns when the stream was opened
  int64_t realtime_at_open_ns = 0;    // Unix time
  double sim_seconds_per_second = 0;  // nominal, 0 = unknown
  bool operator==(const ClockInfo&) const = default;
};

// Stream metadata: everything except the poses.
struct StreamDescription {
  uint16_t protocol_major = kProtocolMajor;
  uint16_t protocol_minor = kProtocolMinor;
  std::string adapter_name;               // for the user: "bullet_arm", "ambf"
  uint64_t epoch = 0;                     // random id of this run of the stream, never 0
  std::vector<std::string> node_names;    // pose i moves node_names[i]; UTF-8, unique
  Affine3x4d world_from_stream;           // basis and unit of the whole stream
  std::vector<Affine3x4> body_from_node;  // empty: identity; one: for all nodes; otherwise one per node
  double nominal_rate_hz = 0;             // 0 = unknown
  std::string scene_uri;                  // the adapter's assumed scene; a hint, never fetched automatically
  ClockInfo clock;
  bool operator==(const StreamDescription&) const = default;
};

enum PoseFrameFlags : uint32_t {
  kFrameDiscontinuity = 1u << 0,  // sim time or bodies jumped: do not interpolate into this frame
};

struct PoseFrameHeader {
  uint64_t epoch = 0;
  uint64_t sequence = 0;  // starts at 1, +1 for each published frame of the epoch
  int64_t sim_time_ns = 0;
  uint64_t publish_time_ns = 0;  // publisher's CLOCK_MONOTONIC
  uint64_t scene_version = 0;    // the frame is displayed only with this version of the scene edits
  uint32_t flags = 0;            // PoseFrameFlags
  bool operator==(const PoseFrameHeader&) const = default;
};

// Poses [first_node, first_node + poses.size()) of a frame of node_count nodes. A frame in one message has
// first_node 0 and poses.size() == node_count; datagram links split it into parts. The spans refer to memory
// of the decoder or the caller.
struct PoseFrameView {
  PoseFrameHeader header;
  uint32_t node_count = 0;
  uint32_t first_node = 0;
  std::span<const Affine3x4> poses;  // stream_from_body
  // Non-empty: partial frame. poses[i] belongs to node node_indices[i]; the other nodes keep their poses of
  // the previous frame.
  std::span<const uint32_t> node_indices = {};
};

// Renderer to adapter: reply to a StreamDescription.
enum class WelcomeStatus : uint8_t {
  accepted = 0,
  version_mismatch = 1,
  bad_description = 2,
  refused = 3,
  bad_key = 4
};
struct Welcome {
  WelcomeStatus status = WelcomeStatus::accepted;
  uint16_t protocol_major = kProtocolMajor;  // of the replying side
  uint16_t protocol_minor = kProtocolMinor;
  uint64_t epoch = 0;  // of the described stream
  std::string renderer_name;
  std::string message;                         // for the user, one line
  std::vector<std::string> unmatched_names;    // node names without a scene node
  std::vector<std::string> conflicting_names;  // node names that another stream already drives
  bool operator==(const Welcome&) const = default;
};

// Renderer to adapter: the newest finished image shows this frame.
struct Ack {
  uint64_t epoch = 0;
  uint64_t sequence = 0;
  bool operator==(const Ack&) const = default;
};

// Both directions. Pong repeats the fields of Ping and adds the replying side's clock.
struct Ping {
  uint64_t id = 0;
  uint64_t sender_time_ns = 0;
  bool operator==(const Ping&) const = default;
};
struct Pong {
  uint64_t id = 0;
  uint64_t ping_sender_time_ns = 0;
  uint64_t answer_time_ns = 0;
  bool operator==(const Pong&) const = default;
};

// Adapter to renderer: orderly end of the stream; its nodes are released.
struct Goodbye {
  uint64_t epoch = 0;
  bool operator==(const Goodbye&) const = default;
};

// Renderer to adapter, on every change: state relative to other streams.
struct Status {
  uint64_t epoch = 0;                        // of the receiving stream
  std::vector<std::string> contested_names;  // its nodes that another stream requests in vain
  std::string message;                       // for the user, one line
  bool operator==(const Status&) const = default;
};

// Well-formed message of an unknown kind of a later minor version: ignored without a count or a warning.
struct UnknownMessage {
  uint8_t body_type = 0;
  bool operator==(const UnknownMessage&) const = default;
};

// Edit of an unknown kind of a later minor version: no effect, but its version counts as applied.
struct UnknownEdit {
  uint64_t epoch = 0;
  uint64_t version = 0;
  bool operator==(const UnknownEdit&) const = default;
};

using Message =
    std::variant<StreamDescription, PoseFrameView, Welcome, Ack, Ping, Pong, Goodbye, Status, UnknownMessage,
                 SceneEdit, UnknownEdit, ImageRequest, ImageFrame, ImageRefused, InputEvent>;

}  // namespace fire3dv::wire
