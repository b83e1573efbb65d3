// TCP connection of a peer that frames messages itself. It sends messages that the client library refuses to
// send, and reads replies only on request.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "base/unique_fd.h"
#include "protocol/transport/tcp/tcp_frame.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"

namespace fire3dv::test {

// The renderer closed the connection, or the test has ended.
struct PeerClosed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// True once standard input has ended or contains a whole line: the test wants the program to end.
bool stop_requested();

// Prints "sent" once: the whole attack has been sent at least once.
void announce_sent();

class RawPeer {
 public:
  // Prints "begun" for the first connection of the process.
  // uri: tcp://HOST:PORT. receive_buffer_bytes 0: the system's default.
  explicit RawPeer(const std::string& uri, int receive_buffer_bytes = 0);

  void control(const wire::Bytes& message) { send(transport::tcp::FrameKind::control, message); }
  void state(const wire::Bytes& message) { send(transport::tcp::FrameKind::state, message); }
  void pose(const wire::Bytes& message) { send(transport::tcp::FrameKind::pose, message); }
  // Sends a ping and reads until its answer or the time-out. The renderer handles messages in order.
  void sync(std::chrono::milliseconds timeout);
  void read_replies();

  // Sum over all connections of this process.
  static uint64_t bytes_sent();
  static void count_bytes(uint64_t bytes);  // adds bytes sent over another link

 private:
  void send(transport::tcp::FrameKind kind, const wire::Bytes& message);
  void send(std::span<const std::byte> bytes);

  UniqueFd socket_;
  size_t preface_bytes_left_ = transport::tcp::kPrefaceBytes;
  std::unique_ptr<transport::tcp::FrameParser> parser_ = std::make_unique<transport::tcp::FrameParser>();
  wire::Decoder decoder_;
  uint64_t pings_ = 0, pongs_ = 0;
};

}  // namespace fire3dv::test
