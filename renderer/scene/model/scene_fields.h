// Member lists of Scene for generic copies and serialisation. A new member needs one line here
// and a check in check_scene.cpp; older cache files are then refused automatically (scene_cache.cpp).
#pragma once

#include <type_traits>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Large arrays of plain data without padding, copied bytewise.
template <typename Visit>
void visit_arrays(Scene& scene, Visit&& visit) {
  visit(scene.positions);
  visit(scene.frames);
  visit(scene.tangents);
  visit(scene.uvs);
  visit(scene.extras);
  visit(scene.indices);
  visit(scene.vertex_sources);
  visit(scene.variant_materials);
  visit(scene.influences);
  visit(scene.morph_deltas);
  visit(scene.joint_bounds);
  visit(scene.joints);
  visit(scene.morph_weights);
  visit(scene.key_times_s);
  visit(scene.key_values);
  for (Image& image : scene.images) visit(image.rgba8.stored());
}

// All other members. Visit accepts any number of arguments.
template <typename Visit>
void visit_members(Node& n, Visit&& visit) {
  visit(n.name, n.path, n.parent, n.parent_from_node, n.world_from_node, n.translation, n.rotation, n.scale,
        n.given_by_matrix, n.mesh, n.camera, n.light, n.skin, n.first_morph_weight, n.morph_weight_count,
        n.semantic, n.has_instance_vertices);
}

template <typename Visit>
void visit_members(Primitive& p, Visit&& visit) {
  visit(p.topology, p.lit, p.first_index, p.index_count, p.first_vertex, p.vertex_count, p.material,
        p.bounds_min, p.bounds_max, p.first_influence, p.influence_sets, p.joint_limit, p.first_joint_bounds,
        p.joint_bounds_count, p.first_morph_delta, p.morph_target_count, p.first_vertex_source,
        p.file_vertex_count, p.first_variant_material);
}

template <typename Visit>
void visit_members(Mesh& m, Visit&& visit) {
  visit(m.name, m.first_primitive, m.primitive_count, m.morph_target_count, m.unbounded);
}

template <typename Visit>
void visit_members(Skin& s, Visit&& visit) {
  visit(s.name, s.first_joint, s.joint_count);
}

template <typename Visit>
void visit_members(Animation& a, Visit&& visit) {
  visit(a.name, a.first_channel, a.channel_count, a.duration_s);
}

template <typename Visit>
void visit_members(AnimationChannel& c, Visit&& visit) {
  visit(c.node, c.path, c.interpolation, c.width, c.first_time, c.key_count, c.first_value);
}

template <typename Visit>
void visit_members(TextureRef& t, Visit&& visit) {
  visit(t.texture, t.uv_set, t.uv_offset, t.uv_rotation_rad, t.uv_scale);
}

template <typename Visit>
void visit_members(Material& m, Visit&& visit) {
  visit(m.name, m.base_color, m.metallic, m.roughness, m.emissive, m.normal_scale, m.occlusion_strength,
        m.alpha_cutoff, m.alpha_mode, m.double_sided, m.unlit, m.base_color_texture,
        m.metallic_roughness_texture, m.normal_texture, m.occlusion_texture, m.emissive_texture, m.ior,
        m.specular, m.specular_color, m.clearcoat, m.clearcoat_roughness, m.clearcoat_normal_scale,
        m.sheen_color, m.sheen_roughness, m.transmission, m.thickness, m.attenuation_color,
        m.attenuation_distance_m, m.dispersion, m.diffuse_transmission, m.diffuse_transmission_color,
        m.diffuse_transmission_texture, m.diffuse_transmission_color_texture, m.specular_texture,
        m.specular_color_texture, m.clearcoat_texture, m.clearcoat_roughness_texture,
        m.clearcoat_normal_texture, m.sheen_color_texture, m.sheen_roughness_texture, m.transmission_texture,
        m.anisotropy, m.anisotropy_rotation_rad, m.anisotropy_texture, m.iridescence, m.iridescence_ior,
        m.iridescence_thickness_min_nm, m.iridescence_thickness_max_nm, m.iridescence_texture,
        m.iridescence_thickness_texture);
}

// All textures of a material, those that it lacks, too.
template <typename Visit>
void visit_textures(Material& material, Visit&& visit) {
  const auto visit_texture = [&](auto& member) {
    if constexpr (std::is_same_v<decltype(member), TextureRef&>) visit(member);
  };
  visit_members(material, [&](auto&... members) { (visit_texture(members), ...); });
}
template <typename Visit>
void visit_textures(const Material& material, Visit&& visit) {
  visit_textures(const_cast<Material&>(material), [&](const TextureRef& texture) { visit(texture); });
}

template <typename Visit>
void visit_members(Sampler& s, Visit&& visit) {
  visit(s.wrap_u, s.wrap_v, s.nearest_mag, s.nearest_min, s.nearest_mip, s.use_mips);
}

template <typename Visit>
void visit_members(Texture& t, Visit&& visit) {
  visit(t.image, t.sampler, t.srgb);
}

template <typename Visit>
void visit_members(Image& i, Visit&& visit) {
  visit(i.name, i.width, i.height);
}

template <typename Visit>
void visit_members(Light& l, Visit&& visit) {
  visit(l.name, l.type, l.color, l.intensity, l.range_m, l.radius_m, l.angular_radius_rad, l.inner_cone_rad,
        l.outer_cone_rad, l.spread, l.casts_shadow, l.is_default);
}

template <typename Visit>
void visit_members(Camera& c, Visit&& visit) {
  visit(c.name, c.orthographic, c.vertical_fov_rad, c.aspect, c.near_m, c.far_m, c.half_extent_m, c.exposure,
        c.lens.f_number, c.lens.focus_distance_m, c.pixel_aspect, c.principal_point);
}

template <typename Visit>
void visit_members(Scene& s, Visit&& visit) {
  visit(s.nodes, s.meshes, s.primitives, s.skins, s.animations, s.channels, s.materials, s.variants,
        s.textures, s.images, s.sky_texture, s.lights, s.cameras, s.view_from, s.bounds_min, s.bounds_max,
        s.warnings);
}

}  // namespace fire3dv::scene
