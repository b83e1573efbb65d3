// The pose datagrams of a publisher: sent at once, and the newest frame kept until the listener has it whole.
// A burst that a receiver's buffer did not hold, or a session that ended, so costs time and never the last
// frame before a pause.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/transport/udp/udp_session.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::udp {

class PoseSender {
 public:
  explicit PoseSender(size_t datagram_bytes) : most_message_bytes_(pose_bytes_of(datagram_bytes)) {}

  enum class Outcome { sent, kept, dropped, refused };  // refused: nobody listens at the address any more

  // session null: none is ready, the frame waits. Messages and frames that are given up are counted in
  // `drops`.
  struct Drops {
    uint64_t messages = 0;
    uint64_t frames = 0;
  };
  Outcome publish(int fd, Session* session, const wire::MessagePieces& message, bool last_part,
                  int64_t now_ns, Drops& drops);

  // Sends `partial` at once when the session has had a whole frame, and keeps `whole` to be repeated should
  // nothing newer come; else sends `whole`.
  Outcome publish_partial(int fd, Session* session, const wire::MessagePieces& partial,
                          std::span<const wire::MessagePieces> whole, int64_t now_ns, Drops& drops);

  // Sends what waits, and repeats what has not been acknowledged for some time; a bounded burst at a time.
  void emit_due(int fd, Session& session, int64_t now_ns);
  // When emit_due has something to do; nothing while it has not.
  std::optional<int64_t> due_at_ns() const;

  void acknowledge(uint64_t frame);
  // A listener that knows nothing of the frame: all of it has to be sent.
  void start_session();
  // What came before belongs to another description. Gives the kept frame up.
  Drops start_description();

  uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  Drops drop_kept();
  Outcome send(int fd, Session& session, size_t index);
  Outcome send_bytes(int fd, Session& session, std::span<const std::byte> payload);
  bool keep(const PoseHeader& header, const wire::MessagePieces& message);
  Drops unsent() const;

  size_t most_message_bytes_;
  uint64_t frame_ = 0;
  uint32_t part_ = 0;
  std::vector<std::byte> kept_;  // the newest frame's payloads, one after the other
  std::vector<size_t> ends_;     // where each ends
  size_t next_ = 0;              // the first of them that waits to be sent
  bool first_round_ = true;      // what waits was never sent
  bool lost_part_ = false;       // a part of the newest frame was dropped
  bool complete_ = false;        // its last part was published
  bool acknowledged_ = false;
  bool has_base_ = false;  // a whole frame went out in this session, on which partial ones can stand
  int64_t repeat_at_ns_ = 0;
  int64_t repeat_after_ns_ = 0;
  uint64_t bytes_sent_ = 0;
};

}  // namespace fire3dv::transport::udp
