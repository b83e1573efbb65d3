// Enlargement of a level of the bloom chain: bilinear, the transpose of bloom_down.comp. Texels outside have no weight.
#ifndef FIRE3DV_BLOOM_GLSL
#define FIRE3DV_BLOOM_GLSL

vec4 texel_or_nothing(sampler2D level, ivec2 texel) {
  const bool outside = any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, textureSize(level, 0)));
  return outside ? vec4(0) : texelFetch(level, texel, 0);
}

// texel: of an image twice as wide and high.
vec4 enlarged(sampler2D level, ivec2 texel) {
  const ivec2 nearest = texel >> 1, next = nearest + 2 * (texel & 1) - 1;
  return (9 * texelFetch(level, nearest, 0) + 3 * texel_or_nothing(level, ivec2(next.x, nearest.y)) +
          3 * texel_or_nothing(level, ivec2(nearest.x, next.y)) + texel_or_nothing(level, next)) / 16;
}

// Blurred light of a pixel, from the first level. The weight is less than 1 near the image's edges.
vec3 blurred_light(sampler2D first_level, ivec2 pixel) {
  const vec4 light = enlarged(first_level, pixel);
  return light.rgb / light.a;
}

#endif
