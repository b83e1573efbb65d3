// Takes what links bring and hands it to a recording's thread: a ring in shared memory holds some frames
// only, and a disk may stand still for longer than they last.
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

  // Takes what has come over the link. Never waits for the disk. answers: the publisher has nobody else to
  // talk to.
  void poll(transport::ListenerLink& link, uint32_t link_number, bool answers);
  // Writes what is left, and finishes the file.
  void finish() { log_.finish(); }
  RecorderStatus status() const { return log_.status(); }

 private:
  void answer(transport::ListenerLink& link, transport::PeerId peer, std::span<const std::byte> message);

  wire::Decoder decoder_;
  LogThread log_;
};

}  // namespace fire3dv::record
