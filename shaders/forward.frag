// Shades one fragment. Writes linear HDR colour, premultiplied where it is blended.
// Variants: FIRE3DV_RAY_QUERY traces shadows, FIRE3DV_ALPHA_MASK discards, FIRE3DV_DUAL_SOURCE tints what lies behind.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/shading.glsl"
#ifdef FIRE3DV_RAY_QUERY
#include "common/ray_offset.glsl"
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
layout(location = 7) in vec4 in_uv_center;

#ifdef FIRE3DV_DUAL_SOURCE
layout(location = 0, index = 0) out vec4 out_color;
layout(location = 0, index = 1) out vec4 out_behind;
#else
layout(location = 0) out vec4 out_color;
#endif

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
#ifdef FIRE3DV_RAY_QUERY
  GlobalsRef globals = GlobalsRef(push.globals);
  if (globals.value.shadows == FIRE3DV_SHADOWS_INLINE) {
    // On the side that the light is on, so that thin sheets lit from behind are not taken for their own shadow.
    const vec3 normal = point.plane_normal_world;
    const vec3 side = dot(normal, light.to_light) < 0 ? -normal : normal;
    const vec3 origin = offset_from_surface(point.position_world, side, globals.value.eye_world, point.pixel_size_m);
    if (is_shadowed(globals, origin, light.to_light, light.distance_m)) return 0;
  }
#endif
  return 1;
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[in_material];

  SurfacePoint point;
  point.material = in_material;
  point.tangent_world = in_tangent_world;
  point.uv = in_uv;
  point.uv_dx = dFdx(in_uv_center);
  point.uv_dy = dFdy(in_uv_center);
  point.color = in_color;
  // The triangle's plane, from inputs at the pixel's middle; its normal on the viewer's side. The centroid lies inside
  // the triangle but, as some drivers interpolate, a little off its plane: it is put back.
  const vec3 along_x = dFdx(in_position_center), along_y = dFdy(in_position_center);
  // Far from the origin and close to the eye, all corners of a pixel may round to one point: no plane to be had then.
  const vec3 plane = cross(along_x, along_y);
  vec3 normal = normalize(dot(plane, plane) > 0 ? plane : in_normal_world);
  point.position_world = in_position_world - normal * dot(normal, in_position_world - in_position_center);
  if (dot(normal, globals.value.eye_world - point.position_world) < 0) normal = -normal;
  point.plane_normal_world = normal;
  point.pixel_size_m = min(length(along_x), length(along_y));
  point.normal_world = normalize(in_normal_world);
  if (!gl_FrontFacing) point.normal_world = -point.normal_world;

  const vec4 base_color = surface_base_color(material, point);
#ifdef FIRE3DV_ALPHA_MASK
  if (base_color.a < material.alpha_cutoff) discard;
#endif
#ifdef FIRE3DV_DUAL_SOURCE
  vec3 behind;
  out_color = shade(globals, material, base_color, point, behind);
  out_behind = vec4(behind, 1 - out_color.a);
#else
  out_color = shade(globals, material, base_color, point);
#endif
}
