// Receiver that hands messages to the recording thread. The thread decouples the link from the disk: a
// shared-memory ring holds few frames, and a disk may stall for longer.
#pragma once

#include <cstdint>
#include <utility>

#include "protocol/record/log_thread.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"

namespace fire3dv::record {

using RecorderStatus = LogStatus;

class Recorder {
 public:
  explicit Recorder(StreamLog log) : log_(std::move(log)) {}

  // Processes pending messages of the link. Never waits for the disk. answers: the publisher has no other
  // peer.
  void poll(transport::ListenerLink& link, uint32_t link_number, bool answers);
  // Writes pending messages and finishes the file.
  void finish() { log_.finish(); }
  RecorderStatus status() const { return log_.status(); }

 private:
  void answer(transport::ListenerLink& link, transport::PeerId peer, std::span<const std::byte> message);

  wire::Decoder decoder_;
  LogThread log_;
};

}  // namespace fire3dv::record
