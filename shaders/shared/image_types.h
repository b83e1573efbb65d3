// Parameters of shading, forward draws and post-processing.
#ifndef FIRE3DV_SHARED_IMAGE_TYPES_H
#define FIRE3DV_SHARED_IMAGE_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// One step of environment preprocessing.
struct EnvironmentPush {
  uint size;  // of the written level, in texels
  uint samples;
  float roughness;  // perceptual
  float lod;        // of the source image
};

struct ForwardPush {
  FIRE3DV_ADDRESS globals;
};

#define FIRE3DV_TONE_MAP_REINHARD 0u
#define FIRE3DV_TONE_MAP_NONE 1u
#define FIRE3DV_TONE_MAP_ACES 2u
#define FIRE3DV_TONE_MAP_NEUTRAL 3u

// Bins of the light meter, over the range of half floats.
#define FIRE3DV_METER_BINS 2560u
#define FIRE3DV_METER_BINS_A_STOP 64
#define FIRE3DV_METER_DARKEST_STOP -24  // log2 of the luminance

struct LightMeterPush {
  FIRE3DV_ADDRESS sums;       // PathSum[pixel]; 0: the HDR target
  FIRE3DV_ADDRESS histogram;  // uint[FIRE3DV_METER_BINS], zero before
  uint width;
  uint height;
  uint samples;
};

struct LightMeterResolvePush {
  FIRE3DV_ADDRESS histogram;
  FIRE3DV_ADDRESS exposure;  // float, written
  float fallback;            // exposure of an image without scene-referred light
};

struct PostPush {
  // uvec2[pixel]: linear radiance as half floats, for whole-image passes; 0: not requested
  FIRE3DV_ADDRESS linear;
  FIRE3DV_ADDRESS metered;  // float: exposure; 0: `exposure`
  uint first_x;             // range of tone-mapped pixels; end_x and end_y are exclusive
  uint first_y;
  uint end_x;
  uint end_y;
  uint width;  // of the image; with `linear` all of its pixels are processed
  uint height;
  uint samples;
  float exposure;
  uint tone_map;
  float bloom;  // share of blurred light
};

struct BloomLightPush {
  FIRE3DV_ADDRESS sums;     // PathSum[pixel]; 0: the HDR target
  FIRE3DV_ADDRESS metered;  // float: exposure; 0: `exposure`
  uint width;
  uint height;
  uint samples;
  float exposure;
};

struct BloomUpPush {
  float share_of_level_below;
};

// Optics and sensor of a camera, of one image. Lengths in pixels of it.
struct SensorRecord {
  FIRE3DV_ADDRESS sums;     // PathSum[pixel]; 0: the HDR target
  FIRE3DV_ADDRESS metered;  // float: exposure; 0: `exposure`
  // uvec2[pixel]: four half floats: exposed light, and the cosine of the pixel's angle off the axis.
  FIRE3DV_ADDRESS light;
  FIRE3DV_ADDRESS fogged;  // the same behind the window with condensation; 0: none
  FIRE3DV_ADDRESS grid;    // vec4[3][cell]: means of blocks, blurred along rows, blurred
  FIRE3DV_ADDRESS means;   // vec4[2]: mean light, and its ratio to that of the blurred blocks
  uint width;
  uint height;
  uint samples;
  float exposure;
  float bloom;  // share of blurred light
  // Direction of a pixel's ray as in Globals; in all pixels the axis where there are no rays from one point.
  vec3 ray_x;
  vec3 ray_y;
  vec3 ray_origin;
  vec3 axis;  // unit
  float focal_px;
  // OpticsSettings.
  float vignette;
  float mask_radius;
  float mask_cut;
  float aberration;
  float inverse_response;  // 0: tone_map and sRGB
  uint tone_map;
  float fog;
  float fog_veil;
  float drops;
  float drop_px;  // diameter of a drop at most
  uint block;     // pixels along each side of a block
  uint grid_width;
  uint grid_height;
  float blur_cells;  // standard deviation of the fog's blur
  float full_well;
  float read_noise;
  float dark_signal;
  float prnu;  // share
  float dsnu;
  uint seed;
  uint frame_low;  // hash of moment and view
  uint frame_high;
};

struct SensorPush {
  FIRE3DV_ADDRESS record;  // SensorRecord
  uint along_rows;         // of the blur
};

// Planes of a camera with a content mask: pixels beyond it are empty.
struct MaskPlanesPush {
  FIRE3DV_ADDRESS plane;
  uint width;
  uint height;
  uint words;  // of a pixel
  uint first;  // value of the first and of the other words outside
  uint others;
  uint last;
  float mask_radius;
  float mask_cut;
};

#define FIRE3DV_BLUR_TILE 8         // pixels along each side of a tile
#define FIRE3DV_MAX_BLUR_RADIUS 48  // pixels; larger circles of confusion are drawn with it

// Two layers of a pixel for depth of field: surfaces up to the plane in focus, and those behind.
struct BlurTexel {
  uint near_light[2];   // halves: linear light times the share of the pixel's samples, and the share
  uint far_light[2];    // the same
  uint radii;           // halves: radii of the circles of confusion, in pixels
  uint scene_referred;  // halves: share of scene-referred light, times that of the samples
};

struct BlurTile {
  uint near_radius;  // largest of the tile, as the bits of a float
  uint far_radius;
};

struct DepthOfFieldPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS texels;      // BlurTexel[pixel]
  FIRE3DV_ADDRESS tiles;       // BlurTile[tile]
  uint width;
  uint height;
  uint samples;
  uint generation;  // of the visibility buffer
  // Signed radius of the circle of confusion along its longer axis in pixels, linear in the reversed depth;
  // negative before the plane in focus.
  float radius_at_zero;
  float radius_per_depth;
  float radius_of_background;
  vec2 stretch;  // of distances in pixels to those along the longer axis, at least 1: pixels need not be
                 // square
};

struct CoverageMergePush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample], ids read and written
};

struct ShadePush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;   // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS lists;        // RayList[FIRE3DV_RAY_LISTS], written by shading or read if `listed`
  FIRE3DV_ADDRESS entries;      // RayEntry[], one per pixel
  FIRE3DV_ADDRESS listed_rays;  // ListedRay[]
  FIRE3DV_ADDRESS ray_effects;  // RayEffectRecord[pixel][sample]; for shaders with ray effects
  uint ray_list_capacity;       // entries of listed_rays
  float exposure;
  uint tone_map;
  uint listed;     // 1: only the listed pixels are shaded
  uint first_row;  // in the display image, which may stack several images
  // Variants with samples: pixels that the tone-map pass resolves from their samples. Shading tone-maps the
  // others at once. Variants for a GPU: all pixels or none.
  uint hdr_x;
  uint hdr_y;
  uint hdr_end_x;
  uint hdr_end_y;
  uint keeps_samples;  // 1: samples of all pixels are written, for the linear plane
};

struct VisibleDepthPush {
  FIRE3DV_ADDRESS visibility;
  uint generation;  // of the visibility buffer
  uint width;
};

struct FxaaPush {
  uint width;
  uint height;
};

#define FIRE3DV_STALE_LATE 1u
#define FIRE3DV_STALE_LOST 2u

struct StaleOverlayPush {
  uint width;
  uint height;
  uint condition;  // FIRE3DV_STALE_*
};

FIRE3DV_SHARED_END
#endif
