// Frames in flight and the data that the CPU uploads for them: a ring of command buffers, staging memory and
// timestamp queries, and partial updates of buffers between frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu/device/device.h"
#include "renderer/gpu/device/resources.h"
#include "renderer/gpu/recorder.h"
#include "renderer/gpu/submission_limits.h"

namespace fire3dv::gpu {

// Staging ring for data that the CPU writes for one frame. Allocation is a pointer bump; the memory is reused
// with the frame's slot. It is write-combined: write it once, in order, and never read it.
class StagingRing {
 public:
  explicit StagingRing(Device& device) : device_(device) {}

  struct Piece {
    std::byte* mapped = nullptr;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceSize offset = 0;
    VkDeviceAddress address = 0;
  };
  Piece allocate(VkDeviceSize size_bytes);

  template <typename T>
  Piece write(std::span<const T> values) {
    const Piece piece = allocate(values.size_bytes());
    if (!values.empty()) std::memcpy(piece.mapped, values.data(), values.size_bytes());
    return piece;
  }

  void reset();  // requires that the GPU has finished the frame

  // Words that end the frame's draws early when they are not 0; see SubmissionLimits.
  void add_end_word(uint64_t* word) { end_words_.push_back(word); }
  std::span<uint64_t* const> end_words() const { return end_words_; }
  // The frame has a time limit: costly draws are recorded in batches, between which it can end.
  bool has_limit() const { return has_limit_; }
  void set_has_limit(bool has_limit) { has_limit_ = has_limit; }

 private:
  Device& device_;
  std::vector<uint64_t*> end_words_;
  bool has_limit_ = false;
  std::vector<Buffer> chunks_;  // normally one; a frame that needs more adds chunks, and reset() keeps the
                                // largest
  VkDeviceSize used_ = 0;       // of the last chunk
};

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

// Command buffers, staging ring and timestamp queries of each frame in flight. A slot is reused when the GPU
// has finished its frame.
class FrameRing {
 public:
  explicit FrameRing(Device& device);

  // Selects the timestamps of later frames; the default times the frame as a whole.
  void time(Timed timed) { timed_ = timed; }

  // Waits for the slot's earlier frame, frees retired objects and begins recording. This wait is the
  // renderer's back-pressure.
  Recorder& begin();
  StagingRing& staging() { return slots_[slot_].staging; }
  // Time limits of later frames.
  SubmissionLimits& limits() { return limits_; }
  // Ends a submission of a frame that nobody waits for any more, if it still runs; see SubmissionLimits.
  void end_early(uint64_t timeline_value);
  // Waits until begin() need not wait; false after this time.
  bool wait_for_slot(int64_t timeout_ns);
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
  SubmissionLimits limits_;
};

// Partial buffer updates between frames. Passes do not declare these rarely written buffers, so frames with
// patches have one full barrier.
class Patches {
 public:
  template <typename T>
  void write(const Buffer& to, VkDeviceSize offset, std::span<const T> values) {
    if (values.empty()) return;
    const size_t at = bytes_.size();
    bytes_.resize(at + values.size_bytes());
    std::memcpy(bytes_.data() + at, values.data(), values.size_bytes());
    uploads_.push_back({VK_NULL_HANDLE, to.get(), {at, offset, values.size_bytes()}});
  }
  template <typename T>
  void write(const Buffer& to, VkDeviceSize offset, const T& value) {
    write(to, offset, std::span<const T>(&value, 1));
  }
  // Copies within one buffer. Source ranges must not overlap other patches.
  void copy(const Buffer& buffer, VkDeviceSize from, VkDeviceSize to, VkDeviceSize bytes) {
    uploads_.push_back({buffer.get(), buffer.get(), {from, to, bytes}});
  }
  // Grows the buffer to at least this size; its first used_bytes are preserved.
  void reserve(Device& device, Buffer& buffer, VkDeviceSize used_bytes, VkDeviceSize bytes);

  bool empty() const { return uploads_.empty() && moves_.empty(); }
  void record(Recorder& recorder, StagingRing& staging);

 private:
  struct Copy {
    VkBuffer from;  // null: source is bytes_
    VkBuffer to;
    VkBufferCopy region;
  };
  std::vector<std::byte> bytes_;
  std::vector<Copy> uploads_, moves_;
};

}  // namespace fire3dv::gpu
