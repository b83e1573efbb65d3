// Pose datagrams: their sender, and their receipt by all UDP listeners.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/inbox.h"
#include "protocol/transport/udp/udp_parity.h"
#include "protocol/transport/udp/udp_session.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::udp {

// Sends immediately and repeats the newest frame until the listener acknowledges it: after packet loss or a
// reconnect, the last frame before a pause still arrives.
class PoseSender {
 public:
  // parity: without one, none is sent.
  explicit PoseSender(size_t datagram_bytes, ParityRate parity = ParityRate(0))
      : max_message_bytes_(pose_bytes_of(datagram_bytes)), parity_(parity) {}

  enum class Outcome { sent, queued, dropped, refused };  // refused: ECONNREFUSED, no listener at the address

  // session null: queues the frame until one is ready. `drops` counts dropped messages and frames.
  struct Drops {
    uint64_t messages = 0;
    uint64_t frames = 0;
  };
  Outcome publish(int fd, Session* session, const wire::MessagePieces& message, bool last_part,
                  int64_t now_ns, Drops& drops);

  // Sends `partial` if the session has a base frame and queues `whole` for repetition, in case no newer frame
  // follows; otherwise sends `whole`.
  Outcome publish_partial(int fd, Session* session, const wire::MessagePieces& partial,
                          std::span<const wire::MessagePieces> whole, int64_t now_ns, Drops& drops);

  // Sends queued datagrams and repeats unacknowledged ones, one bounded burst per call.
  void emit_due(int fd, Session& session, int64_t now_ns);
  // Time of the next emit_due() call that sends anything; nothing if none is pending.
  std::optional<int64_t> due_at_ns() const;

  void acknowledge(uint64_t frame);
  // A listener's report of received datagrams.
  void report(const Receipt& receipt, int64_t now_ns) { parity_.report(receipt, now_ns); }
  // New listener: the whole frame must be sent again.
  void start_session();
  // New description: drops the queued frame of the earlier one.
  Drops start_description();
  // New datagram length: drops the queued frame, whose parts have another one.
  Drops set_datagram_bytes(size_t datagram_bytes) {
    max_message_bytes_ = pose_bytes_of(datagram_bytes);
    return drop_queued();
  }
  // Longest payload of the newest frame.
  size_t longest_payload() const { return ends_.empty() ? 0 : ends_.front(); }

  uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  Drops drop_queued();
  Outcome send(int fd, Session& session, size_t index);
  Outcome send_bytes(int fd, Session& session, Type type, std::span<const std::byte> payload);
  bool append_payload(const PoseHeader& header, const wire::MessagePieces& message);
  void append_parity();
  size_t round_end() const { return first_round_ ? ends_.size() : data_count_; }
  Drops unsent() const;

  struct GroupPlan {
    size_t rows = 0, symbol_bytes = 0;
  };

  size_t max_message_bytes_;
  ParityRate parity_;
  std::vector<GroupPlan> plan_;  // scratch memory of append_parity()
  uint64_t frame_ = 0;
  uint32_t part_ = 0;
  std::vector<std::byte> payloads_;  // concatenated datagram payloads of the newest frame: parts, then parity
  std::vector<size_t> ends_;         // end offset of each payload
  size_t data_count_ = 0;            // number of parts; parity is sent once and not repeated
  size_t next_ = 0;                  // index of the next payload to send
  bool first_round_ = true;          // payloads from next_ on were never sent
  bool lost_part_ = false;           // a part of the newest frame was dropped
  bool complete_ = false;            // the last part of the newest frame was published
  bool acknowledged_ = false;
  bool has_base_ = false;  // a whole frame was sent in this session: base of partial frames
  int64_t repeat_at_ns_ = 0;
  int64_t repeat_after_ns_ = 0;
  uint64_t bytes_sent_ = 0;
};

// Tracks the received parts of frames: reports complete frames, duplicates, and parts of superseded frames.
class FrameTracker {
 public:
  // repeated: duplicate part.
  enum class Outcome { superseded, repeated, part, whole };
  Outcome part(uint64_t frame, uint16_t part, bool last);
  uint64_t newest_whole() const { return newest_whole_; }
  // Counts a partial frame, whose whole form need not follow.
  void partial() { ++partials_; }
  // Number of lost frames between the previous complete frame and the newest one.
  uint64_t missed(uint64_t newest_before) {
    const uint64_t gap = newest_whole_ - newest_before - 1;
    return gap - std::min(gap, std::exchange(partials_, 0));
  }

 private:
  struct Building {
    uint64_t frame = 0;
    uint32_t count = 0;              // received parts
    uint32_t total = 0;              // 0 until the last part is received
    std::vector<uint64_t> received;  // bitmap by part
  };
  static constexpr size_t kMaxBuilding = 64;  // as many as stream::kMaxOpenFrames

  std::vector<Building> building_;
  uint64_t newest_whole_ = 0;
  uint64_t partials_ = 0;
};

// Enlarges the socket's receive buffer to hold the burst of a large frame.
void widen_receive_buffer(int fd);

// Receives the pending datagrams in batches (recvmmsg), with a bound per call.
using OnDatagram = std::function<void(const Address& from, std::span<std::byte> datagram, int64_t now_ns)>;
void receive_all(int fd, LinkCounters& counters, const OnDatagram& on_datagram);

// Received frames of one peer: their parts, and what restores lost ones.
struct ReceivedPoses {
  FrameTracker frames;
  ParityReceiver parity;
};

// Queues the payload of one pose datagram in the inbox, and parts that it restores. repeated: a duplicate.
enum class PoseArrival { delivered, repeated };
PoseArrival deliver_pose(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                         ReceivedPoses& poses, std::span<const std::byte> payload);
// Queues the parts that the payload of a parity datagram restores.
void deliver_parity(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                    ReceivedPoses& poses, std::span<const std::byte> payload);

}  // namespace fire3dv::transport::udp
