// Decoding of packed vertex attributes; renderer/scene/model/vertices.cpp packs them.
#ifndef FIRE3DV_VERTICES_GLSL
#define FIRE3DV_VERTICES_GLSL
#include "common/buffers.glsl"

#define FIRE3DV_DIRECTION_STEPS 32767.0
#define FIRE3DV_TANGENT_Z_STEPS 16383.0
#define FIRE3DV_NO_TANGENT 32767u

float low_half(uint word) { return int(word << 16) >> 16; }
float high_half(uint word) { return int(word) >> 16; }

// Scaled by FIRE3DV_DIRECTION_STEPS.
vec3 long_normal(FrameRecord frame) {
  return vec3(low_half(frame.normal_xy), high_half(frame.normal_xy), low_half(frame.normal_z_tangent_z));
}

vec3 normal_of(FrameRecord frame) { return long_normal(frame) / FIRE3DV_DIRECTION_STEPS; }

uint tangent_xy_of(UintRef tangents, uint vertex) { return uint64_t(tangents) != 0 ? tangents.at[vertex] : FIRE3DV_NO_TANGENT; }

// w: the bitangent's sign.
vec4 tangent_of(FrameRecord frame, uint tangent_xy) {
  return vec4(vec2(low_half(tangent_xy), high_half(tangent_xy)) * (1 / FIRE3DV_DIRECTION_STEPS),
              (int(frame.normal_z_tangent_z) >> 17) * (1 / FIRE3DV_TANGENT_Z_STEPS),
              (frame.normal_z_tangent_z & 0x10000u) != 0 ? 1 : -1);
}

uint packed_halves(float low, float high) {
  const ivec2 steps = ivec2(round(vec2(low, high) * FIRE3DV_DIRECTION_STEPS));
  return (uint(steps.x) & 0xffffu) | uint(steps.y) << 16;
}

// Inputs are unit vectors. w: the bitangent's sign.
FrameRecord packed_frame(vec3 normal, vec4 tangent) {
  const uint z = uint(int(round(tangent.z * FIRE3DV_TANGENT_Z_STEPS))) << 17 | (tangent.w < 0 ? 0 : 0x10000u);
  return FrameRecord(packed_halves(normal.x, normal.y), (packed_halves(normal.z, 0) & 0xffffu) | z);
}

vec2 uv1_of(ExtrasRef extras, uint vertex) { return uint64_t(extras) != 0 ? extras.at[vertex].uv1 : vec2(0); }

vec4 color_of(ExtrasRef extras, uint vertex) {
  if (uint64_t(extras) == 0) return vec4(1);
  return vec4(unpackUnorm2x16(extras.at[vertex].color_rg), unpackUnorm2x16(extras.at[vertex].color_ba));
}

#endif
