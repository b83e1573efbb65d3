// The messages of the protocol as plain C++ values. protocol/SPEC.md is normative; this header follows it.
// Frames: a matrix `a_from_b` takes coordinates in frame b to frame a. Matrices are 3x4, row-major, metres
// and radians unless world_from_stream says otherwise. Times are nanoseconds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "protocol/wire/affine.h"
#include "protocol/wire/image.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::wire {

constexpr uint16_t kProtocolMajor = 1;  // peers with another major refuse each other, with a reply
constexpr uint16_t kProtocolMinor = 2;  // peers with another minor understand each other

// How the publisher's clocks relate, so that a reader can order its frames against other clocks.
struct ClockInfo {
  std::string boot_id;                // equal boot ids mean that publish times share one monotonic clock
  uint64_t monotonic_at_open_ns = 0;  // the pair was read together when the stream was opened
  int64_t realtime_at_open_ns = 0;    // Unix time
  double sim_seconds_per_second = 0;  // nominal, 0 = unknown
  bool operator==(const ClockInfo&) const = default;
};

// Everything a renderer needs to know of a stream but the poses.
struct StreamDescription {
  uint16_t protocol_major = kProtocolMajor;
  uint16_t protocol_minor = kProtocolMinor;
  std::string adapter_name;               // for people: "bullet_arm", "ambf"
  uint64_t epoch = 0;                     // random id of this run of the stream, never 0
  std::vector<std::string> node_names;    // pose i moves node_names[i]; UTF-8, unique
  Affine3x4d world_from_stream;           // basis and unit of the whole stream
  std::vector<Affine3x4> body_from_node;  // empty: identity; one: for all nodes; else one per node
  double nominal_rate_hz = 0;             // 0 = unknown
  std::string scene_uri;  // what the adapter believes it drives; a hint, never fetched by itself
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
  uint64_t scene_version = 0;    // the frame is shown only when this version of the scene edits is applied
  uint32_t flags = 0;            // PoseFrameFlags
  bool operator==(const PoseFrameHeader&) const = default;
};

// Poses [first_node, first_node + poses.size()) of a frame of node_count nodes. A frame that fits one message
// has first_node 0 and poses.size() == node_count; on a datagram link it arrives as several such parts. The
// spans view memory of the decoder or of the caller.
struct PoseFrameView {
  PoseFrameHeader header;
  uint32_t node_count = 0;
  uint32_t first_node = 0;
  std::span<const Affine3x4> poses;  // stream_from_body
  // Not empty: a partial frame. poses[i] is of node node_indices[i]; the other nodes are as in the frame
  // before.
  std::span<const uint32_t> node_indices = {};
};

// Renderer to adapter: the answer to a StreamDescription.
enum class WelcomeStatus : uint8_t {
  accepted = 0,
  version_mismatch = 1,
  bad_description = 2,
  refused = 3,
  bad_key = 4
};
struct Welcome {
  WelcomeStatus status = WelcomeStatus::accepted;
  uint16_t protocol_major = kProtocolMajor;  // of the side that answers
  uint16_t protocol_minor = kProtocolMinor;
  uint64_t epoch = 0;  // of the description that is answered
  std::string renderer_name;
  std::string message;                         // for people, one line
  std::vector<std::string> unmatched_names;    // node names that no scene node has
  std::vector<std::string> conflicting_names;  // node names that another stream drives already
  bool operator==(const Welcome&) const = default;
};

// Renderer to adapter: this frame is what the newest finished image shows.
struct Ack {
  uint64_t epoch = 0;
  uint64_t sequence = 0;
  bool operator==(const Ack&) const = default;
};

// Either way. Pong repeats the ping's fields and adds the answerer's clock.
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

// Adapter to renderer: the stream ends in order; its nodes are given back.
struct Goodbye {
  uint64_t epoch = 0;
  bool operator==(const Goodbye&) const = default;
};

// Renderer to adapter, whenever it changes: how the stream stands among others.
struct Status {
  uint64_t epoch = 0;  // of the stream that is told
  std::vector<std::string>
      contested_names;  // of its nodes, those that another stream asks for and does not get
  std::string message;  // for people, one line
  bool operator==(const Status&) const = default;
};

// A message of a kind that a later minor version added: well-formed, and to be ignored without a count or a
// complaint.
struct UnknownMessage {
  uint8_t body_type = 0;
  bool operator==(const UnknownMessage&) const = default;
};

// An edit of a kind that a later minor version added: it has no effect, but its version counts as applied.
struct UnknownEdit {
  uint64_t epoch = 0;
  uint64_t version = 0;
  bool operator==(const UnknownEdit&) const = default;
};

using Message = std::variant<StreamDescription, PoseFrameView, Welcome, Ack, Ping, Pong, Goodbye, Status,
                             UnknownMessage, SceneEdit, UnknownEdit, ImageRequest, ImageFrame, ImageRefused>;

}  // namespace fire3dv::wire
