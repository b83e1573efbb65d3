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
  uint32_t map_side = 0;         // texels along a map, a power of two; 0: chosen by device and image size
  uint32_t max_listed_rays = 0;  // capacity of the ray list; 0: half of the pixels
  bool operator==(const ShadowSettings&) const = default;
};

}  // namespace fire3dv::settings
