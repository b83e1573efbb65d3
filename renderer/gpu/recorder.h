// Recorder of one frame's passes, with derived barriers. Each pass declares its reads and writes; barriers
// and waits across queues follow from the order of recording. Timestamps surround each named pass, or the
// frame.
#pragma once

#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu/device/queues.h"
#include "renderer/gpu/device/resources.h"

namespace fire3dv::gpu {

// Accesses that passes declare.
namespace access {
inline constexpr Access compute_read{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_READ_BIT,
                                     false};
inline constexpr Access compute_write{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                      VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT, true};
inline constexpr Access compute_sample{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_READ_BIT,
                                       false, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
inline constexpr Access draw_read{
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
    VK_ACCESS_2_SHADER_READ_BIT, false};
inline constexpr Access color_target{
    VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
    VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, true,
    VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
inline constexpr Access depth_target{
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, true,
    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL};
inline constexpr Access transfer_read{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                                      false, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
inline constexpr Access transfer_write{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                       true, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
inline constexpr Access build_input{VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                                    VK_ACCESS_2_SHADER_READ_BIT, false};
inline constexpr Access build_write{
    VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
    VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR | VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR, true};
inline constexpr Access build_read{VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                                   VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, false};
inline constexpr Access draw_trace{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                                   VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, false};
inline constexpr Access compute_trace{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                      VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, false};
inline constexpr Access ray_trace{VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR,
                                  VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, false};
inline constexpr Access ray_read{VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR, VK_ACCESS_2_SHADER_READ_BIT,
                                 false};
inline constexpr Access ray_write{VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR,
                                  VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT, true};
inline constexpr Access indirect_read{VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                                      VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, false};
inline constexpr Access host_read{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, false};
inline constexpr Access present{VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE, false,
                                VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};
}  // namespace access

// One resource and its access by a pass. `discard`: the old content of a written image is not needed.
struct Use {
  Use(Buffer& b, const Access& a) : buffer(&b), access(a) {}
  Use(Image& i, const Access& a, bool discard_content = false)
      : image(&i), access(a), discard(discard_content) {}
  Buffer* buffer = nullptr;
  Image* image = nullptr;
  Access access;
  bool discard = false;
};

struct PassTimestamps {
  const char* name;
  uint32_t begin_query, end_query;
  bool async_compute;  // on the async compute queue
};

// Scope of timestamps. Pass timestamps delay the passes a little, since each one serialises its neighbours.
enum class Timed : uint8_t { frame, passes };

// Command buffers and number of a frame with a piece on the async compute queue.
struct Fork {
  ForkedCommands commands;  // recording begins in `before`
  uint64_t number = 0;      // distinct on the device, never 0
  bool times_async = false;
};

// Makes all earlier work of the stages `before` visible to all later work of the stages `after`. For
// resources of unknown state.
void wait_for(VkCommandBuffer commands, VkPipelineStageFlags2 before, VkPipelineStageFlags2 after);

class Recorder {
 public:
  // queries may be null: no timestamps. The pool must be reset and hold max_queries.
  Recorder(VkCommandBuffer commands, VkQueryPool queries, uint32_t max_queries,
           std::optional<Fork> fork = std::nullopt, Timed timed = Timed::passes)
      : commands_(commands),
        queries_(queries),
        max_queries_(max_queries),
        fork_(std::move(fork)),
        timed_(timed) {}

  // name: static storage.
  void pass(const char* name, std::initializer_list<Use> uses,
            const std::function<void(VkCommandBuffer)>& record) {
    pass(name, std::span<const Use>(uses.begin(), uses.size()), record);
  }
  void pass(const char* name, std::span<const Use> uses, const std::function<void(VkCommandBuffer)>& record);
  // Copies to the host at the end of the frame, or before either buffer is written again. All copies run
  // together, because a copy between passes stalls them. `into` is borrowed until finish(). Timed as the pass
  // "counts".
  void copy_at_end(const Buffer& from, Buffer& into, std::vector<VkBufferCopy> regions);
  // Moves the copies requested so far from the end of the frame to the next pass of the main queue,
  // overlapped with it.
  void overlap_copies_with_next() { overlaps_copies_ = true; }
  // Records barriers only: hands a resource to a user outside the passes (the host, a presentation engine).
  void transition(std::initializer_list<Use> uses);

  // Records commands that overlap with the following passes on the async compute queue, or inline without
  // one. Call it at most once a frame, with buffers only. A later pass waits if it declares a resource that
  // the async piece has written, or writes one that it reads. The end of the frame always waits. wait_name:
  // static storage; name of the main queue's wait time.
  void async_compute(const char* wait_name, const std::function<void()>& record);
  // Ends recording. Returns the pieces of a forked frame.
  std::optional<ForkedCommands> finish();

  VkCommandBuffer commands() const { return commands_; }
  const std::vector<PassTimestamps>& timestamps() const { return timestamps_; }
  bool times_passes() const { return timed_ == Timed::passes; }

 private:
  enum class Piece : uint8_t { before, async_compute, overlapped, after };

  struct CopyAtEnd {
    VkBuffer from;
    Buffer* into;
    std::vector<VkBufferCopy> regions;
  };

  void barriers(std::span<const Use> uses);
  void record_copies();
  void begin_copies();
  void end_copies();
  bool overlaps_copies_now() const;
  void copy_before_overwrite(std::span<const Use> uses);
  bool depends_on_async(std::span<const Use> uses) const;
  bool is_ordered_by_fork(UseState& state, const Access& next);
  void join();
  void continue_in(VkCommandBuffer commands, Piece piece);
  void begin_frame_time();
  void end_frame_time();
  std::optional<uint32_t> write_timestamps_begin();
  void write_timestamps_end(const char* name, std::optional<uint32_t> begin_query);

  VkCommandBuffer commands_;
  VkQueryPool queries_;
  uint32_t max_queries_;
  std::optional<Fork> fork_;
  Timed timed_;
  Piece piece_ = Piece::before;
  const char* wait_name_ = nullptr;
  uint32_t next_query_ = 0;
  std::vector<PassTimestamps> timestamps_;
  std::vector<CopyAtEnd> copies_at_end_;
  std::vector<CopyAtEnd> copies_begun_;  // overlapped with a pass; not waited for yet
  bool overlaps_copies_ = false;
};

}  // namespace fire3dv::gpu
