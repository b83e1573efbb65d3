// What vertices have beside their positions, as renderer/scene/packed_vertices.cpp packs it.
#ifndef FIRE3DV_VERTICES_GLSL
#define FIRE3DV_VERTICES_GLSL
#include "common/buffers.glsl"

#define FIRE3DV_NORMAL_STEPS 32767.0
#define FIRE3DV_TANGENT_STEPS 8192.0

// Times FIRE3DV_NORMAL_STEPS.
vec3 long_normal(FrameRecord frame) {
  return vec3(int(frame.normal_xy << 16) >> 16, int(frame.normal_xy) >> 16, int(frame.normal_z_tangent << 16) >> 16);
}

vec3 normal_of(FrameRecord frame) { return long_normal(frame) / FIRE3DV_NORMAL_STEPS; }

void basis_around(FrameRecord frame, out vec3 x, out vec3 y) {
  const vec3 n = normal_of(frame);
  const float s = n.z >= 0 ? 1 : -1, a = -1 / (s + n.z), b = n.x * n.y * a;
  x = vec3(1 + s * n.x * n.x * a, s * b, -s * n.x);
  y = vec3(b, s + n.y * n.y * a, -n.y);
}

// w: the bitangent's sign.
vec4 tangent_of(FrameRecord frame) {
  const float along = float(frame.normal_z_tangent >> 17) / FIRE3DV_TANGENT_STEPS;
  const vec2 place = along <= 2 ? vec2(1 - along, 1 - abs(1 - along)) : vec2(along - 3, abs(along - 3) - 1);
  vec3 x, y;
  basis_around(frame, x, y);
  return vec4(normalize(x * place.x + y * place.y), (frame.normal_z_tangent & 0x10000u) != 0 ? 1 : -1);
}

// Both unit vectors, perpendicular to each other.
FrameRecord packed_frame(vec3 normal, vec3 tangent, float bitangent_sign) {
  const ivec3 n = ivec3(round(normal * FIRE3DV_NORMAL_STEPS));
  FrameRecord frame = FrameRecord((uint(n.x) & 0xffffu) | uint(n.y) << 16, uint(n.z) & 0xffffu);
  vec3 x, y;
  basis_around(frame, x, y);
  const vec2 place = vec2(dot(x, tangent), dot(y, tangent));
  const float across = place.x / (abs(place.x) + abs(place.y)), along = place.y >= 0 ? 1 - across : 3 + across;
  frame.normal_z_tangent |= (uint(round(along * FIRE3DV_TANGENT_STEPS)) & 0x7fffu) << 17 | (bitangent_sign < 0 ? 0 : 0x10000u);
  return frame;
}

vec2 uv1_of(ExtrasRef extras, uint vertex) { return uint64_t(extras) != 0 ? extras.at[vertex].uv1 : vec2(0); }

vec4 color_of(ExtrasRef extras, uint vertex) {
  if (uint64_t(extras) == 0) return vec4(1);
  return vec4(unpackUnorm2x16(extras.at[vertex].color_rg), unpackUnorm2x16(extras.at[vertex].color_ba));
}

#endif
