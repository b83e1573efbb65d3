// Ring of frames in flight: command buffers, upload staging ring and timestamp queries of each frame. A slot
// is reused when the GPU has finished its frame.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu/device/device.h"
#include "renderer/gpu/recorder.h"
#include "renderer/gpu/staging_ring.h"

namespace fire3dv::gpu {

constexpr uint32_t kFramesInFlight = 2;
constexpr uint32_t kMaxTimestamps = 128;

struct PassTime {
  const char* name;
  double milliseconds;
  bool async_compute;  // on the async compute queue, overlapped with other passes
};

// GPU times of one finished frame, in milliseconds. Passes on the async compute queue overlap others, so the
// sum may exceed the total.
struct FrameTimes {
  uint64_t frame_index = 0;
  std::vector<PassTime> passes;  // only of frames with pass timing
  double total_ms = 0;           // main queue: begin of the first pass to end of the last one
};

class FrameRing {
 public:
  explicit FrameRing(Device& device);

  // Selects the timestamps of later frames; the default times the frame as a whole.
  void time(Timed timed) { timed_ = timed; }

  // Waits for the slot's earlier frame, frees retired objects and begins recording. This wait is the
  // renderer's back-pressure.
  Recorder& begin();
  StagingRing& staging() { return slots_[slot_].staging; }
  // Ends recording and submits. Returns the frame's timeline value.
  uint64_t submit(std::span<const SemaphoreSignal> waits = {}, std::span<const SemaphoreSignal> signals = {});

  uint64_t frame_index() const { return frame_index_; }  // of the frame being recorded, from 0
  // Reads the times of all finished frames. Call it once more after the last frame, so that none is missed.
  std::vector<FrameTimes> take_finished();

 private:
  struct Slot {
    explicit Slot(Device& device) : staging(device) {}
    CommandPool pool, async_pool;
    ForkedCommands commands;  // only the first one without an async compute queue
    QueryPool queries;
    StagingRing staging;
    std::optional<Recorder> recorder;
    uint64_t done_at = 0;  // timeline value
    uint64_t frame_index = 0;
    bool times_pending = false;
  };
  void read_times(Slot& slot);

  Device& device_;
  std::vector<Slot> slots_;
  uint32_t slot_ = 0;
  uint64_t next_frame_ = 0, frame_index_ = 0;
  Timed timed_ = Timed::frame;
  std::vector<FrameTimes> untaken_;
};

}  // namespace fire3dv::gpu
