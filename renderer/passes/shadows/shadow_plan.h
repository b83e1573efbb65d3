// Shadow plan: the technique (maps, rays, or both) that a device supports for the settings, and the
// allocation of shadow maps and mask bits to lights. It has no Vulkan dependency.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene_edits.h"
#include "renderer/settings/shadow_settings.h"
#include "shaders/shared/types.h"

namespace fire3dv::gpu {
class Device;
}

namespace fire3dv::passes {

// Shadow technique that a device supports for the settings.
struct ShadowTechnique {
  settings::ShadowMethod method = settings::ShadowMethod::off;  // never automatic
  settings::RayBackEnd back_end = settings::RayBackEnd::none;
  bool hybrid = false;
  bool small_maps = false;                     // never with rays
  uint32_t map_side = 0, max_listed_rays = 0;  // as in the settings
  bool operator==(const ShadowTechnique&) const = default;
};

// compute: the image uses a visibility buffer. Otherwise shading traces inline where ray queries are
// available.
ShadowTechnique choose_shadow_technique(const gpu::Device& device, const settings::ShadowSettings& settings,
                                        bool compute);
const char* describe(const ShadowTechnique& technique);

struct MapSizes {
  uint32_t side = 2048;       // texels along a map; half of that along a cube face
  uint32_t maps_of_view = 2;  // centre map, plus an outer map where unresolved pixels are traced
  bool operator==(const MapSizes&) const = default;
};

// Limits of shadow resources. Lights beyond them, in node order, cast no shadow.
struct ShadowLimits {
  uint64_t max_views = UINT64_MAX;
  uint64_t max_texels = uint64_t{1} << 27;  // of all maps at their smallest size; 512 MiB
  uint64_t max_fitted_texels =
      48u << 20;  // of all maps; above it they shrink, but not below their smallest size
  uint32_t max_mask_words = UINT32_MAX;  // per pixel
  bool has_memory = true;                // false: no light casts a shadow
};

// True for lights with a size, which cast penumbrae.
bool is_soft(const scene::Light& light);

struct ShadowPlan {
  MapSizes sizes;  // requested; maps may be smaller
  std::vector<gpu_types::LightViewRequest> views;
  std::vector<gpu_types::LightShadow> shadows;  // per light
  uint32_t mask_words = 1;                      // per pixel
  uint64_t texels = 0;                          // of all maps
  uint32_t mask_words_wanted = 1;               // per pixel, without resource limits
  uint32_t lights_without_shadow = 0;           // dropped by the limits
  bool all_hard() const;                        // or none at all
  bool operator==(const ShadowPlan& other) const;
};

// samples: 1 or 4, per pixel. soft_by_rays: soft shadows use no maps.
ShadowPlan plan_shadows(const std::vector<scene::PlacedLight>& lights, uint32_t samples, bool soft_by_rays,
                        const MapSizes& sizes, const ShadowLimits& limits = {});

}  // namespace fire3dv::passes
