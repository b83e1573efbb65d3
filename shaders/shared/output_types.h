// Parameters of the image output planes: depth, labels, normals and motion beside an image's colour.
#ifndef FIRE3DV_SHARED_OUTPUT_TYPES_H
#define FIRE3DV_SHARED_OUTPUT_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Labels of a primitive instance.
struct PartLabels {
  uint instance;
  uint semantic;
};

// Requested outputs of one image. Planes are top-down rows without gaps; an address of 0: not requested.
struct OutputsWanted {
  FIRE3DV_ADDRESS depth;     // float[pixel]
  FIRE3DV_ADDRESS instance;  // uint[pixel]
  FIRE3DV_ADDRESS semantic;  // uint[pixel]
  FIRE3DV_ADDRESS normal;    // uvec2[pixel]: four half floats
  FIRE3DV_ADDRESS motion;    // vec2[pixel]
  FIRE3DV_ADDRESS labels;    // PartLabels[part]
  // AffineRows[node] of the camera's last image; 0: there is none.
  FIRE3DV_ADDRESS last_world_from_node;
  mat4 last_clip_from_world;
  vec3 look_world;  // unit view direction
  uint orthographic;
};

struct OutputsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS wanted;      // OutputsWanted
};

// Lens distortion of an image, from its pinhole source. Addresses of 0: not requested. Planes as above.
struct LensWanted {
  FIRE3DV_ADDRESS color_in, color_out;    // uint[pixel]: four bytes
  FIRE3DV_ADDRESS linear_in, linear_out;  // uvec2[pixel]: four half floats
  FIRE3DV_ADDRESS depth_in, depth_out;
  FIRE3DV_ADDRESS instance_in, instance_out;  // in: also wherever depth is requested
  FIRE3DV_ADDRESS semantic_in, semantic_out;
  FIRE3DV_ADDRESS normal_in, normal_out;
  FIRE3DV_ADDRESS motion_in, motion_out;
  uint width, height, width_in, height_in;  // pixels
  vec2 focal, principal_point, focal_in,
      principal_point_in;  // pixels; the centre of the upper left pixel is (0, 0)
  vec4 coefficients;       // first four lens coefficients
  float last_coefficient;
  float largest_radius;
  uint fisheye;  // 0: plumb_bob
};

struct LensPush {
  FIRE3DV_ADDRESS wanted;  // LensWanted
};

FIRE3DV_SHARED_END
#endif
