// Shades one fragment: material, lights, shadows. Writes linear HDR colour, premultiplied where it is blended.
// Variants: FIRE3DV_RAY_QUERY traces shadows, FIRE3DV_ALPHA_MASK discards.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/textures.glsl"
#include "common/brdf.glsl"
#include "common/environment.glsl"
#include "common/lights.glsl"
#ifdef FIRE3DV_RAY_QUERY
#include "common/shadow_rays.glsl"
#endif

layout(push_constant, scalar) uniform Push { ForwardPush push; };

layout(location = 0) centroid in vec3 in_position_world;
layout(location = 1) centroid in vec3 in_normal_world;
layout(location = 2) centroid in vec4 in_tangent_world;
layout(location = 3) centroid in vec4 in_uv;
layout(location = 4) centroid in vec4 in_color;
layout(location = 5) flat in uint in_material;
// Not centroid: the derivatives of a centroid input jump at edges.
layout(location = 6) in vec3 in_position_center;

layout(location = 0) out vec4 out_color;

vec3 shading_normal(MaterialRecord material, vec3 vertex_normal) {
  if (material.normal_texture.texture == FIRE3DV_NO_INDEX) return vertex_normal;
  vec3 n = sample_or(material.normal_texture, in_uv, vec4(0.5, 0.5, 1, 1)).xyz * 2 - 1;
  n.xy *= material.normal_scale;
  const vec3 t = in_tangent_world.xyz - vertex_normal * dot(vertex_normal, in_tangent_world.xyz);
  if (dot(t, t) < 1e-20) return vertex_normal;
  const vec3 tangent = normalize(t);
  const vec3 bitangent = cross(vertex_normal, tangent) * in_tangent_world.w;
  return normalize(tangent * n.x + bitangent * n.y + vertex_normal * n.z);
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[in_material];

  const vec4 base_color =
      material.base_color * in_color * sample_or(material.base_color_texture, in_uv, vec4(1));
#ifdef FIRE3DV_ALPHA_MASK
  if (base_color.a < material.alpha_cutoff) discard;
#endif
  const float alpha = (material.flags & FIRE3DV_MATERIAL_BLEND) != 0 ? base_color.a : 1;
  if ((material.flags & FIRE3DV_MATERIAL_UNLIT) != 0) {
    out_color = vec4(min(base_color.rgb, vec3(65504)) * alpha, alpha);
    return;
  }

  // The triangle's plane, from inputs at the pixel's middle; its normal on the viewer's side. The centroid lies inside
  // the triangle but, as some drivers interpolate, a little off its plane: it is put back.
  const vec3 along_x = dFdx(in_position_center), along_y = dFdy(in_position_center);
  // Far from the origin and close to the eye, all corners of a pixel may round to one point: no plane to be had then.
  const vec3 plane = cross(along_x, along_y);
  vec3 geometric_normal = normalize(dot(plane, plane) > 0 ? plane : in_normal_world);
  const vec3 position_world =
      in_position_world - geometric_normal * dot(geometric_normal, in_position_world - in_position_center);
  const vec3 to_eye = normalize(globals.value.eye_world - position_world);
  if (dot(geometric_normal, to_eye) < 0) geometric_normal = -geometric_normal;
  const float pixel_size_m = min(length(along_x), length(along_y));
  vec3 vertex_normal = normalize(in_normal_world);
  if (!gl_FrontFacing) vertex_normal = -vertex_normal;

  const vec4 metallic_roughness = sample_or(material.metallic_roughness_texture, in_uv, vec4(1));
  const float metallic = material.metallic * metallic_roughness.b;
  Surface surface;
  surface.position_world = position_world;
  surface.normal = shading_normal(material, vertex_normal);
  surface.to_eye = to_eye;
  surface.roughness = material.roughness * metallic_roughness.g;
  surface.diffuse_color = base_color.rgb * (1 - metallic);
  surface.f0 = mix(vec3(0.04), base_color.rgb, metallic);

  const float occlusion_sample = sample_or(material.occlusion_texture, in_uv, vec4(1)).r;
  const float occlusion = 1 + material.occlusion_strength * (occlusion_sample - 1);
  vec3 radiance = material.emissive * sample_or(material.emissive_texture, in_uv, vec4(1)).rgb;
  radiance += globals.value.ambient * reflect_environment(surface, occlusion);

  for (uint i = 0; i < globals.value.light_count; ++i) {
    const LightRecord light = LightRef(globals.value.lights).at[i];
    const LightSample s =
        sample_light(light, AffineRowsRef(globals.value.world_from_node).at[light.node], position_world);
    const vec3 reflected = reflect_light(surface, s.to_light) * s.irradiance;
    if (max(reflected.r, max(reflected.g, reflected.b)) <= 0) continue;
#ifdef FIRE3DV_RAY_QUERY
    if (globals.value.shadows != 0) {
      // On the side that the light is on, so that thin sheets lit from behind are not taken for their own shadow.
      const vec3 side = dot(geometric_normal, s.to_light) < 0 ? -geometric_normal : geometric_normal;
      const vec3 origin = offset_from_surface(position_world, side, globals.value.eye_world, pixel_size_m);
      if (is_shadowed(globals, origin, s.to_light, s.distance_m)) continue;
    }
#endif
    radiance += reflected;
  }
  const float kLargestHalf = 65504;  // of the target's format: beyond it lies infinity, and then NaN
  out_color = vec4(min(radiance, vec3(kLargestHalf)) * alpha, alpha);
}
