// Bundles of keyed states for UDP: small states share a bundle, so that a snapshot does not cost one round
// trip per state. A bundle is a sequence of records: u32 length, u32 0, message.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/core/keyed_states.h"
#include "protocol/transport/udp/udp_control.h"

namespace fire3dv::transport::udp {

constexpr size_t kMaxStateBytes = kMaxControlBytes - 8;
// No FlatBuffers message with an identifier is shorter.
constexpr size_t kLeastStateBytes = 12;
// Equal to the inbox's limit of queued states, so that a bundle exceeds that limit at most once.
constexpr size_t kMaxBundleRecords = 256;

// Makes a bundle of one message, with its hash. Called before the publisher takes its lock.
KeyedState make_record(const wire::Bytes& message);

class StateSender {
 public:
  // `states` are records of make_record(). Queues the next bundle if the sender is idle.
  void feed(ControlSender& sender, const KeyedStates& states);
  void start_session() { batches_.start_connection(); }
  void discard(const KeyedStates& states) { batches_.discard(states); }
  bool idle(const KeyedStates& states) const { return !batches_.has_unsent(states); }

 private:
  StateBatches batches_;
};

// Splits a bundle into messages. Returns nothing if a record is truncated or too short, or if there are more
// than kMaxBundleRecords: one corrupt record invalidates the whole bundle.
std::optional<std::vector<std::vector<std::byte>>> open_bundle(std::span<const std::byte> bundle);

}  // namespace fire3dv::transport::udp
