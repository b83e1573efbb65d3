// Datagram layout; see protocol/SPEC-transport.md. The publisher sets the maximum length when the session
// begins (default 1200 bytes); it includes 16 bytes reserved for an authentication tag.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace fire3dv::transport::udp {

constexpr uint8_t kTransportVersion = 1;
constexpr size_t kDatagramBytes = 1200;
constexpr size_t kLeastDatagramBytes = 576;
constexpr size_t kMaxDatagramBytes = 9000;
constexpr size_t kTagBytes = 16;
constexpr size_t kHeaderBytes = 24;
constexpr size_t kPoseHeaderBytes = 12;
constexpr size_t kFragmentHeaderBytes = 24;
constexpr size_t kHelloBytes =
    256;  // padded, so that no answer is longer than the request (no amplification)

// Payload capacity of datagrams of this length.
constexpr size_t pose_bytes_of(size_t datagram_bytes) {
  return (datagram_bytes - kTagBytes - kHeaderBytes - kPoseHeaderBytes) / 8 * 8;
}
constexpr size_t fragment_bytes_of(size_t datagram_bytes) {
  return datagram_bytes - kTagBytes - kHeaderBytes - kFragmentHeaderBytes;
}
constexpr size_t kFragmentBytes = fragment_bytes_of(kDatagramBytes);

enum class Type : uint8_t {
  hello = 1,       // publisher: session request   session = nonce; cookie, or 0 in the first one
  cookie = 2,      // listener: cookie request     session = nonce; cookie
  accept = 3,      // listener: session accepted   session = nonce; session id
  refuse = 4,      // listener: session refused    session = nonce; reason and version
  pose = 5,        // publisher: one part of a frame
  fragment = 6,    // either side: one fragment of a control message
  ack = 7,         // either side: received fragments
  ping = 8,        // either side: liveness probe
  pong = 9,        // answer to ping
  bye = 10,        // either side: end of the session
  reset = 11,      // listener: unknown session
  have = 12,       // listener: newest complete frame, and receipt of datagrams
  state = 13,      // publisher: one fragment of a bundle of keyed states
  state_ack = 14,  // listener: received fragments of a bundle
  group = 15,      // publisher to a multicast group: available control messages
  parity = 16,     // publisher: parity of one group of parts of a frame
};

enum class Refusal : uint16_t { version_mismatch = 1, full = 2, bad_key = 3, datagram_bytes = 4 };

struct Header {
  uint8_t version = kTransportVersion;
  Type type{};
  uint64_t session = 0;
  uint64_t counter = 0;  // of the sender's datagrams in this session, from 1
};
void write_header(std::byte* to, const Header& header);
// Returns false if this is not a FIRE-3DV datagram of any version.
bool read_header(std::span<const std::byte> datagram, Header& header);

struct PoseHeader {
  uint64_t frame = 0;  // frame number, from 1
  uint16_t part = 0;
  bool last = false;     // no part of this frame has a higher number
  bool partial = false;  // single-part frame that depends on earlier frames
};
void write_pose_header(std::byte* to, const PoseHeader& header);
bool read_pose_header(std::span<const std::byte> payload, PoseHeader& header);

struct FragmentHeader {
  uint32_t message = 0;  // counts the sender's control messages in this session, from 1
  uint32_t index = 0;
  uint32_t count = 0;
  uint32_t message_bytes = 0;
  uint64_t hash = 0;  // FNV-1a, 64 bits, of the whole message
};
void write_fragment_header(std::byte* to, const FragmentHeader& header);
bool read_fragment_header(std::span<const std::byte> payload, FragmentHeader& header);

// Selective acknowledgment: all fragments below first_missing were received; bit i of `beyond` stands for
// first_missing + 1 + i.
constexpr uint32_t kAckWindow = 256;
constexpr size_t kAckBytes = 8 + kAckWindow / 8;
struct Ack {
  uint32_t message = 0;
  uint32_t first_missing = 0;
  std::array<uint64_t, kAckWindow / 64> beyond{};
};
void write_ack(std::byte* to, const Ack& ack);
bool read_ack(std::span<const std::byte> payload, Ack& ack);

constexpr uint64_t kFnvBasis = 0xcbf29ce484222325;
// `hash`: FNV-1a of the preceding bytes.
uint64_t fnv1a_64(std::span<const std::byte> bytes, uint64_t hash = kFnvBasis);

}  // namespace fire3dv::transport::udp
