// Parameters of flow between two images of a camera.
#ifndef FIRE3DV_SHARED_FLOW_TYPES_H
#define FIRE3DV_SHARED_FLOW_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Surface point of a pixel, in terms that hold in other frames of the scene.
struct SurfaceReference {
  uint id;  // of a triangle, as in the visibility buffer; 0: background
  vec3 barycentrics;
  vec2 position_px;  // where the image shows the point
};

struct SurfaceReferencesPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS references;  // SurfaceReference[pixel]
  vec3 look_world;             // unit view direction
  uint orthographic;
};

// Flow from an earlier image to the current one.
struct FlowWanted {
  FIRE3DV_ADDRESS globals;        // of the current image
  FIRE3DV_ADDRESS references;     // SurfaceReference[pixel] of the earlier one
  FIRE3DV_ADDRESS hidden;         // uint[node / 32]: bits of nodes that are hidden now; 0: none is
  FIRE3DV_ADDRESS labels;         // PartLabels[part]
  FIRE3DV_ADDRESS depth;          // float[pixel] of the current image
  FIRE3DV_ADDRESS flow;           // vec2[pixel]
  FIRE3DV_ADDRESS occlusion;      // uint[pixel]: FIRE3DV_SEEN, _HIDDEN or _OUTSIDE
  vec3 earlier_world_from_ndc_x;  // as in Globals
  vec3 earlier_world_from_ndc_y;
  vec3 earlier_world_from_ndc_origin;
  uint earlier_orthographic;
  vec3 look_world;  // of the current image
  uint orthographic;
};

struct FlowPush {
  FIRE3DV_ADDRESS wanted;  // FlowWanted
};

FIRE3DV_SHARED_END
#endif
