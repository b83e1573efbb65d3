// Where in a pixel of 4 samples a surface is looked at: the middle of its samples, or of the pixel when it has all.
#ifndef FIRE3DV_SAMPLE_PLACE_GLSL
#define FIRE3DV_SAMPLE_PLACE_GLSL

// From the pixel's middle, in pixels.
vec2 sample_place(uint samples) {
  const vec2 positions[4] = vec2[4](vec2(-0.125, -0.375), vec2(0.375, -0.125), vec2(-0.375, 0.125), vec2(0.125, 0.375));
  vec2 sum = vec2(0);
  int count = 0;
  for (int s = 0; s < 4; ++s) {
    if ((samples & (1u << s)) == 0) continue;
    sum += positions[s];
    ++count;
  }
  return count == 0 || count == 4 ? vec2(0) : sum / count;
}

#endif
