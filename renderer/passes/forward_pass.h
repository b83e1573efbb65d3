// Draws the scene into multisampled linear HDR colour: sorted multi-draw-indirect, vertex pulling, PBR, shadows by ray
// query in the fragment shader. The reference for how an image has to look.
#pragma once

#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/passes/environment.h"
#include "renderer/passes/gpu_scene.h"
#include "renderer/passes/targets.h"
#include "renderer/passes/view.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

class ForwardPass {
 public:
  ForwardPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples);

  // globals: device address of the frame's Globals.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& scene, const scene::Scene& source,
              const state::PoseState& poses, Targets& targets, const View& view, VkDeviceAddress globals,
              const Background& background);
  void forget() { commands_revision_ = UINT64_MAX; }

 private:
  struct BinCommands {
    VkBuffer buffer;
    VkDeviceSize offset;
  };
  const gpu::Pipeline& pipeline(scene::AlphaMode mode) const;
  void draw_bin(VkCommandBuffer commands, const DrawBin& bin, const BinCommands& bin_commands) const;
  void upload_commands(gpu::Recorder& recorder, gpu::UploadBelt& belt, const GpuScene& scene);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline depth_only_, opaque_, mask_, blend_, background_;
  gpu::Buffer commands_;                     // VkDrawIndexedIndirectCommand[], one per draw of the list
  uint64_t commands_revision_ = UINT64_MAX;  // of the draw list that they were made for
};

}  // namespace fire3dv::passes
