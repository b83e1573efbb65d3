// Allocation of shadow maps and mask bits to lights. It has no Vulkan dependency.
#pragma once

#include <vector>

#include "renderer/scene/edits/scene_edits.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct MapSizes {
  uint32_t side = 2048;       // texels along a map; half of that along a cube face
  uint32_t maps_of_view = 2;  // centre map, plus an outer map where unresolved pixels are traced
  bool operator==(const MapSizes&) const = default;
};

// Limits of shadow resources. Lights beyond them, in node order, cast no shadow.
struct ShadowLimits {
  uint64_t max_views = UINT64_MAX;
  uint64_t max_texels = uint64_t{1} << 27;  // of all maps at their smallest size; 512 MiB
  uint32_t max_mask_words = UINT32_MAX;     // per pixel
  bool has_memory = true;                   // false: no light casts a shadow
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
