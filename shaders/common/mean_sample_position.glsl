// Evaluation position of a surface in a pixel of 4 samples: the mean of its samples, or the centre with full
// coverage.
#ifndef FIRE3DV_SAMPLE_POSITION_GLSL
#define FIRE3DV_SAMPLE_POSITION_GLSL

// Offset from the pixel's centre, in pixels.
vec2 mean_sample_position(uint samples) {
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
