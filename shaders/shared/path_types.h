// GPU records of the path tracer.
#ifndef FIRE3DV_SHARED_PATH_TYPES_H
#define FIRE3DV_SHARED_PATH_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Lamps that one path vertex samples. Scenes with more sample strata of their list.
#define FIRE3DV_PATH_LAMPS 8u

// Cell of the environment's alias table (Walker 1974; Vose 1991). Cells are texels, or blocks of texels.
struct EnvironmentCell {
  float threshold;  // random numbers below it select this cell, others the alias
  uint alias;
  float density;  // per unit of u and v
};

// Path of a pixel between two dispatches.
struct PathState {
  vec3 origin_world;
  float pdf;  // of the last direction, per unit of solid angle
  vec3 direction_world;
  uint vertex;  // number of path vertices; FIRE3DV_NO_INDEX: the path has ended
  vec3 throughput;
  uint is_camera_ray;
  vec3 radiance;
  uint channel;   // 1 to 3: the only colour of a path through dispersive media; 0: all colours
  uint media[4];  // materials of the volumes that the path is inside of, the last one first;
                  // FIRE3DV_NO_INDEX: none
};

// Sums over the samples of a pixel. Display-referred colours are shown without exposure and tone mapping.
struct PathSum {
  vec3 radiance;
  float radiance_samples;  // share of scene-referred samples times their number
  vec3 display;
  float samples;  // so far: a pixel of an unfinished image may be one ahead of others
};

struct PathParameters {
  FIRE3DV_ADDRESS sums;    // PathSum[pixel]
  FIRE3DV_ADDRESS states;  // PathState[pixel of the band]
  FIRE3DV_ADDRESS cells;   // EnvironmentCell[]; 0: no light from the environment
  uint cells_x;
  uint cells_y;
  // Ray of a pixel: origin = eye + x * ndc.x + y * ndc.y; direction as in Globals.
  vec3 origin_x;
  vec3 origin_y;
  // Radii of the lens along x and y of the image. Rays through the lens meet at the focus distance, along
  // look_world; 0: a pinhole.
  vec3 lens_x_m;
  vec3 lens_y_m;
  float focus_distance_m;
  vec3 look_world;
  float near_m;
  float far_m;   // 0: infinite
  uint bounces;  // after the first surface
  uint seed;
};

struct PathPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS parameters;  // PathParameters
  uint first_pixel;
  uint pixel_count;
  uint sample_index;
  uint begins;    // 1: the dispatch begins the sample's paths
  uint segments;  // of each path in this dispatch
};

struct PathResolvePush {
  FIRE3DV_ADDRESS sums;
  FIRE3DV_ADDRESS linear;   // uvec2[pixel]: linear radiance as half floats; 0: not requested
  FIRE3DV_ADDRESS metered;  // float: exposure; 0: `exposure`
  uint width;
  uint height;
  float exposure;
  uint tone_map;
  float bloom;  // share of blurred light
};

FIRE3DV_SHARED_END
#endif
