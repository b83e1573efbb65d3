#include "renderer/passes/renderer_settings.h"

#include "renderer/gpu/device/device.h"
#include "renderer/passes/ray_effects/ray_effects_pass.h"
#include "renderer/settings/setting_table.h"

namespace fire3dv::passes {
namespace {

settings::RasterPath choose_path(const gpu::Device& device, settings::RasterPath wanted) {
  return wanted != settings::RasterPath::forward && device.report().int64_atomics
             ? settings::RasterPath::visibility
             : settings::RasterPath::forward;
}

// Largest sample count that the device supports and the settings allow.
VkSampleCountFlagBits choose_samples(const gpu::Device& device, settings::RasterPath path, uint32_t wanted) {
  const VkSampleCountFlags possible =
      device.limits().framebufferColorSampleCounts & device.limits().framebufferDepthSampleCounts;
  if (path == settings::RasterPath::visibility) wanted = wanted >= 4 ? 4 : 1;  // counts of the compute path
  for (uint32_t count = 16; count > 1; count /= 2) {
    if (count <= wanted && (possible & count)) return static_cast<VkSampleCountFlagBits>(count);
  }
  return VK_SAMPLE_COUNT_1_BIT;
}

}  // namespace

RendererSettings::RendererSettings(const gpu::Device& device, const settings::DrawSettings& settings)
    : device_(device),
      draw_(settings),
      environment_source_(settings.environment),
      uses_studio_(!settings.environment),
      path_(choose_path(device, settings.raster)),
      samples_(choose_samples(device, path_, settings.samples)),
      shadow_technique_(settings.path ? ShadowTechnique()  // paths trace shadows themselves
                                      : choose_shadow_technique(device, settings.shadows,
                                                                path_ == settings::RasterPath::visibility)),
      has_ray_effects_(settings.ray_effects.on.any() && !settings.path &&
                       can_trace_ray_effects(device, path_ == settings::RasterPath::visibility)),
      refracts_(can_refract(settings)) {
  draw_.environment.reset();
  drop_fxaa();
}

// Paths have no jagged edges, and a sensor takes the mean light of its pixels, with noise that stays.
void RendererSettings::drop_fxaa() {
  if (traces_paths() || draw_.post.optics.any()) draw_.post.fxaa = false;
}

bool RendererSettings::has_visibility_buffer() const {
  return path_ == settings::RasterPath::visibility ||
         shadow_technique_.back_end == settings::RayBackEnd::pipeline;
}

bool RendererSettings::can_write_samples() const {
  return has_visibility_buffer() && (compute_samples() == 1 || device_.report().multisample_storage);
}

bool RendererSettings::can_refract(const settings::DrawSettings& settings) const {
  return has_ray_effects_ && settings.ray_effects.on.refraction && can_write_samples();
}

bool RendererSettings::traces_ray_effects(bool scene_refracts) const {
  const settings::RayEffects& on = draw_.ray_effects.on;
  return has_ray_effects_ && (on.reflections || on.ambient_occlusion || on.bounce || scene_refracts);
}

bool RendererSettings::has_depth_of_field(const SceneLimits& scene, bool view_has_lens) const {
  return (view_has_lens || scene.cameras_have_lenses || !draw_.post.lens.is_pinhole()) && can_blur();
}

void RendererSettings::apply(const settings::DrawSettings& settings) {
  copy_applicable(settings, draw_);
  shadows_on_ = settings.shadows.method != settings::ShadowMethod::off;
  draw_.ray_effects.occlusion_distance_m = settings.ray_effects.occlusion_distance_m;
  drop_fxaa();
  if (traces_paths() && settings.path) draw_.path = settings.path;
}

bool RendererSettings::needs_new_renderer(const settings::DrawSettings& settings) const {
  const settings::RasterPath path = choose_path(device_, settings.raster);
  const bool compute = path == settings::RasterPath::visibility;
  const bool other_environment = settings.environment
                                     ? uses_studio_ || environment_source_.lock() != settings.environment
                                     : !uses_studio_;
  // Without storage of samples, effects draw the whole scene forward, which set_scene() must know.
  const bool other_draws = has_visibility_buffer() && !can_write_samples() &&
                           settings.post.reads_samples() != draw_.post.reads_samples();
  // Rays that hit surfaces need triangles where shadow rays may have boxes.
  const bool lacks_ray_effects = settings.ray_effects.on.any() && !traces_paths() && !has_ray_effects_ &&
                                 can_trace_ray_effects(device_, compute);
  const bool other_refraction = has_ray_effects_ && can_refract(settings) != refracts_;
  if (other_environment || other_draws || lacks_ray_effects || other_refraction ||
      settings.max_textures > draw_.max_textures)
    return true;
  if (!settings::needs_new_renderer(draw_, settings)) return false;
  // Different settings may come to the same on this device.
  const bool other_shadows = !traces_paths() && settings.shadows.method != settings::ShadowMethod::off &&
                             choose_shadow_technique(device_, settings.shadows, compute) != shadow_technique_;
  return settings.path.has_value() != traces_paths() || path != path_ || other_shadows ||
         choose_samples(device_, path, settings.samples) != samples_ ||
         settings.anisotropy != draw_.anisotropy || settings.lamps.count != draw_.lamps.count ||
         (!uses_studio_ && settings.environment_sun != draw_.environment_sun);
}

std::string RendererSettings::without_visibility_buffer() const {
  return draw_.raster == settings::RasterPath::forward
             ? ": leave --raster forward out"
             : ", for which " + device_.report().name +
                   " lacks 64-bit atomics: choose another device with --device";
}

Result<void> RendererSettings::can_blur() const {
  if (traces_paths()) return Error{"paths start on the lens: their images need no blur"};
  if (path_ != settings::RasterPath::visibility)
    return Error{"depth of field comes from the visibility buffer" + without_visibility_buffer()};
  if (!can_write_samples())
    return Error{"depth of field of several samples needs what " + device_.report().name +
                 " lacks (shaderStorageImageMultisample): take one sample with --samples 1"};
  return {};
}

Result<void> RendererSettings::can_take(const ImageOutputs& outputs, uint32_t views,
                                        const SceneLimits& scene) const {
  if (views > 1 && traces_paths()) return Error{"paths are traced for one camera at a time"};
  if (views > 1) {
    // Edits may show hidden nodes in the recorded frame.
    const bool has_effects = ((draw_.post.reads_samples() || traces_ray_effects(scene.refracts)) &&
                              outputs.has(wire::kColorSrgb8)) ||
                             ((has_depth_of_field(scene) || draw_.lamps.count > 0) && outputs.shaded()) ||
                             (draw_.post.optics.mask_radius > 0 && outputs.has_planes());
    const bool alone =
        path_ != settings::RasterPath::visibility || scene.may_have_forward_only || has_effects;
    if (alone || outputs.has(wire::kColorLinearF16))
      return Error{
          "several cameras at once need the visibility path, a scene without blended surfaces, lines and "
          "points, and no bloom, metered exposure, lens, optics or lamps of the camera, ray effects or "
          "linear "
          "colours: take one after the other"};
    if (outputs.has(wire::kAmodal)) return Error{"silhouettes are drawn for one camera at a time"};
  }
  if (!outputs.has_planes()) return {};
  if (path_ != settings::RasterPath::visibility)
    return Error{"outputs beside color come from the visibility buffer" + without_visibility_buffer()};
  if (outputs.has(wire::kColorLinearF16) && !traces_paths() && !can_write_samples())
    return Error{"linear colours of several samples need what " + device_.report().name +
                 " lacks (shaderStorageImageMultisample): take one sample with --samples 1"};
  return {};
}

Result<void> RendererSettings::can_inspect() const {
  if (path_ == settings::RasterPath::visibility) return {};
  return Error{"picking, outlines and debug views come from the visibility buffer" +
               without_visibility_buffer()};
}

Result<void> RendererSettings::can_show(settings::DebugView view) const {
  if (view == settings::DebugView::none) return {};
  if (Result<void> can = can_inspect(); !can) return can;
  if (view == settings::DebugView::unresolved_shadows && !shadow_technique_.hybrid) {
    return Error{
        std::string("the debug view unresolved-shadows shows pixels that shadow maps leave to rays, but the "
                    "shadow technique is ") +
        describe(shadow_technique_) + ": take both, as --shadows ray does without --shadow-rays all"};
  }
  return {};
}

}  // namespace fire3dv::passes
