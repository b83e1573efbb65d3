// Frames in flight: command buffer, upload belt and timestamps of each, reused when the GPU has finished with
// them.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu/device.h"
#include "renderer/gpu/recorder.h"
#include "renderer/gpu/upload_belt.h"

namespace fire3dv::gpu {

constexpr uint32_t kFramesInFlight = 2;
constexpr uint32_t kMaxTimestamps = 128;

struct PassTime {
  const char* name;
  double milliseconds;
  bool aside;  // on the side queue, beside others
};

// GPU times of one finished frame. What ran on the side queue did so within the frame's span, but beside
// other passes: all together may sum up to more than the frame.
struct FrameTimes {
  uint64_t frame_index = 0;
  std::vector<PassTime> passes;  // of frames whose passes were timed
  double total_ms = 0;           // from the first pass's begin to the last one's end, on the main queue
};

class FrameRing {
 public:
  explicit FrameRing(Device& device);

  // Of the frames that are begun from now on; before the first call each is timed as a whole.
  void time(Timed timed) { timed_ = timed; }

  // Waits until the slot's earlier frame is done (that is the back-pressure of the whole renderer), frees
  // what retired, and begins recording.
  Recorder& begin();
  UploadBelt& belt() { return slots_[slot_].belt; }
  // Ends recording and submits. Returns the timeline value of the frame.
  uint64_t submit(std::span<const SemaphoreSignal> waits = {}, std::span<const SemaphoreSignal> signals = {});

  uint64_t frame_index() const { return frame_index_; }  // of the frame being recorded, from 0
  // Reads the times of all frames that are done. Called after the last frame, to miss none.
  std::vector<FrameTimes> take_finished();

 private:
  struct Slot {
    explicit Slot(Device& device) : belt(device) {}
    CommandPool pool, side_pool;
    ForkedCommands commands;  // only the first, where there is no side queue
    QueryPool queries;
    UploadBelt belt;
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
