// Statistics of the streams on a link: rates, missing sequences and frame age on arrival. It sends no
// answers.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "base/peer_budget.h"
#include "protocol/stream/scalar_history.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"

namespace fire3dv::inspect {

// Buckets are powers of two: bucket i holds ages below 2^i us.
constexpr size_t kAgeBuckets = 24;

struct StreamSeen {
  std::string name;
  uint64_t epoch = 0;
  uint32_t nodes = 0;
  double nominal_rate_hz = 0;
  bool same_clock = false;  // publisher's clock is this machine's; otherwise ages are unknown
  bool ended = false;
  uint64_t frames = 0;    // whole frames, counted at their last part
  uint64_t messages = 0;  // frames and frame parts
  uint64_t bytes = 0;
  uint64_t edits = 0;  // scene edits, markers and scalars included
  uint64_t marker_edits = 0;
  uint64_t scalar_edits = 0;
  uint64_t scalar_version = 0;  // of the newest one
  stream::ScalarHistory scalars{nullptr, stream::ScalarHistory::Keep::statistics};
  uint64_t missing = 0;  // skipped sequences
  uint64_t sequence = 0;
  int64_t first_frame_ns = 0, last_frame_ns = 0;
  std::array<uint64_t, kAgeBuckets> ages{};

  double rate_hz() const;
  // Returns an upper bound of this quantile of ages, in microseconds; 0 when unknown.
  uint64_t age_us(double quantile) const;
};

class Observer {
 public:
  // Processes pending messages. It sends no answer, since an observer is no renderer.
  void poll(transport::ListenerLink& link);

  const std::map<transport::PeerId, StreamSeen>& streams() const { return streams_; }
  uint64_t refused_messages() const { return refused_; }

  std::string text(const transport::ListenerLink& link) const;
  std::string json(const transport::ListenerLink& link) const;

 private:
  // Returns true for a stream description.
  bool take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns);

  wire::Decoder decoder_;
  // Of the scalars of all streams together, which stay in the report when their stream has ended.
  std::shared_ptr<PeerBudget> scalar_budget_ = BudgetPool::create()->add_peer("scalars");
  std::map<transport::PeerId, StreamSeen> streams_;
  uint64_t refused_ = 0;
};

}  // namespace fire3dv::inspect
