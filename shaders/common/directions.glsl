// Directions and the pictures that hold something for each of them: equirectangular images and cubes.
#ifndef FIRE3DV_DIRECTIONS_GLSL
#define FIRE3DV_DIRECTIONS_GLSL

// As scene::environment_direction() has it, backwards: -Z in the middle, +X to the right of it.
vec2 equirectangular_uv(vec3 direction) {
  const float turn = 1 / 6.28318530717959;
  // Straight up and down any u is right, but atan(0, 0) is nothing.
  const bool polar = direction.x == 0 && direction.z == 0;
  return vec2(0.5 + (polar ? 0 : atan(direction.x, -direction.z) * turn), acos(clamp(direction.y, -1, 1)) * 2 * turn);
}

// Where a texel's middle lies on its face, -1 to 1, x to the right and y down.
vec2 face_point(ivec2 texel, int size) { return (2 * (vec2(texel) + 0.5) - size) / size; }

// Vulkan's cube maps ("Cube Map Face Selection"). Not normalised: on the cube.
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

// Of a texel in the corner of a face a smaller part of the sphere is seen. Up to a factor that is the same for all.
float texel_solid_angle(vec2 p) { return pow(1 + dot(p, p), -1.5); }

// The i-th of n points that fill the unit square evenly, the same ones each time (Hammersley 1960).
vec2 hammersley(uint i, uint n) { return vec2((float(i) + 0.5) / n, float(bitfieldReverse(i)) * 2.3283064365386963e-10); }

// Two axes across a unit normal (Duff et al. 2017).
mat3 frame_around(vec3 n) {
  const float s = n.z >= 0 ? 1 : -1;
  const float a = -1 / (s + n.z), b = n.x * n.y * a;
  return mat3(vec3(1 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

#endif
