// Path tracer: a reference image of the scene, with the materials of the raster (shaders/path/path.glsl).
//
// The bytes of an image depend on scene, view, settings and device alone: random numbers are hashes of pixel,
// sample and seed, and each pixel sums its samples in their order. How the work is split into submissions
// does not matter.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/shadows/shadow_plan.h"
#include "renderer/passes/view.h"
#include "renderer/scene/textures/environment.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct PathSettings {
  uint32_t samples_per_pixel = 256;
  uint32_t bounces = 8;  // after the first surface; 0: direct light
  uint32_t seed = 0;
  scene::ThinLens lens;                     // instead of the camera's, unless it is a pinhole
  RayBackEnd back_end = RayBackEnd::query;  // preferred; the other one is the fallback
  // Work of one dispatch; 0: chosen by the device. Without influence on the image.
  uint32_t pixels_per_dispatch = 0;
  uint32_t segments_per_dispatch = 0;  // rays of each path
};

// What paths ignore or approximate in this scene, one sentence each.
std::vector<std::string> path_tracing_limits(const scene::Scene& scene);

// Returns an error where the device cannot trace paths.
Result<void> can_trace_paths(const gpu::Device& device);
// Text for the user.
const char* describe_path_back_end(RayBackEnd back_end);

class PathPass {
 public:
  struct Hooks {
    std::function<void(uint64_t done, uint64_t total)> progress;  // null: none
    std::function<bool()> should_stop;                            // null: never
  };

  PathPass(gpu::Device& device, VkPipelineLayout layout, const PathSettings& settings,
           const scene::EnvironmentImage& environment);

  // Ring of the submissions, apart from the frames of the caller.
  gpu::FrameRing& submissions() { return submissions_; }
  RayBackEnd back_end() const { return back_end_; }
  // Allocates buffers and records the start of an image. globals: with the addresses of this frame.
  void begin(gpu::Recorder& recorder, const gpu_types::Globals& globals, const View& view);
  // Submits all samples, each submission short enough for other users of the device. Returns false if
  // should_stop ended it; then there is no image.
  bool trace(GpuScene& scene, const Hooks& hooks);
  // Sums of the traced image, for bloom.
  struct Sums {
    gpu::Buffer& buffer;  // gpu_types::PathSum[pixel]
    uint32_t samples_per_pixel;
  };
  Sums sums() { return {sums_, settings_.samples_per_pixel}; }
  // Creates the variant with bloom, and binds it to targets with a bloom chain.
  void bind_bloom(Targets& targets);
  // Records tone mapping of the sums to targets.display, and the linear plane if requested. With bloom,
  // targets.bloom has the light of this image.
  void resolve(gpu::Recorder& recorder, Targets& targets, const PostSettings& post,
               const PostPass::Linear& linear, const MeteredExposure& metered);

 private:
  struct Variant {
    bool extensions = true, textures = true, second_uv = true, masked = true;
    uint32_t material_flags = 0;
    bool operator==(const Variant&) const = default;
  };
  void use_pipeline(const GpuScene& scene);
  void record_sample(gpu::Recorder& recorder, GpuScene& scene, gpu_types::PathPush push);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  PathSettings settings_;
  RayBackEnd back_end_;
  gpu::FrameRing submissions_;
  gpu::Pipeline pipeline_;  // of ray queries
  gpu::RayPipeline ray_pipeline_;
  Variant variant_;
  ImageFilter resolve_;
  std::unique_ptr<ImageFilter> resolve_bloom_;  // created on first use
  gpu::Buffer cells_;                           // EnvironmentCell[]; null: the environment is black
  glm::uvec2 cells_size_{0};
  // PathParameters, trace commands of a whole and of the last band, and Globals; PathSum[pixel];
  // PathState[pixel of a band].
  gpu::Buffer constants_, sums_, states_;
  uint32_t pixel_count_ = 0, band_pixels_ = 0, segments_ = 0;
};

}  // namespace fire3dv::passes
