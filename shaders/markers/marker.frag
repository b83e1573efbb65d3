// Colour of a marker, display-referred: the target's alpha, the share of scene-referred light, becomes less.
// Variants: FIRE3DV_DISC cuts points to discs. FIRE3DV_SAMPLES=4 covers the samples inside the disc.
#version 460
layout(location = 0) in vec4 in_color;
layout(location = 1) in vec2 in_disc;
layout(location = 0) out vec4 out_color;

void main() {
#ifdef FIRE3DV_DISC
  const vec2 dx = dFdxFine(in_disc), dy = dFdyFine(in_disc);
#ifdef FIRE3DV_SAMPLES
  // Standard sample positions.
  const vec2 offsets[4] = vec2[4](vec2(-0.125, -0.375), vec2(0.375, -0.125), vec2(-0.375, 0.125), vec2(0.125, 0.375));
  int covered = 0;
  for (int s = 0; s < 4; ++s) {
    const vec2 at = in_disc + dx * offsets[s].x + dy * offsets[s].y;
    if (dot(at, at) <= 1) covered |= 1 << s;
  }
  if (covered == 0) discard;
  gl_SampleMask[0] = covered;
#else
  if (dot(in_disc, in_disc) > 1) discard;
#endif
#endif
  out_color = vec4(in_color.rgb * in_color.a, in_color.a);
}
