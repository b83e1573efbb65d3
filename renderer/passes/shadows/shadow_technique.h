// Shadow technique: shadow maps, rays, or both. Settings, and the choice for a device.
#pragma once

#include <cstdint>

namespace fire3dv::gpu {
class Device;
}

namespace fire3dv::passes {

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

// Shadow technique that a device supports for the settings.
struct ShadowTechnique {
  ShadowMethod method = ShadowMethod::off;  // never automatic
  RayBackEnd back_end = RayBackEnd::none;
  bool hybrid = false;
  uint32_t map_side = 0, max_listed_rays = 0;  // as in the settings
  bool operator==(const ShadowTechnique&) const = default;
};

// compute: the image uses a visibility buffer. Otherwise shading traces inline where ray queries are
// available.
ShadowTechnique choose_shadow_technique(const gpu::Device& device, const ShadowSettings& settings,
                                        bool compute);
const char* describe(const ShadowTechnique& technique);

}  // namespace fire3dv::passes
