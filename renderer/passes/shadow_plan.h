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

// Limits of what shadows may take. Lights beyond them, in node order, cast no shadow.
struct ShadowRoom {
  uint64_t max_views = UINT64_MAX;
  uint64_t max_texels = uint64_t{1} << 27;  // of all maps at their smallest size; 512 MiB
  uint32_t max_mask_words = UINT32_MAX;     // of each pixel
  bool has_room = true;                     // false: no light casts a shadow
};

// Has a size, and so a penumbra.
bool is_soft(const scene::Light& light);

struct ShadowPlan {
  MapSizes sizes;  // asked for; many maps are smaller
  std::vector<gpu_types::LightViewWanted> views;
  std::vector<gpu_types::LightShadow> shadows;  // of each light
  uint32_t mask_words = 1;                      // of each pixel
  uint64_t texels = 0;                          // of all maps
  uint32_t mask_words_wanted = 1;               // of each pixel, were there room for all shadows
  uint32_t lights_without_shadow = 0;           // that would cast one, were there room
  bool all_hard() const;                        // or none at all
  bool operator==(const ShadowPlan& other) const;
};

// samples: 1 or 4, of each pixel. soft_by_rays: soft shadows have no use for a map.
ShadowPlan plan_shadows(const std::vector<scene::PlacedLight>& lights, uint32_t samples, bool soft_by_rays,
                        const MapSizes& sizes, const ShadowRoom& room = {});

}  // namespace fire3dv::passes
