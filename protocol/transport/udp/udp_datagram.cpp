#include "protocol/transport/udp/udp_datagram.h"

#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {
constexpr uint32_t kMagic = 0x55443346;  // "F3DU"
constexpr uint16_t kLastPart = 1;
constexpr uint16_t kPartial = 2;
}  // namespace

void write_header(std::byte* to, const Header& header) {
  put_le<uint32_t>(to, kMagic);
  to[4] = static_cast<std::byte>(header.version);
  to[5] = static_cast<std::byte>(header.type);
  put_le<uint16_t>(to + 6, 0);
  put_le<uint64_t>(to + 8, header.session);
  put_le<uint64_t>(to + 16, header.counter);
}

bool read_header(std::span<const std::byte> datagram, Header& header) {
  if (datagram.size() < kHeaderBytes || datagram.size() > kMaxDatagramBytes) return false;
  const std::byte* from = datagram.data();
  if (get_le<uint32_t>(from) != kMagic) return false;
  header.version = static_cast<uint8_t>(from[4]);
  header.type = static_cast<Type>(from[5]);
  header.session = get_le<uint64_t>(from + 8);
  header.counter = get_le<uint64_t>(from + 16);
  return true;
}

void write_pose_header(std::byte* to, const PoseHeader& header) {
  put_le<uint64_t>(to, header.frame);
  put_le<uint16_t>(to + 8, header.part);
  const int flags = (header.last ? kLastPart : 0) | (header.partial ? kPartial : 0);
  put_le<uint16_t>(to + 10, static_cast<uint16_t>(flags));
}

bool read_pose_header(std::span<const std::byte> payload, PoseHeader& header) {
  if (payload.size() < kPoseHeaderBytes) return false;
  header.frame = get_le<uint64_t>(payload.data());
  header.part = get_le<uint16_t>(payload.data() + 8);
  const uint16_t flags = get_le<uint16_t>(payload.data() + 10);
  header.last = (flags & kLastPart) != 0;
  header.partial = (flags & kPartial) != 0;
  return header.frame != 0;
}

void write_fragment_header(std::byte* to, const FragmentHeader& header) {
  put_le<uint32_t>(to, header.message);
  put_le<uint32_t>(to + 4, header.index);
  put_le<uint32_t>(to + 8, header.count);
  put_le<uint32_t>(to + 12, header.message_bytes);
  put_le<uint64_t>(to + 16, header.hash);
}

bool read_fragment_header(std::span<const std::byte> payload, FragmentHeader& header) {
  if (payload.size() < kFragmentHeaderBytes) return false;
  header.message = get_le<uint32_t>(payload.data());
  header.index = get_le<uint32_t>(payload.data() + 4);
  header.count = get_le<uint32_t>(payload.data() + 8);
  header.message_bytes = get_le<uint32_t>(payload.data() + 12);
  header.hash = get_le<uint64_t>(payload.data() + 16);
  return header.message != 0 && header.index < header.count;
}

void write_ack(std::byte* to, const Ack& ack) {
  put_le<uint32_t>(to, ack.message);
  put_le<uint32_t>(to + 4, ack.first_missing);
  for (size_t i = 0; i < ack.beyond.size(); ++i) put_le<uint64_t>(to + 8 + 8 * i, ack.beyond[i]);
}

bool read_ack(std::span<const std::byte> payload, Ack& ack) {
  if (payload.size() < kAckBytes) return false;
  ack.message = get_le<uint32_t>(payload.data());
  ack.first_missing = get_le<uint32_t>(payload.data() + 4);
  for (size_t i = 0; i < ack.beyond.size(); ++i) ack.beyond[i] = get_le<uint64_t>(payload.data() + 8 + 8 * i);
  return ack.message != 0;
}

uint64_t fnv1a_64(std::span<const std::byte> bytes, uint64_t hash) {
  for (const std::byte byte : bytes) hash = (hash ^ static_cast<uint64_t>(byte)) * 0x100000001b3;
  return hash;
}

}  // namespace fire3dv::transport::udp
