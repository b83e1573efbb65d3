// Lights, their maps and their rays.
#ifndef FIRE3DV_SHARED_LIGHT_TYPES_H
#define FIRE3DV_SHARED_LIGHT_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

#define FIRE3DV_LIGHT_DIRECTIONAL 0u
#define FIRE3DV_LIGHT_POINT 1u
#define FIRE3DV_LIGHT_SPOT 2u

struct LightRecord {
  vec3 color;     // linear colour times intensity: candela, or lux for a directional light
  float range_m;  // 0 = infinite
  uint type;
  uint node;         // the light stands at this node and shines along its -Z
  float cone_scale;  // KHR_lights_punctual: attenuation = clamp(cos(angle) * scale + offset, 0, 1)^2
  float cone_offset;
  float radius_m;            // point, spot: 0 = hard shadows
  float angular_radius_rad;  // directional
  uint padding0, padding1;
};

// As it stands now; found by transforms.comp.
struct LightPlace {
  vec3 color;
  float range_m;
  vec3 position_world;
  uint type;
  vec3 shines_along;  // unit, world
  float cone_scale;
  float cone_offset;
  float radius_m;
  float angular_radius_rad;
  float sine;  // of angular_radius_rad
};

// How a light's shadow is found.
struct LightShadow {
  uint first_view;  // of the lights' RasterViews: 1, or 6 sides of a cube
  uint view_count;
  uint mask_word;  // where the mask keeps this light's result
  uint mask_shift;
  uint rays;  // 0: casts none; 1: hard, one bit for each sample; more: soft, 8 bits for each sample
  uint padding0, padding1, padding2;
};

// A mesh in one plane, which shadow maps leave out: whether it lies between a point and a light is computed.
struct SheetRecord {
  vec4 plane_node;
  uint part;
};

// Where it is now.
struct SheetPlace {
  vec3 normal_world;  // unit
  float radius_m;     // around its middle
  vec3 center_world;
  uint part;
  vec3 in_plane_world;  // a point
  uint padding;
};

#define FIRE3DV_SHADOWS_OFF 0u
#define FIRE3DV_SHADOWS_MASK 1u  // found by rays before shading
#define FIRE3DV_SHADOWS_MAP 2u
#define FIRE3DV_SHADOWS_INLINE 3u  // rays traced where the surface is shaded
#define FIRE3DV_SHADOWS_ANY 4u     // of a pipeline: as the globals say

// A pixel's rays that are to be traced, of one word of its mask.
struct RayEntry {
  uint pixel;
  uint word;
  uint wanted;  // bits as in the mask; of a soft light the lowest one of each sample
};

// One ray, to a hard light, of a pixel whose mask has one word.
struct FoundRay {
  vec3 origin_world;
  uint light;
  uint pixel;
  uint lit;  // bits of the mask that are set if the light arrives
};

struct RayList {
  uint width;  // of vkCmdTraceRaysIndirectKHR: entries
  uint height;
  uint depth;
  uint groups_x;  // of vkCmdDispatchIndirect, for 64 entries each
  uint groups_y;
  uint groups_z;
  uint rays;  // counted for the statistics, where they are not the entries
};

// The lists of a frame: RayEntry[] of what needs rays; FoundRay[] of its rays, where shading has found them, without
// groups; and of the first again, at least all of it if there were more rays than room, else none.
#define FIRE3DV_LIST_PIXELS 0u
#define FIRE3DV_LIST_FOUND 1u
#define FIRE3DV_LIST_LEFT 2u
#define FIRE3DV_RAY_LISTS 3

#define FIRE3DV_LIGHT_VIEW_THREADS 256u  // that look at parts together: a power of two

struct LightViewsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS cameras;  // address of the globals of each camera: FIRE3DV_ADDRESS[]
  FIRE3DV_ADDRESS wanted;  // LightViewWanted[]
  FIRE3DV_ADDRESS views;   // RasterView[], written
  FIRE3DV_ADDRESS sheets;  // SheetRecord[]
  uint view_count;
  uint levels_of_detail;  // 1: maps may hold coarser triangles
  uint camera_count;
};

// A light's view before it is fitted to what there is to see.
struct LightViewWanted {
  uint light;
  uint side;  // of a cube; FIRE3DV_NO_INDEX = not of a cube
  uint size;  // texels along each side
  uint first_texel;
  float half_angle_rad;  // spot
};

struct ShadowPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS lists;       // RayList[FIRE3DV_RAY_LISTS]
  FIRE3DV_ADDRESS entries;     // RayEntry[]
  FIRE3DV_ADDRESS found;       // FoundRay[]
  uint found_room;             // how many there can be
  uint hybrid;                 // 0: every ray is traced
};

FIRE3DV_SHARED_END
#endif
