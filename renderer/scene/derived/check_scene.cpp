#include "renderer/scene/derived/loaded_scene.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <numbers>
#include <span>

#include "base/parallel.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/model/scene_fields.h"

namespace fire3dv::scene {
namespace {

bool in_range(uint64_t first, uint64_t count, size_t size) {
  return first <= size && count <= size - first;
}

bool none_or_below(uint32_t index, size_t size) {
  return index == kNone || index < size;
}

bool is_finite(std::span<const float> numbers) {
  constexpr uint32_t kExponent = 0x7f800000;
  uint32_t found = 0;  // no early exit, so that the loop vectorises
  for (const float number : numbers) {
    found |= (std::bit_cast<uint32_t>(number) & kExponent) == kExponent ? 1u : 0u;
  }
  return found == 0;
}

template <typename T>
std::span<const float> floats(const std::vector<T>& values) {
  static_assert(sizeof(T) % sizeof(float) == 0);
  return {reinterpret_cast<const float*>(values.data()), values.size() * (sizeof(T) / sizeof(float))};
}

template <typename T>
bool is_finite(const T& value) {
  static_assert(sizeof(T) % sizeof(float) == 0);
  return is_finite(std::span<const float>(reinterpret_cast<const float*>(&value), sizeof(T) / sizeof(float)));
}

// Tests a large array in blocks on all cores.
bool all_finite(std::span<const float> numbers) {
  constexpr size_t kPiece = size_t{1} << 20;
  std::atomic<bool> finite{true};
  parallel_for((numbers.size() + kPiece - 1) / kPiece, [&](size_t i) {
    if (!is_finite(numbers.subspan(i * kPiece, std::min(kPiece, numbers.size() - i * kPiece))))
      finite = false;
  });
  return finite;
}

bool all_below(std::span<const uint32_t> indices, uint32_t limit) {
  uint32_t largest = 0;
  for (const uint32_t index : indices) largest = std::max(largest, index);
  return indices.empty() || largest < limit;
}

bool is_valid_deformation(const Scene& scene, const Primitive& p) {
  if (p.morph_target_count > 0 &&
      !in_range(p.first_morph_delta, uint64_t{p.morph_target_count} * p.vertex_count,
                scene.morph_deltas.size()))
    return false;
  if (p.first_influence == kNone) return true;
  const uint64_t count = uint64_t{p.vertex_count} * p.influence_sets;
  if (!in_range(p.first_influence, count, scene.influences.size()) ||
      !in_range(p.first_joint_bounds, p.joint_bounds_count, scene.joint_bounds.size()))
    return false;
  for (uint64_t i = 0; i < count; ++i) {
    const Influences& influences = scene.influences[p.first_influence + i];
    for (const uint16_t joint : influences.joints) {
      if (joint >= p.joint_limit) return false;
    }
    if (!is_finite(influences.weights)) return false;
  }
  for (uint32_t b = 0; b < p.joint_bounds_count; ++b) {
    if (scene.joint_bounds[p.first_joint_bounds + b].joint >= p.joint_limit) return false;
  }
  return true;
}

bool sources_are_right(const Scene& scene, const Primitive& p) {
  return p.first_vertex_source == kNone ||
         (in_range(p.first_vertex_source, p.vertex_count, scene.vertex_sources.size()) &&
          all_below(std::span(scene.vertex_sources).subspan(p.first_vertex_source, p.vertex_count),
                    p.file_vertex_count));
}

bool variants_are_right(const Scene& scene, const Primitive& p) {
  if (p.first_variant_material == kNone) return true;
  const size_t count = scene.variants.size() + 1;
  return in_range(p.first_variant_material, count, scene.variant_materials.size()) &&
         all_below(std::span(scene.variant_materials).subspan(p.first_variant_material, count),
                   static_cast<uint32_t>(scene.materials.size()));
}

bool is_valid_primitive(const Scene& scene, const Primitive& p) {
  if (p.topology > Topology::points) return false;
  const uint32_t corners = p.topology == Topology::triangles ? 3 : p.topology == Topology::lines ? 2 : 1;
  return in_range(p.first_index, p.index_count, scene.indices.size()) && p.index_count % corners == 0 &&
         in_range(p.first_vertex, p.vertex_count, scene.positions.size()) &&
         p.material < scene.materials.size() && is_finite(p.bounds_min) && is_finite(p.bounds_max) &&
         all_below(std::span(scene.indices).subspan(p.first_index, p.index_count), p.vertex_count) &&
         sources_are_right(scene, p) && variants_are_right(scene, p) && is_valid_deformation(scene, p);
}

bool is_valid_node(const Scene& scene, uint32_t index) {
  const Node& node = scene.nodes[index];
  if (node.has_instance_vertices) return false;  // set at run time only, never in a cache entry
  if (!(node.parent == kNone || node.parent < index) || !none_or_below(node.mesh, scene.meshes.size()) ||
      !none_or_below(node.camera, scene.cameras.size()) || !none_or_below(node.light, scene.lights.size()) ||
      !none_or_below(node.skin, scene.skins.size()) ||
      !in_range(node.first_morph_weight, node.morph_weight_count, scene.morph_weights.size()))
    return false;
  if (!is_finite(node.parent_from_node) || !is_finite(node.world_from_node) || !is_finite(node.translation) ||
      !is_finite(node.rotation) || !is_finite(node.scale))
    return false;
  if (node.mesh == kNone) return node.skin == kNone && node.morph_weight_count == 0;
  const Mesh& mesh = scene.meshes[node.mesh];
  if (node.morph_weight_count != mesh.morph_target_count) return false;
  if (node.skin == kNone) return true;
  const Skin& skin = scene.skins[node.skin];
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    if (scene.primitives[p].joint_limit > skin.joint_count) return false;
  }
  return skin.joint_count > 0;
}

bool is_valid_channel(const Scene& scene, const AnimationChannel& c) {
  const size_t values = c.interpolation == Interpolation::cubic_spline ? 3 : 1;
  if (c.path > AnimationPath::weights || c.interpolation > Interpolation::cubic_spline ||
      c.node >= scene.nodes.size() || c.key_count == 0 ||
      !in_range(c.first_time, c.key_count, scene.key_times_s.size()) ||
      !in_range(c.first_value, uint64_t{values} * c.key_count * c.width, scene.key_values.size()))
    return false;
  const uint32_t width = c.path == AnimationPath::weights    ? scene.nodes[c.node].morph_weight_count
                         : c.path == AnimationPath::rotation ? 4
                                                             : 3;
  const std::span times = std::span(scene.key_times_s).subspan(c.first_time, c.key_count);
  return c.width == width &&
         std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
}

bool is_valid_material(const Scene& scene, const Material& m) {
  bool are_textures_valid = true;
  visit_textures(m, [&](const TextureRef& ref) {
    are_textures_valid = are_textures_valid && none_or_below(ref.texture, scene.textures.size()) &&
                         ref.uv_set <= 1 && is_finite(ref.uv_offset) && is_finite(ref.uv_rotation_rad) &&
                         is_finite(ref.uv_scale);
  });
  if (!are_textures_valid) return false;
  for (const float number : {m.metallic,
                             m.roughness,
                             m.normal_scale,
                             m.occlusion_strength,
                             m.alpha_cutoff,
                             m.ior,
                             m.specular,
                             m.clearcoat,
                             m.clearcoat_roughness,
                             m.clearcoat_normal_scale,
                             m.sheen_roughness,
                             m.anisotropy,
                             m.anisotropy_rotation_rad,
                             m.iridescence,
                             m.iridescence_ior,
                             m.iridescence_thickness_min_nm,
                             m.iridescence_thickness_max_nm,
                             m.transmission,
                             m.thickness,
                             m.attenuation_distance_m,
                             m.dispersion,
                             m.diffuse_transmission}) {
    if (!std::isfinite(number)) return false;
  }
  return is_finite(m.base_color) && is_finite(m.emissive) && is_finite(m.specular_color) &&
         is_finite(m.sheen_color) && is_finite(m.attenuation_color) &&
         is_finite(m.diffuse_transmission_color) && m.alpha_mode <= AlphaMode::blend;
}

// The value ranges of the glTF loader.
bool is_valid_light(const Light& light) {
  constexpr float kWidestCone = std::numbers::pi_v<float> / 2 + 1e-3f;
  const bool cone = light.inner_cone_rad >= 0 && light.outer_cone_rad >= 0;
  return light.type <= LightType::spot && is_finite(light.color) && std::isfinite(light.intensity) &&
         light.intensity >= 0 && std::isfinite(light.range_m) && light.range_m >= 0 &&
         std::isfinite(light.radius_m) && light.radius_m >= 0 && std::isfinite(light.angular_radius_rad) &&
         light.angular_radius_rad >= 0 && light.angular_radius_rad <= kWidestCone && light.spread >= 0 &&
         light.spread <= kMaxLightSpread && std::isfinite(light.inner_cone_rad) &&
         std::isfinite(light.outer_cone_rad) &&
         (light.type != LightType::spot || (cone && light.outer_cone_rad <= kWidestCone));
}

bool is_valid_lens(const ThinLens& lens) {
  return lens == ThinLens() ||
         (lens.f_number >= kMinFNumber && lens.f_number <= kMaxFNumber &&
          lens.focus_distance_m >= kMinFocusDistanceM && lens.focus_distance_m <= kMaxFocusDistanceM);
}

bool has_valid_intrinsics(const Camera& camera) {
  return camera.pixel_aspect >= kMinPixelAspect && camera.pixel_aspect <= kMaxPixelAspect &&
         std::abs(camera.principal_point.x) <= kMaxPrincipalPoint &&
         std::abs(camera.principal_point.y) <= kMaxPrincipalPoint;
}

bool is_valid_camera(const Camera& camera) {
  return std::isfinite(camera.vertical_fov_rad) && std::isfinite(camera.aspect) && camera.aspect >= 0 &&
         std::isfinite(camera.near_m) && std::isfinite(camera.far_m) && is_finite(camera.half_extent_m) &&
         std::isfinite(camera.exposure) && camera.exposure >= 0 && is_valid_lens(camera.lens) &&
         has_valid_intrinsics(camera) &&
         (camera.orthographic || (camera.vertical_fov_rad > 0 &&
                                  camera.vertical_fov_rad < std::numbers::pi_v<float> && camera.near_m > 0));
}

bool is_valid_image(const Image& image) {
  return image.width > 0 && image.height > 0 && image.rgba8.size() / 4 / image.width == image.height &&
         image.rgba8.size() == uint64_t{image.width} * image.height * 4;
}

bool is_valid_cluster(const ClusteredGeometry& geometry, const Cluster& c) {
  const auto none_or_group = [&](uint32_t group) {
    return group == kNone || group < geometry.level_groups.size();
  };
  if (c.vertex_count > kClusterVertices || c.triangle_count > kClusterTriangles ||
      !in_range(c.first_vertex, c.vertex_count, geometry.source_vertices.size()) ||
      !in_range(c.first_triangle, c.triangle_count, geometry.triangles.size()) || !is_finite(c.center) ||
      !is_finite(c.radius) || !is_finite(c.cone_axis) || !is_finite(c.cone_cutoff) ||
      !none_or_group(c.made_by) || !none_or_group(c.merged_by))
    return false;
  uint32_t largest = 0;
  for (const uint32_t triangle : std::span(geometry.triangles).subspan(c.first_triangle, c.triangle_count)) {
    largest = std::max({largest, triangle & 0xff, triangle >> 8 & 0xff, triangle >> 16});
  }
  return c.triangle_count == 0 || largest < c.vertex_count;
}

bool is_valid_own_cluster(const ClusteredGeometry& geometry, const ClusteredPrimitive& p, const Cluster& c) {
  return c.first_vertex >= p.first_vertex &&
         in_range(c.first_vertex - p.first_vertex, c.vertex_count, p.vertex_count) && c.made_by == kNone &&
         is_valid_cluster(geometry, c);
}

bool is_valid_ray_box(const ClusteredGeometry& geometry, const ClusteredPrimitive& p, const RayAabb& box) {
  if (!is_finite(box.low) || !is_finite(box.high) || box.first_vertex < p.first_vertex ||
      box.first_vertex - p.first_vertex >= p.vertex_count ||
      !in_range(box.first_triangle(), box.triangle_count(), geometry.triangles.size()))
    return false;
  const uint32_t vertices = p.vertex_count - (box.first_vertex - p.first_vertex);
  const auto triangles = std::span(geometry.triangles).subspan(box.first_triangle(), box.triangle_count());
  return std::all_of(triangles.begin(), triangles.end(), [&](uint32_t t) {
    return std::max({t & 0xff, t >> 8 & 0xff, t >> 16}) < vertices;
  });
}

bool vertices_are_of(const ClusteredGeometry& geometry, uint32_t first, uint32_t count,
                     const Primitive& source) {
  for (const uint32_t vertex : std::span(geometry.source_vertices).subspan(first, count)) {
    if (vertex < source.first_vertex || vertex - source.first_vertex >= source.vertex_count) return false;
  }
  return true;
}

// True if the clusters have all triangles of the primitive; without clusters, if vertex counts are equal.
bool has_all_triangles(const ClusteredGeometry& geometry, const ClusteredPrimitive& p,
                       const Primitive& source) {
  if (source.topology != Topology::triangles) return p.vertex_count == source.vertex_count;
  uint64_t corners = 0;
  for (const Cluster& c : std::span(geometry.clusters).subspan(p.first_cluster, p.cluster_count)) {
    corners += uint64_t{3} * c.triangle_count;
  }
  return corners == p.index_count;
}

bool is_valid_geometry(const ClusteredGeometry& geometry, const ClusteredPrimitive& p,
                       const Primitive& source) {
  if (p.index_count != source.index_count ||
      !in_range(p.first_vertex, p.vertex_count, geometry.source_vertices.size()) ||
      !in_range(p.first_cluster, p.cluster_count, geometry.clusters.size()))
    return false;
  if (!has_all_triangles(geometry, p, source)) return false;
  if (!vertices_are_of(geometry, p.first_vertex, p.vertex_count, source) ||
      !in_range(p.first_level_cluster, p.level_cluster_count, geometry.clusters.size()) ||
      !in_range(p.first_ray_box, p.ray_box_count, geometry.ray_boxes.size()))
    return false;
  const auto own = std::span(geometry.clusters).subspan(p.first_cluster, p.cluster_count);
  const auto coarser = std::span(geometry.clusters).subspan(p.first_level_cluster, p.level_cluster_count);
  const auto boxes = std::span(geometry.ray_boxes).subspan(p.first_ray_box, p.ray_box_count);
  return std::all_of(boxes.begin(), boxes.end(),
                     [&](const RayAabb& b) { return is_valid_ray_box(geometry, p, b); }) &&
         std::all_of(own.begin(), own.end(),
                     [&](const Cluster& c) { return is_valid_own_cluster(geometry, p, c); }) &&
         std::all_of(coarser.begin(), coarser.end(), [&](const Cluster& c) {
           return is_valid_cluster(geometry, c) &&
                  vertices_are_of(geometry, c.first_vertex, c.vertex_count, source);
         });
}

// Runs test(i) for each element in parallel. The error names the array.
Result<void> check_all(const char* array, size_t count, const std::function<bool(size_t)>& test) {
  std::atomic<bool> right{true};
  parallel_for(count, [&](size_t i) {
    if (right && !test(i)) right = false;
  });
  if (right) return {};
  return Error{std::string("its ") + array + " are not right"};
}

}  // namespace

Result<void> check_scene(const Scene& s) {
  const size_t vertices = s.positions.size();
  if (s.frames.size() != vertices || s.uvs.size() != vertices ||
      (!s.tangents.empty() && s.tangents.size() != vertices) ||
      (!s.extras.empty() && s.extras.size() != vertices) || s.materials.empty()) {
    return Error{"arrays are missing"};
  }
  const std::span<const float> numbers[] = {
      floats(s.positions),     floats(s.uvs),         floats(s.morph_deltas), floats(s.joint_bounds),
      floats(s.morph_weights), floats(s.key_times_s), floats(s.key_values)};
  for (const std::span<const float>& some : numbers) {
    if (!all_finite(some)) return Error{"it holds numbers that are not finite"};
  }
  if (!std::all_of(s.extras.begin(), s.extras.end(),
                   [](const VertexExtras& extras) { return is_finite(extras.uv1); })) {
    return Error{"it holds texture coordinates that are not finite"};
  }
  if (!is_finite(s.view_from)) return Error{"its default view is not finite"};
  if (!is_finite(s.bounds_min) || !is_finite(s.bounds_max)) return Error{"its bounds are not finite"};
  const auto primitive = [&](size_t i) { return is_valid_primitive(s, s.primitives[i]); };
  if (auto done = check_all("primitives", s.primitives.size(), primitive); !done) return done;
  const auto mesh = [&](size_t i) {
    const Mesh& m = s.meshes[i];
    if (!in_range(m.first_primitive, m.primitive_count, s.primitives.size())) return false;
    const auto own = std::span(s.primitives).subspan(m.first_primitive, m.primitive_count);
    return std::all_of(own.begin(), own.end(),
                       [&](const Primitive& p) { return p.morph_target_count == m.morph_target_count; });
  };
  if (auto done = check_all("meshes", s.meshes.size(), mesh); !done) return done;
  const auto skin = [&](size_t i) {
    return in_range(s.skins[i].first_joint, s.skins[i].joint_count, s.joints.size());
  };
  if (auto done = check_all("skins", s.skins.size(), skin); !done) return done;
  const auto joint = [&](size_t i) {
    return s.joints[i].node < s.nodes.size() && is_finite(s.joints[i].joint_from_mesh);
  };
  if (auto done = check_all("joints", s.joints.size(), joint); !done) return done;
  const auto node = [&](size_t i) { return is_valid_node(s, static_cast<uint32_t>(i)); };
  if (auto done = check_all("nodes", s.nodes.size(), node); !done) return done;
  const auto channel = [&](size_t i) { return is_valid_channel(s, s.channels[i]); };
  if (auto done = check_all("channels", s.channels.size(), channel); !done) return done;
  const auto animation = [&](size_t i) {
    return in_range(s.animations[i].first_channel, s.animations[i].channel_count, s.channels.size()) &&
           is_finite(s.animations[i].duration_s);
  };
  if (auto done = check_all("animations", s.animations.size(), animation); !done) return done;
  const auto texture = [&](size_t i) {
    const Texture& t = s.textures[i];
    return t.image < s.images.size() && t.sampler.wrap_u <= Wrap::clamp_to_edge &&
           t.sampler.wrap_v <= Wrap::clamp_to_edge;
  };
  if (auto done = check_all("textures", s.textures.size(), texture); !done) return done;
  if (!none_or_below(s.sky_texture, s.textures.size())) return Error{"its sky is no texture of it"};
  const auto image = [&](size_t i) { return is_valid_image(s.images[i]); };
  if (auto done = check_all("images", s.images.size(), image); !done) return done;
  const auto material = [&](size_t i) { return is_valid_material(s, s.materials[i]); };
  if (auto done = check_all("materials", s.materials.size(), material); !done) return done;
  const auto light = [&](size_t i) { return is_valid_light(s.lights[i]); };
  if (auto done = check_all("lights", s.lights.size(), light); !done) return done;
  const auto camera = [&](size_t i) { return is_valid_camera(s.cameras[i]); };
  if (auto done = check_all("cameras", s.cameras.size(), camera); !done) return done;
  return check_deformed_copies(s);
}

Result<void> check_derived(const Scene& scene, const Derived& derived) {
  const ClusteredGeometry& geometry = derived.clusters;
  if (geometry.primitives.size() != scene.primitives.size() || derived.casters.size() != scene.meshes.size())
    return Error{"the derived data belong to another scene"};
  const auto primitive = [&](size_t i) {
    return is_valid_geometry(geometry, geometry.primitives[i], scene.primitives[i]);
  };
  if (auto done = check_all("clusters", scene.primitives.size(), primitive); !done) return done;
  uint64_t next_index = 0;
  for (const ClusteredPrimitive& p : geometry.primitives) {
    if (p.first_index != next_index) return Error{"its clusters are not right"};
    next_index += p.index_count;
  }
  const auto group = [&](size_t i) {
    const LevelGroup& g = geometry.level_groups[i];
    return is_finite(g.center) && is_finite(g.radius) && is_finite(g.error) && is_finite(g.surface_error);
  };
  if (auto done = check_all("levels of detail", geometry.level_groups.size(), group); !done) return done;
  const auto caster = [&](size_t i) {
    return derived.casters[i].shape <= CasterShape::open && is_finite(derived.casters[i].plane_node);
  };
  return check_all("casters", derived.casters.size(), caster);
}

}  // namespace fire3dv::scene
