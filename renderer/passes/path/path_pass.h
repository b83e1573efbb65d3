// Path tracer: a reference image of the scene, with the materials of the raster (shaders/path/path.glsl).
//
// The bytes of an image depend on scene, view, settings and device alone: random numbers are hashes of pixel,
// sample and seed, and each pixel sums its samples in their order. How the work is split into submissions
// does not matter. So an image may be shown while it refines, and go on later.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/path/path_hooks.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/shader_variant.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/shadows/shadow_plan.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/textures/environment.h"
#include "renderer/settings/path_settings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// What paths ignore or approximate in this scene, one sentence each.
std::vector<std::string> path_tracing_limits(const scene::Scene& scene);

// Returns an error where the device cannot trace paths.
Result<void> can_trace_paths(const gpu::Device& device);
// Text for the user.
const char* describe_path_back_end(settings::RayBackEnd back_end);

class PathPass {
 public:
  PathPass(gpu::Device& device, VkPipelineLayout layout, const settings::PathSettings& settings,
           const scene::EnvironmentImage& environment);

  // Ring of the submissions, apart from the frames of the caller.
  gpu::FrameRing& submissions() { return submissions_; }
  settings::RayBackEnd back_end() const { return back_end_; }
  // Settings of later images. A new number of samples also applies to the current image.
  void set(const settings::PathSettings& settings) { settings_ = settings; }
  const settings::PathSettings& settings() const { return settings_; }
  // Selects the image that the other functions are about, by a number of the caller; at the start 0. The
  // images selected before it, kMaxOtherImages of them, keep their samples.
  static constexpr size_t kMaxOtherImages = 5;
  void select(uint64_t image);
  // Frees an image that is not selected.
  void forget(uint64_t image);
  // Allocates the buffers of an image. shows_previous_image: also those of the image before it, which is
  // shown until the first sample is whole. Throws VulkanFailure when memory is short; then there is no image.
  void allocate(uint64_t pixel_count, bool shows_previous_image);
  // Records the start of an image into a frame of submissions(). globals: with the addresses of this frame.
  void begin(gpu::Recorder& recorder, const gpu_types::Globals& globals, const View& view,
             const std::optional<PathSamples>& resume = std::nullopt);
  // True if begin() would start the current image again: same scene buffers, view and settings.
  bool is_current(const gpu_types::Globals& globals, const View& view) const;
  // True if there is an image of this size without a whole first sample.
  bool has_begun(uint32_t width, uint32_t height) const;
  // Ends the selected image; the next one begins anew.
  void drop_selected() { current_.key.clear(); }
  // Ends all images.
  void drop() {
    drop_selected();
    others_.clear();
  }
  // Submits samples, each submission short enough for other users of the device. Returns false if should_stop
  // ended it; then there is no image.
  bool trace(GpuScene& scene, const PathHooks& hooks);
  settings::PathProgress progress() const;
  // Of the image that resolve() shows.
  uint32_t shown_samples() const { return (shows_last() ? last_ : current_).samples(); }
  // Sums of the image that resolve() shows, gpu_types::PathSum[pixel], for bloom and exposure.
  gpu::Buffer& sums() { return shown().sums; }
  // Creates the variant with bloom, and binds it to targets with a bloom chain.
  void bind_bloom(Targets& targets);
  // Records tone mapping of the sums to targets.display, and the linear plane if requested. With bloom,
  // targets.bloom has the light of this image.
  void resolve(gpu::Recorder& recorder, Targets& targets, const settings::PostSettings& post,
               const PostPass::Linear& linear, const MeteredExposure& metered);

 private:
  struct Image {
    gpu::Buffer sums;  // PathSum[pixel]
    // PathParameters, trace commands of a whole and of the last band, and Globals.
    gpu::Buffer constants;
    uint32_t width = 0, height = 0, bands = 0, band_pixels = 0;
    uint32_t segments = 0, all_segments = 0;  // of a dispatch, and of a path
    uint64_t bands_done = 0;                  // band after band of each sample
    std::vector<std::byte> key;               // everything that decides it; empty: it does not go on
    uint32_t samples() const { return bands == 0 ? 0 : static_cast<uint32_t>(bands_done / bands); }
  };
  bool shows_last() const;
  Image& shown() { return shows_last() ? last_ : current_; }
  uint32_t band_pixels() const;  // of a large image
  gpu_types::PathParameters make_parameters(const gpu_types::Globals& globals, const View& view) const;
  void use_pipeline(const GpuScene& scene);
  void save(const PathHooks& hooks);
  void record_sample(gpu::Recorder& recorder, GpuScene& scene, gpu_types::PathPush push);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  settings::PathSettings settings_;
  settings::RayBackEnd back_end_;
  gpu::FrameRing submissions_;
  gpu::Pipeline pipeline_;  // of ray queries
  gpu::RayPipeline ray_pipeline_;
  RayVariant variant_;
  ImageFilter resolve_;
  std::unique_ptr<ImageFilter> resolve_bloom_;  // created on first use
  gpu::Buffer cells_;                           // EnvironmentCell[]; null: the environment is black
  glm::uvec2 cells_size_{0};
  gpu::Buffer states_;    // PathState[pixel of a band]
  Image current_, last_;  // last_: the one before, while images refine
  uint64_t selected_ = 0;
  std::vector<std::pair<uint64_t, Image>> others_;  // with samples, the last selected one at the end
  uint32_t bands_per_submission_ = 1;
  gpu::Buffer saved_;  // sums in host memory; created on first use
};

}  // namespace fire3dv::passes
