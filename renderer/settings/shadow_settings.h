// Draw settings of shadows, and the back ends of rays.
#pragma once

#include <cstdint>

namespace fire3dv::settings {

enum class ShadowMethod : uint8_t { automatic, ray, map, off };
enum class RayBackEnd : uint8_t { none, query, pipeline };

struct ShadowSettings {
  ShadowMethod method = ShadowMethod::automatic;
  bool hybrid = true;  // maps first, rays for unresolved pixels; false: a ray for every lit surface
  RayBackEnd back_end = RayBackEnd::query;  // preferred; the other one is the fallback
  // With maps alone: maps of 64 to 512 texels along a side, about as many as the image has pixels, drawn with
  // coarse levels. For batches of small images: each world has maps of its own.
  bool small_maps = false;
  uint32_t map_side =
      0;  // texels along a map, a power of two; 0: chosen by device, image size and small_maps
  uint32_t max_listed_rays = 0;  // capacity of the ray list; 0: half of the pixels
  bool operator==(const ShadowSettings&) const = default;
};

}  // namespace fire3dv::settings
