// Which lights have which maps, and which bits of the shadow mask. No Vulkan.
#pragma once

#include <vector>

#include "renderer/scene/scene_edits.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct MapSizes {
  uint32_t side = 2048;       // texels along a map; half of that along a side of a cube
  uint32_t maps_of_view = 2;  // nearest depths, and outer ones if rays are traced where those cannot tell
  bool operator==(const MapSizes&) const = default;
};

// Has a size, and so a penumbra.
bool is_soft(const scene::Light& light);

struct ShadowPlan {
  MapSizes sizes;  // asked for; many maps are smaller
  std::vector<gpu_types::LightViewWanted> views;
  std::vector<gpu_types::LightShadow> shadows;  // of each light
  uint32_t mask_words = 1;                      // of each pixel
  uint32_t texels = 0;                          // of all maps
  bool all_hard() const;                        // or none at all
  bool operator==(const ShadowPlan& other) const;
};

// samples: 1 or 4, of each pixel. soft_by_rays: soft shadows have no use for a map.
ShadowPlan plan_shadows(const std::vector<scene::PlacedLight>& lights, uint32_t samples, bool soft_by_rays,
                        const MapSizes& sizes);

}  // namespace fire3dv::passes
