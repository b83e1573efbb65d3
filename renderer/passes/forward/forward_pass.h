// Forward raster pipeline with sorted multi-draw-indirect, vertex pulling and PBR. It draws the whole scene
// into multisampled linear HDR colour, as the reference image. On the compute path it adds the forward-only
// draws: blended surfaces, lines and points.
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "renderer/gpu/device/vk.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/layers/layer_pass.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/shadows/shadow_pass.h"
#include "renderer/passes/view/view.h"
#include "renderer/settings/background.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

class ForwardPass {
 public:
  ForwardPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples);

  struct Frame {
    GpuScene& scene;
    const scene::Scene& source;
    const state::PoseState& poses;
    Targets& targets;
    const View& view;
    VkDeviceAddress globals;
    const settings::Background& background;
    ShadowPass* shadows;                  // null: none, or rays in the fragment shader
    ClusterTarget* visibility = nullptr;  // non-null: draws only forward-only surfaces over this buffer's
                                          // image, whose colour is already in the target
    VkRect2D area;                        // scissor in the image
    bool in_layers = false;               // leaves blended surfaces to layer_draws()
  };
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Frame& frame);
  // Blended surfaces of the frame that record() got last; valid while that lives.
  LayerDraws layer_draws(const Frame& frame);
  void invalidate() { commands_revision_ = UINT64_MAX; }

 private:
  struct BinCommands {
    VkBuffer buffer;
    VkDeviceSize offset;
    std::vector<uint32_t> batches;  // number of commands of each
  };
  enum class Stage : uint8_t { depth, color, layer_keys, layer_light };
  bool knows_visible_samples() const;  // shading is evaluated at the mean of a pixel's visible samples
  // material_flags: as in GpuScene.
  const gpu::Pipeline& pipeline(const DrawBin& bin, Stage stage, uint32_t material_flags);
  std::vector<BinCommands> bin_commands(gpu::StagingRing& staging, const Frame& frame) const;
  void begin(VkCommandBuffer commands, const Frame& frame, Stage stage, bool goes_on = false) const;
  void draw_bins(VkCommandBuffer commands, const Frame& frame, Stage stage, bool blended,
                 const std::vector<BinCommands>& bin_commands);
  void draw_bin(VkCommandBuffer commands, const DrawBin& bin, const BinCommands& bin_commands,
                const Frame& frame) const;
  void draw_layers(VkCommandBuffer commands, const Frame& frame, const LayerStep& step);
  void draw_visible_depth(VkCommandBuffer commands, const Frame& frame);
  void upload_commands(gpu::Recorder& recorder, gpu::StagingRing& staging, const GpuScene& scene);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  VkSampleCountFlagBits samples_;
  std::map<std::tuple<scene::Topology, scene::AlphaMode, Stage, uint32_t>, gpu::Pipeline>
      pipelines_;  // created on first use
  gpu::Pipeline background_, visible_depth_;
  std::vector<BinCommands> bin_commands_;    // of the last record()
  gpu::Buffer commands_;                     // VkDrawIndexedIndirectCommand[], one per draw of the list
  uint64_t commands_revision_ = UINT64_MAX;  // draw list revision of commands_
};

// Screen-space bounds of forward-only draws (blended surfaces, lines, points).
// Empty where none is in view. The whole image for unknown bounds: deformed meshes, and boxes that cross the
// eye plane.
VkRect2D forward_bounds(const GpuScene& gpu_scene, const scene::Scene& scene, const state::PoseState& poses,
                        const View& view, VkExtent2D extent);

}  // namespace fire3dv::passes
