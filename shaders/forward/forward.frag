// Forward shading of a fragment. The output is linear HDR colour, premultiplied where it is blended.
// Variants: FIRE3DV_RAY_QUERY traces shadows. FIRE3DV_FORWARD_ONLY draws forward-only surfaces over solid ones.
// FIRE3DV_DUAL_SOURCE scales the background by a second colour. FIRE3DV_VISIBLE_POSITION evaluates 4 samples at
// the mean of the visible ones, like the compute path. FIRE3DV_LAYERS stores the fragment as a layer of its pixel, see
// layers/layers.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef FIRE3DV_LAYERS
#define FIRE3DV_LAYER_FRAGMENT
#include "layers/layers.glsl"
#endif
#include "shading/shading.glsl"
#include "shading/shadow_maps.glsl"
#include "shading/shadow_mask.glsl"
#include "shading/shadow_ray.glsl"
#ifdef FIRE3DV_RAY_QUERY
#include "shading/light_rays.glsl"
#include "shading/shadow_rays.glsl"
#endif

#if defined(FIRE3DV_LAYERS)
#extension GL_EXT_post_depth_coverage : require
layout(early_fragment_tests) in;
layout(post_depth_coverage) in;
layout(push_constant, scalar) uniform Push { LayerPush push; };
layout(location = 10) flat in uint in_first_number;
layout(location = 11) flat in uint in_instance;
layout(location = 12) flat in float in_scale;
#else
layout(push_constant, scalar) uniform Push { ForwardPush push; };
#endif
#ifdef FIRE3DV_VISIBLE_POSITION
// Depth is complete before this pass, so the post-depth coverage contains the visible samples.
#extension GL_EXT_post_depth_coverage : require
layout(early_fragment_tests) in;
layout(post_depth_coverage) in;
#include "common/mean_sample_position.glsl"
#define FIRE3DV_AT_SAMPLE_POSITION(value) interpolateAtOffset(value, offset)
#else
#define FIRE3DV_AT_SAMPLE_POSITION(value) value
#endif

layout(location = 0) centroid in vec3 in_position_world;
layout(location = 1) centroid in vec3 in_normal_world;
layout(location = 2) centroid in vec4 in_tangent_world;
layout(location = 3) centroid in vec4 in_uv;
layout(location = 4) centroid in vec4 in_color;
layout(location = 5) flat in uint in_material;
// Not centroid: the derivatives of a centroid input jump at edges.
layout(location = 6) in vec3 in_position_center;
layout(location = 7) in vec4 in_uv_center;
layout(location = 8) flat in uint in_part_flags;
layout(location = 9) in vec4 in_tangent_plane;

#if defined(FIRE3DV_LAYERS)
#elif defined(FIRE3DV_DUAL_SOURCE)
layout(location = 0, index = 0) out vec4 out_color;
layout(location = 0, index = 1) out vec4 out_behind;
#else
layout(location = 0) out vec4 out_color;
#endif

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
  const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
#ifndef FIRE3DV_FORWARD_ONLY
  if (globals.value.shadows == FIRE3DV_SHADOWS_MASK) {
    const uint pixel = uint(gl_FragCoord.y) * globals.value.width + uint(gl_FragCoord.x);
    return mask_visibility(globals, shadow, pixel, max(findLSB(uint(gl_SampleMaskIn[0])), 0));
  }
#endif
#ifdef FIRE3DV_RAY_QUERY
  if (globals.value.shadows != FIRE3DV_SHADOWS_MAP) {
    const ShadowRay ray = shadow_ray(globals, point, light_index, light);
    const uint pixel = uint(gl_FragCoord.y) * globals.value.width + uint(gl_FragCoord.x);
    return light_that_arrives(globals, shadow, light_index, ray.light, ray.origin, pixel);
  }
#endif
  // Forward-only draws have no shadow mask, but may have shadow maps.
  if (globals.value.light_views == 0) return 1;
  return map_visibility(globals, shadow, map_point(point, light), point.plane_normal_world, light);
}

// smooth_height() from interpolated tangent planes of the vertices. side: -1 for back faces.
float smooth_height(GlobalsRef globals, vec3 along_x, vec3 along_y, float side) {
  const vec3 normal = in_tangent_plane.xyz;
  const float curvature = side * (dot(dFdxFine(normal), along_x) + dot(dFdyFine(normal), along_y));
  const float rounding = 2e-6 * length(normal) * (length(along_x) + length(along_y));
  const float height = side * (in_tangent_plane.w - dot(in_position_center - globals.value.eye_world, normal));
  return curvature > rounding ? max(height / length(normal), 1e-30) : 0;
}

#ifdef FIRE3DV_LAYERS
// Share of light that a volume passes behind its near side: absorbed along its thickness, and reflected at its far side.
// Without rays the light goes straight on.
vec3 passed_by_volume(GlobalsRef globals, MaterialRecord material, SurfacePoint point) {
  const uint needed = FIRE3DV_MATERIAL_VOLUME | FIRE3DV_MATERIAL_TRANSMISSION;
  if (!gl_FrontFacing || (material.flags & needed) != needed) return vec3(1);
  const MaterialExtensionRecord extension = MaterialExtensionRef(globals.value.material_extensions).at[material.extension];
  const float root = (extension.ior - 1) / (extension.ior + 1);
  const float cosine = clamp(dot(point.normal_world, normalize(globals.value.eye_world - point.position_world)), 0, 1);
  const float reflected = mix(root * root, 1, pow(1 - cosine, 5));
  return (1 - reflected) * exp(-extension.absorption_per_m * material.thickness * in_scale);
}
#endif

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  MaterialRecord material = MaterialRef(globals.value.materials).at[in_material];
  if ((in_part_flags & FIRE3DV_PART_UNLIT) != 0) material.flags |= FIRE3DV_MATERIAL_UNLIT;

#ifdef FIRE3DV_VISIBLE_POSITION
  const vec2 offset = mean_sample_position(uint(gl_SampleMaskIn[0]));
#endif
  SurfacePoint point;
  point.material = in_material;
  point.tangent_world = FIRE3DV_AT_SAMPLE_POSITION(in_tangent_world);
  point.uv = FIRE3DV_AT_SAMPLE_POSITION(in_uv);
  point.uv_dx = dFdxFine(in_uv_center);
  point.uv_dy = dFdyFine(in_uv_center);
  point.color = FIRE3DV_AT_SAMPLE_POSITION(in_color);
  // The triangle's plane from inputs at the pixel's centre; its normal points to the viewer. On some drivers
  // a centroid position lies slightly off the plane and is projected back.
  const vec3 along_x = dFdxFine(in_position_center), along_y = dFdyFine(in_position_center);
  // Far from the origin and close to the eye, adjacent positions may round to one point; the plane is then
  // undefined.
  const vec3 plane = cross(along_x, along_y);
  const vec3 vertex_normal = FIRE3DV_AT_SAMPLE_POSITION(in_normal_world);
  vec3 normal = normalize(dot(plane, plane) > 0 ? plane : vertex_normal);
  const vec3 position = FIRE3DV_AT_SAMPLE_POSITION(in_position_world);
  point.position_world = position - normal * dot(normal, position - in_position_center);
  const vec2 ndc = gl_FragCoord.xy / vec2(globals.value.width, globals.value.height) * 2 - 1;
  const vec3 look = globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y +
                    globals.value.world_from_ndc_origin;
  if (dot(normal, look) > 0) normal = -normal;
  point.plane_normal_world = normal;
  point.lift_m = 0;
  point.pixel_size_m = min(length(along_x), length(along_y));
  point.normal_world = normalize(vertex_normal);
  if (!gl_FrontFacing) point.normal_world = -point.normal_world;
  const float height_m = smooth_height(globals, along_x, along_y, gl_FrontFacing ? 1 : -1);
  point.smooth_height_m = (material.flags & FIRE3DV_MATERIAL_PASSES_LIGHT) == 0 ? height_m : 0;

#ifdef FIRE3DV_LAYERS
  // From here on lanes may diverge.
  const LayerTarget target = LayerTargetRef(push.target).value;
  const uint coverage = uint(gl_SampleMaskIn[0]), pixel = layer_pixel(target);
  const LayerFragment fragment = layer_fragment(target, in_first_number + gl_PrimitiveID, coverage, push.is_flat != 0);
  if (!is_shaded(target, pixel, fragment.key, push.pass)) return;
#endif
  const vec4 base_color = surface_base_color(material, point);
#if defined(FIRE3DV_LAYERS)
  vec3 behind;
  const vec4 light = shade(globals, material, base_color, point, behind);
  behind *= passed_by_volume(globals, material, point);
  store_layer(target, pixel, fragment, coverage, push.pass, light.rgb, behind, !is_display_referred, in_instance);
#elif defined(FIRE3DV_DUAL_SOURCE)
  vec3 behind;
  out_color = shade(globals, material, base_color, point, behind);
  out_behind = vec4(behind, 1 - out_color.a);
  if (is_display_referred) out_color.a = 0;
#else
  out_color = shade(globals, material, base_color, point);
  // The target's alpha is the share of scene-referred light. Blending without a second source needs the alpha.
  if (is_display_referred && (material.flags & FIRE3DV_MATERIAL_BLEND) == 0) out_color.a = 0;
#endif
}
