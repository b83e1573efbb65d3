#include "renderer/passes/shadow_plan.h"

#include <algorithm>
#include <cstring>

namespace fire3dv::passes {
namespace {

constexpr uint32_t kSoftRays = 16;
// All views together; beyond it every map gets smaller.
constexpr uint64_t kMostTexels = 48u << 20;
constexpr uint32_t kSmallestSide = 64;
// A spot that is wider than this has no map of one piece.
constexpr float kWidestSpotRad = 1.2f;

bool needs_cube(const scene::Light& light) {
  return light.type == scene::LightType::point ||
         (light.type == scene::LightType::spot && light.outer_cone_rad > kWidestSpotRad);
}

uint32_t rays_of(const scene::Light& light) {
  if (!light.casts_shadow) return 0;
  return is_soft(light) ? kSoftRays : 1;
}

// Each map gets its place behind the ones before.
void place_maps(ShadowPlan& plan) {
  auto texels = [&] {
    uint64_t sum = 0;
    for (const gpu_types::LightViewWanted& view : plan.views)
      sum += uint64_t{plan.sizes.maps_of_view} * view.size * view.size;
    return sum;
  };
  while (texels() > kMostTexels && plan.views[0].size > kSmallestSide) {
    for (gpu_types::LightViewWanted& view : plan.views) view.size /= 2;
  }
  for (gpu_types::LightViewWanted& view : plan.views) {
    view.first_texel = plan.texels;
    plan.texels += plan.sizes.maps_of_view * view.size * view.size;
  }
}

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

bool ShadowPlan::operator==(const ShadowPlan& other) const {
  return same_bytes(views, other.views) && same_bytes(shadows, other.shadows) &&
         mask_words == other.mask_words && sizes == other.sizes && texels == other.texels;
}

bool is_soft(const scene::Light& light) {
  return light.type == scene::LightType::directional ? light.angular_radius_rad > 0 : light.radius_m > 0;
}

bool ShadowPlan::all_hard() const {
  return std::all_of(shadows.begin(), shadows.end(),
                     [](const gpu_types::LightShadow& shadow) { return shadow.rays <= 1; });
}

ShadowPlan plan_shadows(const std::vector<scene::PlacedLight>& lights, uint32_t samples, bool soft_by_rays,
                        const MapSizes& sizes) {
  ShadowPlan plan;
  plan.sizes = sizes;
  uint32_t bit = 0, soft_words = 0;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    const scene::Light& light = lights[i].light;
    const bool cube = needs_cube(light);
    gpu_types::LightShadow shadow{};
    shadow.first_view = static_cast<uint32_t>(plan.views.size());
    shadow.rays = rays_of(light);
    // A map knows of one ray to each point; for soft shadows all rays are traced where they can be.
    const bool no_map = shadow.rays == 0 || (shadow.rays > 1 && soft_by_rays);
    shadow.view_count = no_map ? 0 : cube ? 6 : 1;
    if (shadow.rays == 0) {
      shadow.mask_word = FIRE3DV_NO_INDEX;
    } else if (shadow.rays == 1) {
      shadow.mask_word = bit / 32;
      shadow.mask_shift = bit % 32;
      bit += samples;
    } else {
      shadow.mask_word = soft_words++;  // counted from the last hard one; set right below
    }
    for (uint32_t side = 0; side < shadow.view_count; ++side) {
      plan.views.push_back(
          {i, cube ? side : FIRE3DV_NO_INDEX, cube ? sizes.side / 2 : sizes.side, 0, light.outer_cone_rad});
    }
    plan.shadows.push_back(shadow);
  }
  const uint32_t hard_words = (bit + 31) / 32;
  for (gpu_types::LightShadow& shadow : plan.shadows) {
    if (shadow.rays > 1) shadow.mask_word += hard_words;
  }
  plan.mask_words = std::max(1u, hard_words + soft_words);
  place_maps(plan);
  return plan;
}

}  // namespace fire3dv::passes
