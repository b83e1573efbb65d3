// Keyed states over datagrams: many small ones share a bundle, so that a snapshot does not cost a round trip
// for each. A bundle is records one after the other: u32 length, u32 0, message.
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
// As many states as may wait to be polled (Inbox): a bundle exceeds that bound at most once.
constexpr size_t kMaxBundleRecords = 256;

// A message as a bundle of one, with its hash: made before the lock is taken that publishing needs.
KeyedState make_record(const wire::Bytes& message);

class StateSender {
 public:
  // `states` hold records. Hands the next bundle to a sender that has nothing else to do.
  void feed(ControlSender& sender, const KeyedStates& states);
  void start_session() { batches_.start_connection(); }
  void forget(const KeyedStates& states) { batches_.forget(states); }
  bool idle(const KeyedStates& states) const { return !batches_.has_news(states); }

 private:
  StateBatches batches_;
};

// The messages of a bundle. Nothing when a record is cut or shorter than any message, or when there are more
// than kMaxBundleRecords: one corrupt record makes the whole bundle corrupt.
std::optional<std::vector<std::vector<std::byte>>> open_bundle(std::span<const std::byte> bundle);

}  // namespace fire3dv::transport::udp
