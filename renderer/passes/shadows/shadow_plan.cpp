#include "renderer/passes/shadows/shadow_plan.h"

#include <algorithm>

#include "base/vectors.h"
#include "renderer/gpu/device/device.h"

namespace fire3dv::passes {
namespace {

constexpr uint32_t kSoftRays = 16;
constexpr uint32_t kSmallestSide = 64;
// Wider spots need a cube map.
constexpr float kWidestSpotRad = 1.2f;

bool needs_cube(const scene::Light& light) {
  return light.type == scene::LightType::point ||
         (light.type == scene::LightType::spot && light.outer_cone_rad > kWidestSpotRad);
}

uint32_t rays_of(const scene::Light& light) {
  if (!light.casts_shadow) return 0;
  return is_soft(light) ? kSoftRays : 1;
}

// Accumulates the shadow resources light by light.
class ResourceCount {
 public:
  ResourceCount(const ShadowLimits& limits, const MapSizes& sizes) : limits_(limits), sizes_(sizes) {}

  // Reserves the resources of one more light, or none of them.
  bool take(uint32_t views, uint32_t mask_bits, uint32_t soft_words) {
    const uint64_t all_views = views_ + views, bits = bits_ + mask_bits, words = soft_words_ + soft_words;
    const bool is_cube = views > 1, is_first_cube = views_ > 0 ? is_first_cube_ : is_cube;
    const uint64_t side = smallest_side(is_cube, is_first_cube);
    const uint64_t texels = texels_ + views * sizes_.maps_of_view * side * side;
    wanted_bits_ += mask_bits;
    wanted_soft_words_ += soft_words;
    if (!limits_.has_memory || all_views > limits_.max_views || texels > limits_.max_texels ||
        (bits + 31) / 32 + words > limits_.max_mask_words)
      return false;
    is_first_cube_ = is_first_cube;
    views_ = all_views;
    texels_ = texels;
    bits_ = bits;
    soft_words_ = words;
    return true;
  }
  uint32_t mask_words_wanted() const {
    return static_cast<uint32_t>(
        std::clamp<uint64_t>((wanted_bits_ + 31) / 32 + wanted_soft_words_, 1, UINT32_MAX));
  }

 private:
  // Halving stops when the first map has the smallest side. If that is a cube face, other maps have twice its
  // side.
  uint64_t smallest_side(bool is_cube, bool is_first_cube) const {
    const uint64_t side = std::min(sizes_.side, is_first_cube ? 2 * kSmallestSide : kSmallestSide);
    return is_cube ? side / 2 : side;
  }

  const ShadowLimits& limits_;
  const MapSizes& sizes_;
  bool is_first_cube_ = false;
  uint64_t views_ = 0, texels_ = 0, bits_ = 0, soft_words_ = 0, wanted_bits_ = 0, wanted_soft_words_ = 0;
};

// Assigns the maps' offsets in sequence.
void fit_map_views(ShadowPlan& plan, uint64_t max_texels) {
  auto texels = [&] {
    uint64_t sum = 0;
    for (const gpu_types::LightViewRequest& view : plan.views)
      sum += uint64_t{plan.sizes.maps_of_view} * view.size * view.size;
    return sum;
  };
  while (texels() > max_texels && plan.views[0].size > kSmallestSide) {
    for (gpu_types::LightViewRequest& view : plan.views) view.size /= 2;
  }
  for (gpu_types::LightViewRequest& view : plan.views) {
    view.first_texel = static_cast<uint32_t>(plan.texels);
    plan.texels += uint64_t{plan.sizes.maps_of_view} * view.size * view.size;
  }
}

}  // namespace

ShadowTechnique choose_shadow_technique(const gpu::Device& device, const settings::ShadowSettings& settings,
                                        bool compute) {
  ShadowTechnique technique;
  technique.map_side = settings.map_side;
  technique.max_listed_rays = settings.max_listed_rays;
  if (settings.method == settings::ShadowMethod::off) return technique;
  const gpu::DeviceReport& report = device.report();
  const bool can_trace = report.ray_query || report.ray_tracing_pipeline;
  if (settings.method == settings::ShadowMethod::map || !can_trace) {
    technique.method = settings::ShadowMethod::map;
    technique.small_maps = settings.small_maps && settings.method == settings::ShadowMethod::map;
    return technique;
  }
  technique.method = settings::ShadowMethod::ray;
  const bool pipeline = report.ray_tracing_pipeline &&
                        (settings.back_end == settings::RayBackEnd::pipeline || !report.ray_query);
  technique.hybrid = settings.hybrid && (compute || pipeline);
  technique.back_end = pipeline ? settings::RayBackEnd::pipeline : settings::RayBackEnd::query;
  return technique;
}

const char* describe(const ShadowTechnique& technique) {
  switch (technique.method) {
    case settings::ShadowMethod::off:
    case settings::ShadowMethod::automatic:
      return "off";
    case settings::ShadowMethod::map:
      return technique.small_maps ? "small shadow maps" : "shadow maps";
    case settings::ShadowMethod::ray:
      break;
  }
  if (technique.back_end == settings::RayBackEnd::query)
    return technique.hybrid ? "shadow maps and ray query" : "ray query";
  return technique.hybrid ? "shadow maps and a ray-tracing pipeline" : "a ray-tracing pipeline";
}

bool ShadowPlan::operator==(const ShadowPlan& other) const {
  return same_bytes(views, other.views) && same_bytes(shadows, other.shadows) &&
         mask_words == other.mask_words && sizes == other.sizes && texels == other.texels &&
         lights_without_shadow == other.lights_without_shadow;
}

bool is_soft(const scene::Light& light) {
  return light.type == scene::LightType::directional ? light.angular_radius_rad > 0 : light.radius_m > 0;
}

bool ShadowPlan::all_hard() const {
  return std::all_of(shadows.begin(), shadows.end(),
                     [](const gpu_types::LightShadow& shadow) { return shadow.rays <= 1; });
}

ShadowPlan plan_shadows(const std::vector<scene::PlacedLight>& lights, uint32_t samples, bool soft_by_rays,
                        const MapSizes& sizes, const ShadowLimits& limits) {
  ShadowPlan plan;
  plan.sizes = sizes;
  ResourceCount count(limits, sizes);
  uint32_t bit = 0, soft_words = 0;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    const scene::Light& light = lights[i].light;
    const bool cube = needs_cube(light);
    gpu_types::LightShadow shadow{};
    shadow.first_view = static_cast<uint32_t>(plan.views.size());
    shadow.rays = rays_of(light);
    // A map represents one ray per point; soft shadows use rays only, where available. The ground below the
    // scene reads maps alone, so that the sun has one where there are maps.
    const bool is_of_ground = lights[i].node == scene::kNone && sizes.maps_of_view > 1;
    bool no_map = shadow.rays == 0 || (shadow.rays > 1 && soft_by_rays && !is_of_ground);
    const uint32_t view_count = no_map ? 0 : cube ? 6 : 1;
    if (shadow.rays > 0 && !count.take(view_count, shadow.rays == 1 ? samples : 0, shadow.rays > 1 ? 1 : 0)) {
      shadow.rays = 0;
      no_map = true;
      ++plan.lights_without_shadow;
    }
    shadow.view_count = no_map ? 0 : view_count;
    if (shadow.rays == 0) {
      shadow.mask_word = FIRE3DV_NO_INDEX;
    } else if (shadow.rays == 1) {
      shadow.mask_word = bit / 32;
      shadow.mask_shift = bit % 32;
      bit += samples;
    } else {
      shadow.mask_word = soft_words++;  // relative to the hard words; made absolute below
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
  plan.mask_words_wanted = count.mask_words_wanted();
  fit_map_views(plan, limits.max_fitted_texels);
  return plan;
}

}  // namespace fire3dv::passes
