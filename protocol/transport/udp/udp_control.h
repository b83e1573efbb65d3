// Reliable, ordered control messages over datagrams, and the bundles of keyed states that they carry:
// fragmentation, acknowledgment, retransmission and
// reassembly. One message is in flight at a time in each direction. No I/O; the caller passes the time.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/core/keyed_states.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/udp/udp_datagram.h"

namespace fire3dv::transport::udp {

constexpr size_t kMaxControlBytes = size_t{64} << 20;

// Number of fragments of a message, and the length of one.
uint32_t fragments_of(size_t message_bytes, size_t piece_bytes);
size_t fragment_size(const FragmentHeader& header, size_t piece_bytes);

class ControlSender {
 public:
  explicit ControlSender(size_t piece_bytes = kFragmentBytes) : piece_bytes_(piece_bytes) {}

  // A copied and hashed message. Prepared before the caller takes its lock: tens of megabytes take long.
  struct Prepared {
    SharedBytes bytes;
    uint64_t hash = 0;
  };
  static Prepared prepare(std::span<const std::byte> message);

  // Queues a message and returns its number, or nothing if more than `max_queued_bytes` are queued already.
  std::optional<uint32_t> push(Prepared message, size_t max_queued_bytes);

  // Returns the next fragment that is due and marks it as sent at `now_ns`.
  struct Fragment {
    FragmentHeader header;
    std::span<const std::byte> data;
  };
  std::optional<Fragment> next(int64_t now_ns);

  void acknowledge(const Ack& ack, int64_t now_ns);

  bool idle() const { return messages_.empty(); }
  size_t waiting_messages() const { return messages_.size(); }
  uint32_t last_acknowledged() const { return last_acknowledged_; }

 private:
  struct Sent {
    int64_t at_ns = 0;  // 0: not yet
    bool repeated = false;
    bool acknowledged = false;
  };
  struct Message {
    SharedBytes bytes;
    FragmentHeader header;
  };
  void begin();
  Sent& sent(uint32_t index) { return sent_[index % sent_.size()]; }
  bool due(uint32_t index, int64_t now_ns);

  size_t piece_bytes_;
  std::deque<Message> messages_;       // the front one is in flight
  std::array<Sent, kAckWindow> sent_;  // ring of its fragments from first_missing_ on
  uint32_t first_missing_ = 0;
  uint32_t highest_acknowledged_ = 0;  // one past it
  uint32_t window_ = 32;
  uint32_t last_number_ = 0;
  uint32_t last_acknowledged_ = 0;
  size_t queued_bytes_ = 0;
  int64_t round_trip_ns_ = 20'000'000;
  int64_t last_backoff_ns_ = 0;
  int64_t repeat_after_ns_ = 0;
};

class ControlReceiver {
 public:
  explicit ControlReceiver(size_t piece_bytes = kFragmentBytes, size_t max_message_bytes = kMaxControlBytes)
      : piece_bytes_(piece_bytes), max_message_bytes_(max_message_bytes) {}

  enum class Outcome { ignored, accepted, complete, corrupt };

  // complete: take() returns the message. corrupt: inconsistent headers or hash; end the session.
  // `budget`: bytes that this receiver may still allocate.
  // Fragments are hashed on arrival, so that every call costs about the same: a publisher's lock may be held.
  Outcome fragment(const FragmentHeader& header, std::span<const std::byte> data, size_t budget);
  std::vector<std::byte> take();

  // The acknowledgment to send, or nothing before the first fragment.
  std::optional<Ack> ack() const;
  size_t buffered_bytes() const { return bytes_.capacity(); }

 private:
  size_t piece_bytes_, max_message_bytes_;
  FragmentHeader header_;  // of the message in flight; header_.message 0: none
  std::vector<std::byte> bytes_;
  std::vector<bool> received_;
  uint32_t first_missing_ = 0;
  uint64_t hash_ = 0;  // of all fragments before first_missing_
  uint32_t last_complete_ = 0;
  uint32_t last_complete_count_ = 0;
};

// Bundles of keyed states for UDP: small states share a bundle, so that a snapshot does not cost one round
// trip per state. A bundle is a sequence of records: u32 length, u32 0, message.
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
