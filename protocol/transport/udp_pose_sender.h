// The pose datagrams of a publisher: sent at once, or the newest frame kept until a session is ready for it.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/transport/udp_session.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::udp {

class PoseSender {
 public:
  PoseSender();
  enum class Outcome { sent, kept, dropped, refused };  // refused: nobody listens at the address any more

  // session null: none is ready, keep the frame. `overtaken` counts kept messages that were given up.
  Outcome publish(int fd, Session* session, const wire::MessagePieces& message, bool last_part,
                  uint64_t& overtaken);

  // Sends the frame that was kept. Returns how many of its messages were lost on the way.
  uint64_t send_kept(int fd, Session& session);
  // Gives the kept frame up; returns its number of messages.
  uint64_t drop_kept();

  uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  Outcome send(int fd, Session& session, const PoseHeader& header, const wire::MessagePieces& message);
  bool keep(const PoseHeader& header, const wire::MessagePieces& message);

  uint64_t frame_ = 0;
  uint32_t part_ = 0;
  std::vector<std::byte> kept_;  // pose header, u16 length, message; one after the other
  uint64_t kept_messages_ = 0;
  uint64_t bytes_sent_ = 0;
};

}  // namespace fire3dv::transport::udp
