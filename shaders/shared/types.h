// Structures that C++ writes and GLSL reads: one text for both compilers. See basics.h for the rules.
#ifndef FIRE3DV_SHARED_TYPES_H
#define FIRE3DV_SHARED_TYPES_H
#include "basics.h"
#include "deform_types.h"
#include "geometry_types.h"
#include "image_types.h"
#include "inspect_types.h"
#include "light_types.h"
#include "material_types.h"
#include "output_types.h"
#include "pose_types.h"
#include "raster_types.h"

FIRE3DV_SHARED_BEGIN

// What every shader of a frame may need; one per frame.
struct Globals {
  FIRE3DV_ADDRESS world_from_node;          // AffineRows[]
  FIRE3DV_ADDRESS node_facts;               // uint[]: FIRE3DV_NODE_*
  FIRE3DV_ADDRESS first_primitive_of_node;  // uint[]
  FIRE3DV_ADDRESS draws;                    // DrawRecord[]
  FIRE3DV_ADDRESS primitives;               // PrimitiveRecord[]
  FIRE3DV_ADDRESS materials;                // MaterialRecord[]
  FIRE3DV_ADDRESS material_extensions;      // MaterialExtensionRecord[]
  FIRE3DV_ADDRESS lights;                   // LightRecord[]
  FIRE3DV_ADDRESS light_places;             // LightPlace[]
  FIRE3DV_ADDRESS positions;                // vec3[], node space
  FIRE3DV_ADDRESS frames;                   // FrameRecord[]
  FIRE3DV_ADDRESS tangents;                 // uint[], scene::TangentXy; 0: no vertex has one
  FIRE3DV_ADDRESS uvs;                      // vec2[], the first set
  FIRE3DV_ADDRESS extras;                   // ExtrasRecord[]; 0: no vertex has any
  FIRE3DV_ADDRESS indices;                  // uint[]
  FIRE3DV_ADDRESS parts;                    // PartRecord[]
  FIRE3DV_ADDRESS clusters;                 // ClusterRecord[]
  FIRE3DV_ADDRESS level_groups;             // LevelGroupRecord[]
  FIRE3DV_ADDRESS cluster_triangles;        // uint[], scene::ClusteredGeometry::triangles
  FIRE3DV_ADDRESS cluster_instances;        // ClusterInstance[]
  FIRE3DV_ADDRESS ray_boxes;                // RayBoxRecord[], where rays are traced to boxes
  FIRE3DV_ADDRESS light_shadows;            // LightShadow[], as lights
  FIRE3DV_ADDRESS light_views;              // RasterView[]
  FIRE3DV_ADDRESS shadow_maps;  // uint[], kept_depth(): of each view, at texels' middles, then outer ones
  FIRE3DV_ADDRESS shadow_mask;  // uint[pixel][mask_words]
  FIRE3DV_ADDRESS sheets;       // SheetPlace[]
  FIRE3DV_ADDRESS far_sides;    // uint[part]: 1 = see casts_by_far_sides()
  mat4 clip_from_world;
  vec3 eye_world;
  vec4 near_window;  // passes::NearWindow: middle and radius
  vec4 near_plane;
  uint light_count;
  float environment_intensity;  // factor on what the environment's images hold
  vec2 environment_turn;        // cosine and sine of its rotation about +Y
  vec3 background;              // where nothing is, unless the surroundings show; linear
  float
      background_lod;  // of the environment's picture, so that its texels are a pixel large; < 0: background
  vec3 world_from_ndc_x;  // the direction of the ray through a pixel is x * ndc.x + y * ndc.y + origin
  vec3 world_from_ndc_y;
  vec3 world_from_ndc_origin;
  vec2 half_pixel_depth;  // how far half a pixel's width is in depth, at depth z: x * z + y
  uint shadows;           // FIRE3DV_SHADOWS_*
  uint width;             // of the image
  uint height;
  uint visibility_generation;  // of the depths in it: a multiple of FIRE3DV_GENERATION
  uint map_generation;         // the same, of shadow_maps
  uint mask_words;
  uint sheet_count;
  uint part_count;
  uint primitive_count;
  uint ray_box_count;
};

#ifdef __cplusplus
static_assert(sizeof(PostPush) <= 128 && sizeof(TransformsPush) <= 128 && sizeof(DeformPush) <= 128);
#endif

FIRE3DV_SHARED_END
#endif
