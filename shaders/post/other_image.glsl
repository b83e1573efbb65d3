// Another image of the same scene: where it shows a point, and whether something hides the point there.
#ifndef FIRE3DV_OTHER_IMAGE_GLSL
#define FIRE3DV_OTHER_IMAGE_GLSL
#include "common/visible_triangle.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DepthRef { float at[]; };

#define kNotANumber uintBitsToFloat(0x7fc00000u)

// Relative difference of depths of one surface whose triangles meet at an angle.
const float kSameDepth = 2e-3;

struct OtherImage {
  mat4 clip_from_world;
  vec3 eye_world, look_world;
  vec3 world_from_ndc_x, world_from_ndc_y, world_from_ndc_origin;  // as in Globals
  uint orthographic;
  uint64_t depth;  // float[pixel]
  uvec2 size;      // pixels
};

vec2 pixels_of(uvec2 size, vec4 clip) {
  precise const vec2 pixels = (clip.xy / clip.w * 0.5 + 0.5) * vec2(size);
  return pixels;
}

vec4 clip_direction(mat4 clip_from_world, vec3 direction) {
  precise const vec4 clip = clip_from_world * vec4(direction, 0);
  return clip;
}

// How the image shows a point of a triangle with these corners. The triangle's plane is compared at the centre of
// the image's pixel, where its depth is exact.
uint occlusion_in(OtherImage image, vec3 corner[3], vec3 point) {
  const vec4 clip = clip_position(image.clip_from_world, point);
  if (clip.w <= 0 || clip.z > clip.w || clip.z < 0) return FIRE3DV_OUTSIDE;  // near, or beyond the far plane
  const vec2 place = pixels_of(image.size, clip);
  if (any(lessThan(place, vec2(0))) || any(greaterThanEqual(place, vec2(image.size)))) return FIRE3DV_OUTSIDE;
  const uvec2 pixel = uvec2(place);
  const vec2 ndc = (vec2(pixel) + 0.5) / vec2(image.size) * 2 - 1;
  const vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
  float depth_m = dot(point - image.eye_world, image.look_world), at_center;
  if (image.orthographic == 0) {
    const vec3 ray = image.world_from_ndc_x * ndc.x + image.world_from_ndc_y * ndc.y + image.world_from_ndc_origin;
    at_center = dot(normal, point - image.eye_world) / dot(normal, ray);
  } else {
    const mat4 rows = transpose(image.clip_from_world);
    const vec2 aside = ndc - clip.xy;
    const vec3 offset = rows[0].xyz * (aside.x / dot(rows[0].xyz, rows[0].xyz)) + rows[1].xyz * (aside.y / dot(rows[1].xyz, rows[1].xyz));
    at_center = depth_m - dot(normal, offset) / dot(normal, image.look_world);
  }
  // A plane seen edge-on has no depth at the centre.
  if (abs(at_center - depth_m) < 0.5 * depth_m) depth_m = at_center;
  const float shown_m = DepthRef(image.depth).at[pixel.y * image.size.x + pixel.x];
  return shown_m < depth_m * (1 - kSameDepth) ? FIRE3DV_HIDDEN : FIRE3DV_SEEN;
}

#endif
