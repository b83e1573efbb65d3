#include "protocol/transport/tcp/tcp_frame.h"

#include <algorithm>
#include <cstring>

#include "protocol/transport/core/byte_order.h"
#include "protocol/transport/core/link_counters.h"

namespace fire3dv::transport::tcp {
namespace {

constexpr char kPrefaceMagic[4] = {'F', '3', 'D', 'V'};
constexpr size_t kFirstReserve = 64 << 10;

// Detects loss of framing before a wild length is trusted; no protection against attackers.
uint16_t check_of(uint32_t message_bytes, uint8_t kind, uint8_t flags) {
  return static_cast<uint16_t>((message_bytes & 0xffff) ^ (message_bytes >> 16) ^ (kind << 8 | flags) ^
                               0x3d5f);
}

}  // namespace

PrefaceBytes write_preface(const Preface& preface) {
  PrefaceBytes bytes{};
  std::memcpy(bytes.data(), kPrefaceMagic, 4);
  put_le<uint16_t>(&bytes[4], preface.version);
  put_le<uint16_t>(&bytes[6], static_cast<uint16_t>(preface.status));
  return bytes;
}

bool read_preface(std::span<const std::byte, kPrefaceBytes> bytes, Preface& preface) {
  if (std::memcmp(bytes.data(), kPrefaceMagic, 4) != 0) return false;
  preface.version = get_le<uint16_t>(&bytes[4]);
  preface.status = static_cast<PrefaceStatus>(get_le<uint16_t>(&bytes[6]));
  return true;
}

FrameHeader write_frame_header(FrameKind kind, uint32_t message_bytes) {
  FrameHeader bytes{};
  put_le<uint32_t>(&bytes[0], message_bytes);
  bytes[4] = static_cast<std::byte>(kind);
  put_le<uint16_t>(&bytes[6], check_of(message_bytes, static_cast<uint8_t>(kind), 0));
  return bytes;
}

FrameParser::Fault FrameParser::feed(std::span<const std::byte> bytes, const OnMessage& on_message) {
  while (true) {
    if (header_got_ < kFrameHeaderBytes) {
      if (bytes.empty()) return Fault::none;
      const size_t taken = std::min(bytes.size(), kFrameHeaderBytes - header_got_);
      std::memcpy(header_.data() + header_got_, bytes.data(), taken);
      header_got_ += taken;
      bytes = bytes.subspan(taken);
      if (header_got_ < kFrameHeaderBytes) return Fault::none;
      if (!read_header()) return Fault::bad_header;
      if (message_bytes_ > kMaxMessageBytes) return Fault::too_long;
    }
    const size_t taken = std::min<size_t>(bytes.size(), message_bytes_ - message_got_);
    if (!skips_ && !make_room(message_got_ + taken)) {
      const auto kind = static_cast<FrameKind>(kind_);
      if (kind != FrameKind::pose && kind != FrameKind::partial_pose) return Fault::no_memory;
      skips_ = true;
      message_ = {};
      release();
    }
    if (!skips_)
      message_.insert(message_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(taken));
    message_got_ += static_cast<uint32_t>(taken);
    bytes = bytes.subspan(taken);
    if (message_got_ < message_bytes_) return Fault::none;
    header_got_ = 0;
    message_got_ = 0;
    release();
    if (std::exchange(skips_, false))
      ++skipped_poses_;
    else
      on_message(static_cast<FrameKind>(kind_), std::exchange(message_, {}));
  }
}

bool FrameParser::make_room(size_t bytes) {
  if (bytes <= message_.capacity()) return true;
  const size_t wanted = std::max(bytes, std::max(2 * message_.capacity(), kFirstReserve));
  const size_t capacity = std::min<size_t>(wanted, message_bytes_);
  if (charge_ && capacity > kFirstReserve) {
    if (!charge_(capacity)) return false;
    is_charged_ = true;
  }
  message_.reserve(capacity);
  return true;
}

void FrameParser::release() {
  if (std::exchange(is_charged_, false)) charge_(0);
}

bool FrameParser::read_header() {
  message_bytes_ = get_le<uint32_t>(&header_[0]);
  kind_ = static_cast<uint8_t>(header_[4]);
  const auto flags = static_cast<uint8_t>(header_[5]);
  return get_le<uint16_t>(&header_[6]) == check_of(message_bytes_, kind_, flags);
}

}  // namespace fire3dv::transport::tcp
