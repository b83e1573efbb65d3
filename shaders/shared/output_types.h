// Parameters of the image output planes: depth, labels, normals, motion, materials and silhouettes beside an
// image's colour.
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
  FIRE3DV_ADDRESS depth;      // float[pixel]
  FIRE3DV_ADDRESS instance;   // uint[pixel]
  FIRE3DV_ADDRESS semantic;   // uint[pixel]
  FIRE3DV_ADDRESS normal;     // uvec2[pixel]: four half floats
  FIRE3DV_ADDRESS motion;     // vec2[pixel]
  FIRE3DV_ADDRESS albedo;     // uvec2[pixel]: four half floats
  FIRE3DV_ADDRESS roughness;  // float[pixel]
  FIRE3DV_ADDRESS metallic;   // float[pixel]
  FIRE3DV_ADDRESS position;   // vec4[pixel]
  FIRE3DV_ADDRESS occlusion;  // uint[pixel]: FIRE3DV_SEEN, _HIDDEN or _OUTSIDE
  FIRE3DV_ADDRESS labels;     // PartLabels[part]
  // Of the camera's last image; 0: there is none. AffineRows[node]; vec3[vertex] of the vertices that deform,
  // from first_deforming_vertex on; float[pixel].
  FIRE3DV_ADDRESS last_world_from_node;
  FIRE3DV_ADDRESS last_positions;
  FIRE3DV_ADDRESS last_depth;
  mat4 last_clip_from_world;
  vec3 last_eye_world;
  uint first_deforming_vertex;
  vec3 last_look_world;        // unit view direction
  vec3 last_world_from_ndc_x;  // as in Globals
  vec3 last_world_from_ndc_y;
  vec3 last_world_from_ndc_origin;
  uint last_orthographic;
  vec3 look_world;  // unit view direction
  uint orthographic;
};

// Word of the transforms and vertices of nodes that the last image had hidden.
#define FIRE3DV_NO_PLACE 0xffffffffu

// Values of the occlusion plane: how the camera's last image showed a visible point.
#define FIRE3DV_SEEN 0u
#define FIRE3DV_HIDDEN 1u
#define FIRE3DV_OUTSIDE 2u

struct OutputsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS wanted;      // OutputsWanted
};

// How a primitive instance is drawn into silhouettes and labels.
struct LabelPart {
  uint slot;         // bit of its instance's silhouette; FIRE3DV_NO_INDEX: it has none
  uint is_overlaid;  // 1: drawn into the labels, which the visibility buffer lacks
  float
      alpha_limit;  // least alpha of its surface; 0: the whole surface; FIRE3DV_ALPHA_CUTOFF: the material's
};
#define FIRE3DV_ALPHA_CUTOFF (-1.0f)

// Silhouettes of instances drawn alone, or labels of blended surfaces.
struct SilhouettesWanted {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS parts;       // LabelPart[part]
  FIRE3DV_ADDRESS bits;        // uint[slot / 32][pixel], one bit per slot; 0: labels are drawn
  FIRE3DV_ADDRESS truncated;   // uint[slot / 32]: bits of the silhouettes that leave the image
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]: labels are drawn into this copy
  uint cluster_count;
};

struct SilhouettesPush {
  FIRE3DV_ADDRESS wanted;  // SilhouettesWanted
};

// Lens distortion of an image, from its pinhole source. Addresses of 0: not requested. Planes as above.
struct LensWanted {
  FIRE3DV_ADDRESS color_in, color_out;    // uint[pixel]: four bytes
  FIRE3DV_ADDRESS linear_in, linear_out;  // uvec2[pixel]: four half floats
  FIRE3DV_ADDRESS light_in, light_out;    // SensorRecord::light
  FIRE3DV_ADDRESS depth_in, depth_out;
  FIRE3DV_ADDRESS instance_in, instance_out;  // in: also wherever depth is requested
  FIRE3DV_ADDRESS semantic_in, semantic_out;
  FIRE3DV_ADDRESS normal_in, normal_out;
  FIRE3DV_ADDRESS motion_in, motion_out;
  FIRE3DV_ADDRESS albedo_in, albedo_out;
  FIRE3DV_ADDRESS roughness_in, roughness_out;
  FIRE3DV_ADDRESS metallic_in, metallic_out;
  FIRE3DV_ADDRESS position_in, position_out;
  FIRE3DV_ADDRESS occlusion_in, occlusion_out;
  uint width, height, width_in, height_in;  // pixels
  vec2 focal, principal_point, focal_in,
      principal_point_in;  // pixels; the centre of the upper left pixel is (0, 0)
  vec4 coefficients;       // first four lens coefficients
  float last_coefficient;
  float largest_radius;
  uint fisheye;       // 0: plumb_bob
  float mask_radius;  // as in SensorRecord
  float mask_cut;
};

struct LensPush {
  FIRE3DV_ADDRESS wanted;  // LensWanted
};

FIRE3DV_SHARED_END
#endif
