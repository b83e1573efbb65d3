// Output planes derived from ids and depths.
//
// With four samples, the primitive instance with most samples of a pixel wins. Ties select the nearest one
// with a triangle over the centre, then the background, then the first sample. Depth is that at the centre,
// or the mean over the instance's samples if none of its triangles covers the centre.
#pragma once

#include <memory>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/outputs/camera_history.h"
#include "renderer/passes/outputs/flow_pass.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/outputs/silhouettes_pass.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/view/view.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Of CameraHistory::poses.
VkDeviceSize snapshot_bytes(const GpuScene& scene);

class OutputsPass {
 public:
  // samples: 1 or 4.
  OutputsPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples);

  // A new scene is drawn from now on.
  void set_scene() {
    ++scenes_;
    labels_ = {};
    silhouettes_.set_scene();
  }

  // Reports that nodes have moved since the last record().
  void invalidate_snapshot() { current_snapshot_.reset(); }
  // Images of one submission. has_history: record() updates histories.
  struct Images {
    ImageOutputs outputs;
    VkExtent2D extent;  // of a view
    uint32_t views;
    bool has_history;
    bool has_flow, keeps_surfaces;
    ReplacedMemory replaced;  // by record(); see FrameRequest
    bool common;              // record() may write all views in one dispatch
  };
  // Returns an error when histories reference so many buffers that the memory limit leaves no room for those
  // of these images.
  Result<void> check_room_for_histories(const Images& images, const GpuScene& scene) const;
  // Allocates the planes, the motion snapshot and the depths of histories. Call it before any pass that
  // writes them; repeated calls are allowed. Planes of several views are stacked vertically.
  void begin(const Images& images, const SilhouettesPass::Shown& shown);

  // Source of the images.
  struct Source {
    const scene::Scene& scene;
    GpuScene& gpu_scene;
    gpu::Buffer& visibility;  // before the coverage merge
    std::span<const View> views;
    std::span<const VkDeviceAddress> globals;  // per view
    float label_alpha = 0.5f;                  // settings::DrawSettings
    const scene::SceneEdits* edits = nullptr;  // null: none
    const CameraHistory* flow_from = nullptr;  // see FrameRequest
    bool keeps_surfaces = false;
    bool common = false;  // writes all views in one dispatch
  };
  // histories: one per view, or empty without motion; updated to these images.
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
              std::span<CameraHistory> histories);

  gpu::Buffer& planes() { return planes_; }
  gpu::Buffer& flow() { return flow_.result(); }
  const std::vector<PlaneRange>& places() const { return places_; }
  VkDeviceAddress address_of(ImageOutput output) const;  // 0: not requested

 private:
  void make_pipeline(bool surfaces, bool common, gpu::Compile when);
  void upload_labels(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source);
  gpu_types::OutputsWanted wanted_of_first_view() const;
  // Completes those of the first view for another.
  void set_view(gpu_types::OutputsWanted& parameters, const Source& source, uint32_t view,
                const CameraHistory* last) const;
  void write(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
             gpu::Buffer& visibility, std::span<CameraHistory> histories);
  void update_histories(gpu::Recorder& recorder, const Source& source, std::span<CameraHistory> histories);
  void keep_poses(gpu::Recorder& recorder, GpuScene& scene);
  void mark_hidden(gpu::Recorder& recorder, GpuScene& scene);
  void record_flow(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source);
  void keep_surfaces(gpu::Recorder& recorder, const Source& source, gpu::Buffer& visibility,
                     CameraHistory& history);
  void keep_depths(gpu::Recorder& recorder, std::span<CameraHistory> histories);
  // Buffers referenced by histories, or free.
  using Pool = std::vector<std::shared_ptr<gpu::Buffer>>;
  std::shared_ptr<gpu::Buffer> take_free(Pool& pool, VkDeviceSize bytes);
  VkDeviceSize view_bytes(ImageOutput output) const;

  gpu::Device& device_;
  VkPipelineLayout layout_;
  // Without and with planes of materials, position and occlusion; a dispatch for each view, and for all:
  // these are made by begin().
  gpu::Pipeline pipelines_[2][2];
  SilhouettesPass silhouettes_;
  FlowPass flow_;
  gpu::Buffer planes_;
  gpu::Buffer labels_;  // PartLabels[part]
  Pool snapshots_, depths_, surfaces_;
  std::shared_ptr<gpu::Buffer> current_snapshot_;  // of this frame; null: no snapshot yet
  std::vector<PlaneRange> places_;
  VkExtent2D extent_{};  // of a view
  uint32_t samples_;
  uint64_t scenes_ = 0;
};

}  // namespace fire3dv::passes
