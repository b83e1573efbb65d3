// Draw settings: all that decides how a scene looks in an image, beside scene and view. Values without
// Vulkan.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "renderer/settings/background.h"
#include "renderer/settings/path_settings.h"
#include "renderer/settings/post_settings.h"
#include "renderer/settings/raster_settings.h"
#include "renderer/settings/ray_effect_settings.h"
#include "renderer/settings/shadow_settings.h"

namespace fire3dv::scene {
struct EnvironmentImage;
}

namespace fire3dv::passes {
class EnvironmentStore;
}

namespace fire3dv::settings {

struct DrawSettings {
  RasterPath raster = RasterPath::automatic;
  Cull cull = Cull::automatic;
  LevelsOfDetail levels_of_detail = LevelsOfDetail::automatic;
  float anisotropy = 1;  // off, so that images are identical on all devices
  uint32_t samples = 4;
  bool keeps_samples = false;  // the user chose `samples`: images in motion have as many
  MotionQuality motion_quality = MotionQuality::automatic;
  ShadowSettings shadows;
  std::shared_ptr<const scene::EnvironmentImage> environment;  // null: the studio environment
  std::shared_ptr<passes::EnvironmentStore>
      cached_environments;      // cache; null: maps are prepared at each start
  bool environment_sun = true;  // a sun in the environment image is drawn as a light with shadows
  float environment_intensity = 1;
  float environment_rotation_rad = 0;  // about +Y, counter-clockwise seen from above
  Background background;
  PostSettings post;
  LampSettings lamps;
  RayEffectSettings ray_effects;  // of raster images, on devices that trace rays; see can_trace_ray_effects()
  std::optional<PathSettings> path;  // colours by path tracing; the device must support it. nullopt: raster
  float label_alpha = 0.5f;         // blended surfaces with more alpha are in labels, depth and boxes; 0 to 1
  uint32_t max_textures = 1 << 16;  // texture capacity of a scene; larger values slow down every start
};

// Settings of images in motion on a CPU: one sample, unless the user chose their number, and shadows by maps
// alone where the technique is automatic. nullopt: those of images at rest.
std::optional<DrawSettings> settings_in_motion(const DrawSettings& at_rest);

}  // namespace fire3dv::settings
