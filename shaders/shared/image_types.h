// What shades, draws on top and finishes the image is told.
#ifndef FIRE3DV_SHARED_IMAGE_TYPES_H
#define FIRE3DV_SHARED_IMAGE_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// One step of the preparation of the surroundings.
struct EnvironmentPush {
  uint size;  // of the level that is written, in texels
  uint samples;
  float roughness;  // perceptual
  float lod;        // of what is read
};

struct ForwardPush {
  FIRE3DV_ADDRESS globals;
};

#define FIRE3DV_TONE_MAP_REINHARD 0u
#define FIRE3DV_TONE_MAP_NONE 1u
#define FIRE3DV_TONE_MAP_ACES 2u
#define FIRE3DV_TONE_MAP_NEUTRAL 3u

struct PostPush {
  // uvec2[pixel]: half floats of the light itself, where the whole image is finished; 0 = nobody wants them
  FIRE3DV_ADDRESS linear;
  uint first_x;  // of the pixels that are finished, and where they end
  uint first_y;
  uint end_x;
  uint end_y;
  uint samples;
  float exposure;
  uint tone_map;
};

struct SurfacesPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample], ids read and written
};

struct ShadePush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS lists;       // RayList[FIRE3DV_RAY_LISTS], where shading finds what needs rays or `listed`
  FIRE3DV_ADDRESS entries;     // RayEntry[], one for each pixel
  FIRE3DV_ADDRESS found;       // FoundRay[]
  uint found_room;             // how many there can be
  float exposure;
  uint tone_map;
  uint listed;     // 1: only the pixels of the list are shaded
  uint first_row;  // of the display image, which may hold several
  // Where samples are left for what goes on top, where any are. Others are shown at once by variants for a
  // CPU, and left all the same by the rest.
  uint left_x;
  uint left_y;
  uint left_end_x;
  uint left_end_y;
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

#define FIRE3DV_HELD_LATE 1u
#define FIRE3DV_HELD_LOST 2u

struct HeldMarkPush {
  uint width;
  uint height;
  uint held;  // FIRE3DV_HELD_*
};

FIRE3DV_SHARED_END
#endif
