// Frame receiver of one stream: assembles pose frames, orders them after their scene edits, buffers them for
// playout and monitors liveness. It knows neither a scene nor other streams. Memory is charged to the peer's
// budget. Times in nanoseconds on the local monotonic clock. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/stream/frame_assembler.h"
#include "protocol/stream/input_registry.h"
#include "protocol/stream/scalar_history.h"
#include "protocol/wire/messages.h"
#include "renderer/state/playout.h"
#include "renderer/state/stream_edits.h"
#include "renderer/state/stream_timing.h"

namespace fire3dv::state {

// Shown frame of a stream, and counters of its messages. Only FrameReceiver writes these.
struct ReceivedFrames {
  uint64_t epoch = 0;
  std::vector<wire::Affine3x4> poses;     // the shown frame: stream_from_body
  wire::PoseFrameHeader header;           // of the shown frame; sequence 0: none yet
  uint64_t revision = 0;                  // incremented when poses change
  Condition condition = Condition::live;  // as of the last advance(); not live: the shown frame is stale
  bool interpolated = false;
  uint64_t frames_received = 0;    // whole frames that were shown or buffered for playout
  uint64_t frames_incomplete = 0;  // superseded before all their parts arrived
  uint64_t frames_stale = 0;       // wrong epoch, duplicates, or not newer than the shown frame
  // Wrong node count, contradicting parts, or over the peer's budget.
  uint64_t frames_refused = 0;
  uint64_t frames_without_base = 0;  // partial frames before the first whole one
  uint64_t frames_queued = 0;        // whole frames queued for scene edits
  uint64_t frames_superseded = 0;    // queued frames that newer ones replaced
  uint64_t edits_received = 0;       // accepted scene edits
  uint64_t edits_stale = 0;          // wrong epoch, or not newer than the received ones
  uint64_t edits_refused = 0;        // over the limits of a stream
  uint64_t scalars_unmatched = 0;    // values of scalars without a matching declaration; they have no effect
};

class FrameReceiver : public ReceivedFrames {
 public:
  FrameReceiver() = default;  // a closed stream
  // One run of a stream with this number of nodes. budget null: no limits.
  FrameReceiver(uint64_t epoch, size_t node_count, std::shared_ptr<PeerBudget> budget = nullptr);

  // Receives a whole frame, a part or a partial frame. Returns true if the shown frame changed.
  // published_ns: estimated publish time; received_ns 0: unknown, not counted for liveness.
  bool push(const wire::PoseFrameView& frame, int64_t published_ns = 0, int64_t received_ns = 0);

  // Receives a scene edit. Returns true if a queued frame became shown.
  bool apply(wire::SceneEdit&& edit);
  bool apply(const wire::UnknownEdit& edit);
  const stream::ScalarHistory& scalars() const { return scalars_; }
  const stream::InputRegistry& inputs() const { return inputs_; }
  // Accepted edits since the last call.
  StreamEdits::Batch take_edits() { return edits_.take(); }
  bool has_new_edits() const { return edits_.has_new(); }
  bool has_applied_edits() const { return edits_.has_applied(); }
  // Assets and replaced vertices load on another thread: frames wait for finish_edit() of their version.
  void load_assets_asynchronously() { edits_.load_assets_asynchronously(); }
  // Returns true if the shown frame changed.
  bool finish_edit(uint64_t version);

  // Enables the playout buffer; see PoseState::interpolate().
  void interpolate(std::optional<int64_t> fixed_delay_ns);
  // Disables it and shows the newest frame.
  void show_newest(int64_t now_ns);
  int64_t delay_ns() const { return playout_ ? playout_->delay_ns() : 0; }  // 0 without a playout buffer
  std::vector<float> gaps_ms() const { return liveness_.gaps_ms(); }        // see Liveness::gaps_ms()

  // Updates the condition and shows the buffered frame that is due. Returns true if the poses changed.
  bool advance(int64_t now_ns);
  // Shows a frame immediately. It has one pose per node.
  void show(const wire::PoseFrameHeader& shown, std::span<const wire::Affine3x4> shown_poses);

  struct Refusal {
    Resource resource = Resource::pose_bytes;
    std::string message;
  };
  // Returns and clears the refusals by the budget since the last call; the first one of each resource.
  std::vector<Refusal> take_refusals() { return std::exchange(refusals_, {}); }

  size_t node_count() const { return node_count_; }
  const stream::FrameAssembler& assembler() const { return assembler_; }
  const std::shared_ptr<PeerBudget>& budget() const { return budget_; }

 private:
  // A whole frame on its way through the receiver.
  struct Frame {
    const wire::PoseFrameHeader& header;
    std::span<const wire::Affine3x4> poses;
    int64_t published_ns = 0;
    int64_t received_ns = 0;
  };
  bool push_partial(const wire::PoseFrameView& frame, int64_t published_ns, int64_t received_ns);
  bool push_whole(const Frame& frame);
  bool accept(const Frame& frame);
  bool complete_partial(const Frame& frame);
  bool release_queued();
  bool apply_scalars(const wire::SceneEdit& edit);
  bool apply_input(const wire::SceneEdit& edit);
  bool count_edit(StreamEdits::Outcome outcome);
  void report_refusal(Resource resource, const std::string& message);
  bool refuse_frame();

  std::shared_ptr<PeerBudget> budget_;
  size_t node_count_ = 0;
  stream::FrameAssembler assembler_;
  std::optional<Playout> playout_;
  Liveness liveness_;
  StreamEdits edits_;
  stream::ScalarHistory scalars_;
  stream::InputRegistry inputs_;
  FrameQueue queue_;
  uint64_t newest_sequence_ = 0;               // newest received frame: shown, buffered or queued
  bool newest_is_partial_ = false;             // a whole frame of the same sequence may complete it
  std::vector<wire::Affine3x4> newest_poses_;  // with playout: base of partial frames
  std::vector<wire::Affine3x4> merged_;        // scratch memory of partial frames
  stream::PoseMemory memory_;                  // charges for poses, newest_poses_ and merged_
  std::vector<Refusal> refusals_;
  uint32_t reported_refusals_ = 0;  // bit mask of resources
};

}  // namespace fire3dv::state
