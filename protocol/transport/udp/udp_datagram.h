// The bytes of one datagram. protocol/SPEC-transport.md draws them. No datagram is longer than the publisher
// said when the session began (1200 bytes unless asked otherwise), with room set aside for the 16 bytes of an
// authentication tag.
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
constexpr size_t kHelloBytes = 256;  // padded, so that no answer is longer than the question

// What fits datagrams of this length.
constexpr size_t pose_bytes_of(size_t datagram_bytes) {
  return (datagram_bytes - kTagBytes - kHeaderBytes - kPoseHeaderBytes) / 8 * 8;
}
constexpr size_t fragment_bytes_of(size_t datagram_bytes) {
  return datagram_bytes - kTagBytes - kHeaderBytes - kFragmentHeaderBytes;
}
constexpr size_t kFragmentBytes = fragment_bytes_of(kDatagramBytes);

enum class Type : uint8_t {
  hello = 1,       // publisher: may I?            session = its nonce; cookie, or 0 in the first
  cookie = 2,      // listener: say that again     session = nonce; cookie
  accept = 3,      // listener: yes                session = nonce; the session's id
  refuse = 4,      // listener: no                 session = nonce; reason and version
  pose = 5,        // publisher: one part of a frame
  fragment = 6,    // either: one piece of a control message
  ack = 7,         // either: which pieces came
  ping = 8,        // either: are you there
  pong = 9,        // the answer
  bye = 10,        // either: the session is over
  reset = 11,      // listener: I know no such session
  have = 12,       // listener: the newest frame that is whole here
  state = 13,      // publisher: one piece of a bundle of keyed states
  state_ack = 14,  // listener: which of its pieces came
  group = 15,      // publisher to a multicast group: which control messages are on offer
};

enum class Refusal : uint16_t { version_mismatch = 1, full = 2, bad_key = 3, datagram_bytes = 4 };

struct Header {
  uint8_t version = kTransportVersion;
  Type type{};
  uint64_t session = 0;
  uint64_t counter = 0;  // of the sender's datagrams in this session, from 1; a nonce-to-be
};
void write_header(std::byte* to, const Header& header);
// False when these are not the bytes of a datagram of any version.
bool read_header(std::span<const std::byte> datagram, Header& header);

struct PoseHeader {
  uint64_t frame = 0;  // counts frames, whatever they hold
  uint16_t part = 0;
  bool last = false;     // no part of this frame has a higher number
  bool partial = false;  // builds on the frames before it; a frame of its own, of one part
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

// Everything below first_missing came; bit i of `beyond` says that first_missing + 1 + i did too.
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
// `hash` is that of what stands before these bytes.
uint64_t fnv1a_64(std::span<const std::byte> bytes, uint64_t hash = kFnvBasis);

}  // namespace fire3dv::transport::udp
