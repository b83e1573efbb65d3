// From a point of a surface to the light that leaves it towards the eye: the one text that every raster path shades by.
#ifndef FIRE3DV_SHADING_GLSL
#define FIRE3DV_SHADING_GLSL
#include "common/buffers.glsl"
#include "common/textures.glsl"
#include "common/brdf.glsl"
#include "common/environment.glsl"
#include "common/lights.glsl"
#include "common/surface_point.glsl"

// Defined by the shader that includes this: the share of a light that reaches the point, 0 to 1.
float light_visibility(uint light_index, LightSample light, SurfacePoint point);

vec4 surface_base_color(MaterialRecord material, SurfacePoint point) {
  return material.base_color * point.color *
         sample_or(material.base_color_texture, point.uv, point.uv_dx, point.uv_dy, vec4(1));
}

vec3 mapped_normal(TextureUse normal_texture, float normal_scale, SurfacePoint point) {
  if (normal_texture.texture == FIRE3DV_NO_INDEX) return point.normal_world;
  vec3 n = sample_or(normal_texture, point.uv, point.uv_dx, point.uv_dy, vec4(0.5, 0.5, 1, 1)).xyz * 2 - 1;
  n.xy *= normal_scale;
  const vec3 t = point.tangent_world.xyz - point.normal_world * dot(point.normal_world, point.tangent_world.xyz);
  if (dot(t, t) < 1e-20) return point.normal_world;
  const vec3 tangent = normalize(t);
  const vec3 bitangent = cross(point.normal_world, tangent) * point.tangent_world.w;
  return normalize(tangent * n.x + bitangent * n.y + point.normal_world * n.z);
}

// Linear HDR colour, premultiplied, and alpha.
vec4 shade(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point) {
  const float kLargestHalf = 65504;  // of the target's format: beyond it lies infinity, and then NaN
  const float alpha = (material.flags & FIRE3DV_MATERIAL_BLEND) != 0 ? base_color.a : 1;
  if ((material.flags & FIRE3DV_MATERIAL_UNLIT) != 0) return vec4(min(base_color.rgb, vec3(kLargestHalf)) * alpha, alpha);

  const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
  const vec4 metallic_roughness = sample_or(material.metallic_roughness_texture, uv, dx, dy, vec4(1));
  const float metallic = material.metallic * metallic_roughness.b;
  Surface surface;
  surface.position_world = point.position_world;
  surface.normal = mapped_normal(material.normal_texture, material.normal_scale, point);
  surface.to_eye = normalize(globals.value.eye_world - point.position_world);
  surface.roughness = material.roughness * metallic_roughness.g;
  surface.diffuse_color = base_color.rgb * (1 - metallic);
  surface.f0 = mix(vec3(0.04), base_color.rgb, metallic);

  const float occlusion_sample = sample_or(material.occlusion_texture, uv, dx, dy, vec4(1)).r;
  const float occlusion = 1 + material.occlusion_strength * (occlusion_sample - 1);
  vec3 radiance = material.emissive * sample_or(material.emissive_texture, uv, dx, dy, vec4(1)).rgb;
  radiance += globals.value.ambient * reflect_environment(surface, occlusion);

  for (uint i = 0; i < globals.value.light_count; ++i) {
    const LightRecord light = LightRef(globals.value.lights).at[i];
    const LightSample s =
        sample_light(light, AffineRowsRef(globals.value.world_from_node).at[light.node], point.position_world);
    const vec3 reflected = reflect_light(surface, s.to_light) * s.irradiance;
    if (max(reflected.r, max(reflected.g, reflected.b)) <= 0) continue;
    radiance += reflected * light_visibility(i, s, point);
  }
  return vec4(min(radiance, vec3(kLargestHalf)) * alpha, alpha);
}

#endif
