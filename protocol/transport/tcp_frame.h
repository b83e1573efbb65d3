// The bytes of a TCP connection: a preface each way, then framed messages. protocol/SPEC-transport.md draws
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace fire3dv::transport::tcp {

constexpr uint16_t kTransportVersion = 1;
constexpr size_t kPrefaceBytes = 16;
constexpr size_t kFrameHeaderBytes = 8;

// The listener's answer to a preface; a publisher always says ok.
enum class PrefaceStatus : uint16_t { ok = 0, version_mismatch = 1, full = 2 };

struct Preface {
  uint16_t version = kTransportVersion;
  PrefaceStatus status = PrefaceStatus::ok;
};
using PrefaceBytes = std::array<std::byte, kPrefaceBytes>;
PrefaceBytes write_preface(const Preface& preface);
// False when these are not the bytes of a preface of any version.
bool read_preface(std::span<const std::byte, kPrefaceBytes> bytes, Preface& preface);

enum class FrameKind : uint8_t {
  pose = 1,
  control = 2,
  state = 3,         // a control message of which a later one of its key may take the place
  partial_pose = 4,  // builds on the poses before it
  image = 5,         // listener to publisher
};

using FrameHeader = std::array<std::byte, kFrameHeaderBytes>;
FrameHeader write_frame_header(FrameKind kind, uint32_t message_bytes);

// Cuts a byte stream into messages. What is kept grows only as bytes really arrive, whatever a header claims,
// and only as far as its owner can charge it.
class FrameParser {
 public:
  enum class Fault { none, bad_header, too_long, no_memory };
  using OnMessage = std::function<void(FrameKind, std::vector<std::byte>&&)>;
  // Charges `bytes` for the message that is not whole, instead of the amount before; 0 gives all back. False:
  // they do not fit, and the amount before stays charged. Messages of up to 64 KiB are not charged: each
  // connection has a buffer of that size anyway.
  using Charge = std::function<bool(size_t bytes)>;

  explicit FrameParser(Charge charge = {}) : charge_(std::move(charge)) {}
  ~FrameParser() { release(); }
  FrameParser(const FrameParser&) = delete;
  FrameParser& operator=(const FrameParser&) = delete;

  // A message has begun and is not whole yet.
  bool in_message() const { return header_got_ != 0; }

  // After a fault the stream is lost: where the next frame starts is not known. A pose that cannot be charged
  // is no fault: it is skipped.
  Fault feed(std::span<const std::byte> bytes, const OnMessage& on_message);

  uint64_t skipped_poses() const { return skipped_poses_; }

 private:
  bool read_header();
  bool make_room(size_t bytes);
  void release();

  Charge charge_;
  bool is_charged_ = false;
  bool skips_ = false;
  uint64_t skipped_poses_ = 0;
  std::array<std::byte, kFrameHeaderBytes> header_{};
  size_t header_got_ = 0;
  uint32_t message_bytes_ = 0;
  uint32_t message_got_ = 0;
  uint8_t kind_ = 0;
  std::vector<std::byte> message_;
};

}  // namespace fire3dv::transport::tcp
