// Mappings from directions to equirectangular images and cube maps.
#ifndef FIRE3DV_DIRECTIONS_GLSL
#define FIRE3DV_DIRECTIONS_GLSL

// Inverse of scene::environment_direction(): -Z in the middle, +X to the right of it.
vec2 equirectangular_uv(vec3 direction) {
  const float turn = 1 / 6.28318530717959;
  // At the poles any u is valid, but atan(0, 0) is undefined.
  const bool polar = direction.x == 0 && direction.z == 0;
  return vec2(0.5 + (polar ? 0 : atan(direction.x, -direction.z) * turn), acos(clamp(direction.y, -1, 1)) * 2 * turn);
}

// Position of a texel's centre on its face, -1 to 1, x to the right and y down.
vec2 face_point(ivec2 texel, int size) { return (2 * (vec2(texel) + 0.5) - size) / size; }

// Vulkan's cube maps ("Cube Map Face Selection"). Not normalised: a point on the cube.
vec3 cube_direction(int face, vec2 p) {
  switch (face) {
    case 0: return vec3(1, -p.y, -p.x);
    case 1: return vec3(-1, -p.y, p.x);
    case 2: return vec3(p.x, 1, p.y);
    case 3: return vec3(p.x, -1, -p.y);
    case 4: return vec3(p.x, -p.y, 1);
    default: return vec3(-p.x, -p.y, -1);
  }
}

// Solid angle of a texel, up to a constant factor; it shrinks towards a face's corners.
float texel_solid_angle(vec2 p) { return pow(1 + dot(p, p), -1.5); }

// Point i of n low-discrepancy points in the unit square, deterministic (Hammersley 1960).
vec2 hammersley(uint i, uint n) { return vec2((float(i) + 0.5) / n, float(bitfieldReverse(i)) * 2.3283064365386963e-10); }

// Orthonormal basis around a unit normal (Duff et al. 2017).
mat3 frame_around(vec3 n) {
  const float s = n.z >= 0 ? 1 : -1;
  const float a = -1 / (s + n.z), b = n.x * n.y * a;
  return mat3(vec3(1 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

#endif
