// TCP framing: a preface in each direction, then length-prefixed messages, as defined in
// protocol/SPEC-transport.md.
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

// Listener's answer to a preface; a publisher always sends ok.
enum class PrefaceStatus : uint16_t { ok = 0, version_mismatch = 1, full = 2 };

struct Preface {
  uint16_t version = kTransportVersion;
  PrefaceStatus status = PrefaceStatus::ok;
};
using PrefaceBytes = std::array<std::byte, kPrefaceBytes>;
PrefaceBytes write_preface(const Preface& preface);
// Returns false if the bytes are no preface of any version.
bool read_preface(std::span<const std::byte, kPrefaceBytes> bytes, Preface& preface);

enum class FrameKind : uint8_t {
  pose = 1,
  control = 2,
  state = 3,         // control message that a later one of its key may replace
  partial_pose = 4,  // builds on earlier poses
  image = 5,         // listener to publisher
};

using FrameHeader = std::array<std::byte, kFrameHeaderBytes>;
FrameHeader write_frame_header(FrameKind kind, uint32_t message_bytes);

// Splits a byte stream into messages. Memory grows only with received bytes, regardless of the claimed
// length, and only as far as the owner can charge it.
class FrameParser {
 public:
  enum class Fault { none, bad_header, too_long, no_memory };
  using OnMessage = std::function<void(FrameKind, std::vector<std::byte>&&)>;
  // Sets the charge for the incomplete message to `bytes`; 0 releases it. Returns false, with the charge
  // unchanged, if it does not fit. Messages of up to 64 KiB are not charged: every connection has a buffer of
  // that size.
  using Charge = std::function<bool(size_t bytes)>;

  explicit FrameParser(Charge charge = {}) : charge_(std::move(charge)) {}
  ~FrameParser() { release(); }
  FrameParser(const FrameParser&) = delete;
  FrameParser& operator=(const FrameParser&) = delete;

  // True while a message is incomplete.
  bool in_message() const { return header_got_ != 0; }

  // After a fault the connection must be closed, since framing is lost. A pose that cannot be charged is
  // skipped without a fault.
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
