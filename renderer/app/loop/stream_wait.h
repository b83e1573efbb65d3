// Waits for streams: a report of what a run waits for, and the time-out of --wait-for-stream.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "base/error.h"
#include "renderer/app/options/options.h"
#include "renderer/streams/stream_receiver.h"

namespace fire3dv::app {

class StreamWait {
 public:
  // Borrows both.
  StreamWait(const Options& options, const StreamReceiver& receiver)
      : options_(options), receiver_(receiver) {}

  // Names what --lockstep, --exit-when-done and --frames wait for, once for each kind of wait. Call while no
  // message arrives. images: drawn ones.
  void report(uint64_t images, bool has_timeline);
  // Fails if no pose frame has arrived within --wait-for-stream.
  Result<void> check_timeout() const;

 private:
  using Clock = std::chrono::steady_clock;

  const Options& options_;
  const StreamReceiver& receiver_;
  const Clock::time_point started_ = Clock::now();
  std::optional<Clock::time_point> streamless_since_;
  bool reported_absent_ = false, reported_ended_ = false;
};

}  // namespace fire3dv::app
