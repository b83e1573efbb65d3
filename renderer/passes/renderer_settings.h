// Draw settings on a device: what they come to there, which of them later frames may change, and which images
// they allow.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/error.h"
#include "renderer/gpu/device/vk.h"
#include "renderer/passes/frame_request.h"
#include "renderer/passes/shadows/shadow_plan.h"
#include "renderer/settings/debug_view.h"
#include "renderer/settings/draw_settings.h"

namespace fire3dv::gpu {
class Device;
}

namespace fire3dv::passes {

// Facts of a scene that limit its images.
struct SceneLimits {
  bool may_have_forward_only = false;  // has forward-only draws, hidden or not
  bool cameras_have_lenses = false;
  bool refracts = false;  // as GpuScene
};

class RendererSettings {
 public:
  RendererSettings(const gpu::Device& device, const settings::DrawSettings& settings);

  // Of later frames, without the environment image, of which the GPU has a copy.
  const settings::DrawSettings& draw() const { return draw_; }
  settings::RasterPath raster_path() const { return path_; }  // never automatic
  VkSampleCountFlagBits samples() const { return samples_; }
  uint32_t compute_samples() const { return samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1; }
  const ShadowTechnique& shadow_technique() const { return shadow_technique_; }
  bool shadows_on() const { return shadows_on_; }
  bool traces_paths() const { return draw_.path.has_value(); }
  // The forward path takes ray origins from a visibility buffer, where its fragment shader cannot trace rays.
  bool has_visibility_buffer() const;
  bool can_write_samples() const;  // compute shading writes multisampled HDR colour
  bool has_ray_effects() const { return has_ray_effects_; }
  // Transmissive surfaces, by ray effects. Without storage of samples, scenes with blended surfaces are drawn
  // forward, where no light is refracted.
  bool refracts() const { return refracts_; }
  // scene_refracts: GpuScene::refracts.
  bool traces_ray_effects(bool scene_refracts) const;
  // Lens of the raster or of paths; a pinhole: none.
  const scene::ThinLens& lens() const { return draw_.path ? draw_.path->lens : draw_.post.lens; }
  bool has_depth_of_field(const SceneLimits& scene, bool view_has_lens = false) const;

  // See SceneRenderer.
  void apply(const settings::DrawSettings& settings);
  bool needs_new_renderer(const settings::DrawSettings& settings) const;
  Result<void> can_take(const ImageOutputs& outputs, uint32_t views, const SceneLimits& scene) const;
  Result<void> can_show(settings::DebugView view) const;
  Result<void> can_inspect() const;
  Result<void> can_blur() const;

 private:
  // What a visibility buffer needs that this raster path lacks, for messages.
  std::string without_visibility_buffer() const;
  void drop_fxaa();
  bool can_refract(const settings::DrawSettings& settings) const;

  const gpu::Device& device_;
  settings::DrawSettings draw_;
  std::weak_ptr<const scene::EnvironmentImage> environment_source_;  // empty: the studio
  bool uses_studio_;
  settings::RasterPath path_;
  VkSampleCountFlagBits samples_;
  ShadowTechnique shadow_technique_;
  bool shadows_on_ = true;
  bool has_ray_effects_;
  bool refracts_;
};

}  // namespace fire3dv::passes
