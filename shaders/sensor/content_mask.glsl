// Content mask of an endoscope: a disc around the image's centre, which may be cut above and below. Lengths in
// halves of the image's height; a radius of 0: no mask.
#ifndef FIRE3DV_CONTENT_MASK_GLSL
#define FIRE3DV_CONTENT_MASK_GLSL

const float kMaskEdgePixels = 2;

// Signed distance to the mask's edge in pixels, positive inside.
float inside_mask(uvec2 pixel, uvec2 size, float radius, float cut) {
  const float half_height = 0.5 * size.y;
  const vec2 at = (vec2(pixel) + 0.5 - 0.5 * vec2(size)) / half_height;
  const float inside = radius - length(at);
  return half_height * (cut > 0 ? min(inside, cut - abs(at.y)) : inside);
}

// Labels have a hard edge.
bool is_in_mask(uvec2 pixel, uvec2 size, float radius, float cut) {
  return radius == 0 || inside_mask(pixel, size, radius, cut) >= 0;
}

// Share of a pixel's colour.
float mask_coverage(uvec2 pixel, uvec2 size, float radius, float cut) {
  return radius == 0 ? 1 : clamp(inside_mask(pixel, size, radius, cut) / kMaskEdgePixels + 0.5, 0, 1);
}

#endif
