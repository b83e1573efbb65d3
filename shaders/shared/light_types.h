// GPU records of lights, shadow maps and shadow rays.
#ifndef FIRE3DV_SHARED_LIGHT_TYPES_H
#define FIRE3DV_SHARED_LIGHT_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

#define FIRE3DV_LIGHT_DIRECTIONAL 0u
#define FIRE3DV_LIGHT_POINT 1u
#define FIRE3DV_LIGHT_SPOT 2u
#define FIRE3DV_LIGHT_LAMP 3u  // point light with exp(-cone_scale * (1 - cos(angle)))

struct LightRecord {
  vec3 color;     // linear colour times intensity: candela, or lux for a directional light
  float range_m;  // 0: infinite
  uint type;
  uint node;         // the light's node; it shines along the node's -Z
  float cone_scale;  // KHR_lights_punctual: attenuation = clamp(cos(angle) * scale + offset, 0, 1)^2
  float cone_offset;
  float radius_m;            // point, spot; 0: hard shadows
  float angular_radius_rad;  // directional
  uint padding0, padding1;
};

// World-space state of a light in this frame, written by deform/transforms.comp.
struct LightPose {
  vec3 color;
  float range_m;
  vec3 position_world;
  uint type;
  vec3 light_direction_world;  // unit, world
  float cone_scale;
  float cone_offset;
  float radius_m;
  float angular_radius_rad;
  float sine;  // of angular_radius_rad
};

// Shadow parameters of a light.
struct LightShadow {
  uint first_view;  // index of the light's RasterViews: 1, or 6 cube faces
  uint view_count;
  uint mask_word;  // position of this light's result in the mask
  uint mask_shift;
  uint rays;  // 0: no shadow; 1: hard, one bit per sample; more: soft, 8 bits per sample
  uint padding0, padding1, padding2;
};

// A planar caster: a mesh in one plane. Shadow maps omit it; shading computes its occlusion analytically.
struct PlanarCasterRecord {
  vec4 plane_node;
  uint part;
};

// World-space state of a planar caster in this frame.
struct PlanarCasterPlane {
  vec3 normal_world;  // unit
  float radius_m;     // around center_world
  vec3 center_world;
  uint part;
  vec3 in_plane_world;  // a point of the plane
  uint padding;
};

#define FIRE3DV_SHADOWS_OFF 0u
#define FIRE3DV_SHADOWS_MASK 1u  // traced before shading
#define FIRE3DV_SHADOWS_MAP 2u
#define FIRE3DV_SHADOWS_INLINE 3u  // traced in the shading pass
#define FIRE3DV_SHADOWS_ANY 4u     // specialisation constant: the globals decide

// Shadow rays of one pixel for one word of its mask.
struct RayEntry {
  uint pixel;
  uint word;
  uint wanted;  // bits as in the mask; for a soft light, the lowest bit of each sample
};

// One ray to a hard light, for a pixel with a mask of one word.
struct ListedRay {
  vec3 origin_world;
  uint light;
  uint pixel;
  uint lit;  // bits of the mask to set if the light is visible
};

struct RayList {
  uint width;  // of vkCmdTraceRaysIndirectKHR: entries
  uint height;
  uint depth;
  uint groups_x;  // of vkCmdDispatchIndirect, 64 entries a group
  uint groups_y;
  uint groups_z;
  uint rays;  // ray count for statistics, where it differs from the entries
};

// Lists of a frame. PIXELS: RayEntry[] of pixels that need rays. RAYS: ListedRay[] of the rays that shading
// has listed; without groups. OVERFLOW: covers all of PIXELS if the rays overflowed RAYS, otherwise empty.
#define FIRE3DV_LIST_PIXELS 0u
#define FIRE3DV_LIST_RAYS 1u
#define FIRE3DV_LIST_OVERFLOW 2u
#define FIRE3DV_RAY_LISTS 3

#define FIRE3DV_LIGHT_VIEW_THREADS 256u  // threads of the reduction over primitive instances: a power of two

struct LightViewsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS cameras;         // FIRE3DV_ADDRESS[]: globals of each camera
  FIRE3DV_ADDRESS wanted;          // LightViewRequest[]
  FIRE3DV_ADDRESS views;           // RasterView[], written
  FIRE3DV_ADDRESS planar_casters;  // PlanarCasterRecord[]
  uint view_count;
  uint levels_of_detail;  // 1: maps may hold coarser LODs
  uint camera_count;
  uint first_texel;  // of the world's maps
};

// A light's view before it is fitted to the visible casters.
struct LightViewRequest {
  uint light;
  uint side;  // cube face; FIRE3DV_NO_INDEX: not a cube
  uint size;  // texels along each side
  uint first_texel;
  float half_angle_rad;  // spot
};

struct ShadowPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;   // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS lists;        // RayList[FIRE3DV_RAY_LISTS]
  FIRE3DV_ADDRESS entries;      // RayEntry[]
  FIRE3DV_ADDRESS listed_rays;  // ListedRay[]
  uint ray_list_capacity;       // entries of listed_rays
  uint hybrid;                  // 0: every ray is traced
};

FIRE3DV_SHARED_END
#endif
