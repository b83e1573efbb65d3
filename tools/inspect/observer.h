// What passes over a link, counted: streams, rates, sequences that are missing, how old frames are when they
// come.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"

namespace fire3dv::inspect {

// Powers of two of microseconds: bucket i holds ages below 2^i us.
constexpr size_t kAgeBuckets = 24;

struct StreamSeen {
  std::string name;
  uint64_t epoch = 0;
  uint32_t nodes = 0;
  double nominal_rate_hz = 0;
  bool same_clock = false;  // only then are ages known
  bool ended = false;
  uint64_t frames = 0;    // whole, or the last part of one
  uint64_t messages = 0;  // frames and parts of frames
  uint64_t bytes = 0;
  uint64_t edits = 0;    // of the scene
  uint64_t missing = 0;  // sequences that were passed over
  uint64_t sequence = 0;
  int64_t first_frame_ns = 0, last_frame_ns = 0;
  std::array<uint64_t, kAgeBuckets> ages{};

  double rate_hz() const;
  // An upper bound of this quantile of the ages, in microseconds; 0 when none is known.
  uint64_t age_us(double quantile) const;
};

class Observer {
 public:
  // Takes what has come. Answers nothing: who looks on is no renderer.
  void poll(transport::ListenerLink& link);

  const std::map<transport::PeerId, StreamSeen>& streams() const { return streams_; }
  uint64_t refused_messages() const { return refused_; }

  std::string text(const transport::ListenerLink& link) const;
  std::string json(const transport::ListenerLink& link) const;

 private:
  // True for the description of a stream.
  bool take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns);

  wire::Decoder decoder_;
  std::map<transport::PeerId, StreamSeen> streams_;
  uint64_t refused_ = 0;
};

}  // namespace fire3dv::inspect
