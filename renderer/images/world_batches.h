// Renderer of batches: image requests with the poses of several worlds (wire::ImageBatch). It has a copy of
// the displayed scene of its own, so that the images of everybody else keep one world. Single-threaded.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/peer_budget.h"
#include "renderer/gpu/device/resources.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/images/image_camera.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/state/image_request_registry.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// Settings of batches: those of other images, but without FXAA, and with small shadow maps instead of other
// shadows.
settings::DrawSettings batch_settings(settings::DrawSettings settings);

class WorldBatches {
 public:
  using Due = state::ImageRequestRegistry::Due;

  // Borrows the device.
  explicit WorldBatches(gpu::Device& device) : device_(device) {}
  ~WorldBatches();
  WorldBatches(const WorldBatches&) = delete;
  WorldBatches& operator=(const WorldBatches&) = delete;

  // What is drawn, and on whose account.
  struct Source {
    const wire::StreamDescription& stream;  // of the requester
    const LiveScene& scene;
    const passes::SceneRenderer& displayed;  // of other images, shows the scene
    const settings::DrawSettings& settings;  // of other images
    std::shared_ptr<PeerBudget> budget;      // charged for the worlds until release(); null: no limits
    uint32_t hidden_streams = 0;
  };
  // Begins a batch: worlds, poses and views. Precondition: none is being drawn. Returns a refusal if there
  // will be no image. A batch without active worlds is finished at once.
  std::optional<CameraRefused> begin(const Due& due, const Source& source);
  // The batch that was begun, until its last submission; nullptr: none.
  const Due* drawn() const { return drawing_ ? &drawing_->due : nullptr; }
  // False if the scene was replaced since the batch was begun: cancel it, and begin again.
  bool shows(const LiveScene& scene) const { return shown_scene_ == scene.replaced(); }
  // Submits the next views of it, as many as fit, so that others have their turns between. Returns a refusal
  // if there will be no image. Precondition: drawn(), and shows() the scene.
  struct Submitted {
    uint32_t views = 0;
    std::optional<CameraRefused> refused;
  };
  Submitted go_on(gpu::FrameRing& frames);
  // Ends it without an image, after a wait for what is submitted.
  void cancel();

  // Delivers finished batches in order.
  using Fill = std::function<void(std::span<std::byte> pixels)>;
  using Take = std::function<void(state::RequesterId requester, const wire::ImageFrame&, const Fill& fill)>;
  void deliver(const Take& take);
  size_t in_flight() const { return pending_.size(); }

  // The requester whose worlds these are; nullopt: there are none.
  std::optional<state::RequesterId> owner() const {
    return owner_ ? std::optional(owner_->requester) : std::nullopt;
  }
  // Frees worlds and scene, after a wait for the device. Submitted batches are still delivered.
  void release();

 private:
  // Of whom the worlds show poses: their names are bound to nodes for one stream at a time.
  struct Owner {
    state::RequesterId requester = 0;
    uint64_t epoch = 0;
    std::vector<uint32_t> node_indices;
    BudgetCharge device_memory, host_memory;
  };
  struct Pending {
    state::RequesterId requester = 0;
    wire::ImageFrame frame;
    wire::SharedImageBatch batch;
    gpu::Buffer pixels;
    uint64_t done_at = 0;  // timeline value
  };
  struct Drawing {
    Due due;
    Pending pending;
    std::vector<passes::View> views;  // of active worlds
    std::vector<uint32_t> numbers;    // of these views in the request, rising
    size_t at_once = 0;               // views of a submission
    size_t next = 0;                  // view of the next one
  };
  std::optional<CameraRefused> take_worlds(const Due& due, const Source& source);
  std::optional<CameraRefused> charge(const Due& due, const Source& source);
  std::optional<CameraRefused> show(const Source& source, uint32_t worlds);
  std::optional<CameraRefused> bind(const Due& due, const Source& source);
  void drop_worlds();
  void unbind();
  void set_poses(const wire::ImageBatch& batch);
  Pending make_answer(const Due& due, uint32_t hidden_streams) const;
  size_t views_of_submission(const wire::Intrinsics& size, size_t views) const;
  Result<void> submit(gpu::FrameRing& frames);
  void read_back(gpu::Recorder& recorder, const wire::ImageRequest& request,
                 std::span<const uint32_t> numbers, Pending& pending);

  gpu::Device& device_;
  std::optional<passes::SceneRenderer> renderer_;
  std::optional<uint64_t> shown_scene_;  // its LiveScene::replaced()
  uint32_t world_count_ = 0;             // of the renderer's scene
  std::optional<Owner> owner_;
  std::deque<state::PoseState> worlds_;  // as many as world_count_
  std::vector<const state::PoseState*> world_pointers_;
  std::vector<state::StreamId> streams_;  // of the first worlds: those that are bound
  uint64_t sequence_ = 0;                 // of the last frame of the worlds
  std::optional<Drawing> drawing_;
  std::deque<Pending> pending_;  // submitted as a whole
  std::vector<gpu::Buffer> free_buffers_;
};

}  // namespace fire3dv::app
