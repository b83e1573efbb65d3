// All structures that C++ writes and GLSL reads. See basics.h for the layout rules.
#ifndef FIRE3DV_SHARED_TYPES_H
#define FIRE3DV_SHARED_TYPES_H
#include "basics.h"
#include "deform_types.h"
#include "geometry_types.h"
#include "image_types.h"
#include "inspect_types.h"
#include "layer_types.h"
#include "light_types.h"
#include "marker_types.h"
#include "material_types.h"
#include "output_types.h"
#include "path_types.h"
#include "pose_types.h"
#include "raster_types.h"
#include "ray_effect_types.h"

FIRE3DV_SHARED_BEGIN

// Globals of a frame, read by every shader.
struct Globals {
  FIRE3DV_ADDRESS world_from_node;          // AffineRows[]
  FIRE3DV_ADDRESS node_facts;               // uint[]: FIRE3DV_NODE_*
  FIRE3DV_ADDRESS first_primitive_of_node;  // uint[]
  FIRE3DV_ADDRESS draws;                    // DrawRecord[]
  FIRE3DV_ADDRESS primitives;               // PrimitiveRecord[]
  FIRE3DV_ADDRESS materials;                // MaterialRecord[]
  FIRE3DV_ADDRESS material_extensions;      // MaterialExtensionRecord[]
  FIRE3DV_ADDRESS lights;                   // LightRecord[]
  FIRE3DV_ADDRESS light_poses;              // LightPose[]
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
  FIRE3DV_ADDRESS light_shadows;            // LightShadow[], in the order of lights
  FIRE3DV_ADDRESS light_views;              // RasterView[]
  FIRE3DV_ADDRESS shadow_maps;       // uint[], encode_depth(): per view, the centre map, then the outer map
  FIRE3DV_ADDRESS shadow_mask;       // uint[pixel][mask_words]
  FIRE3DV_ADDRESS top_level;         // acceleration structure of the world; 0: rays cannot be traced
  FIRE3DV_ADDRESS planar_casters;    // PlanarCasterPlane[]
  FIRE3DV_ADDRESS backface_casters;  // uint[part]: 1 = see casts_by_back_faces()
  mat4 clip_from_world;
  vec3 eye_world;
  vec4 near_window;  // passes::NearWindow: centre and radius
  vec4 near_plane;
  uint light_count;
  uint environment_sun;  // index of a light beyond these that is part of the environment; FIRE3DV_NO_INDEX:
                         // none
  float environment_intensity;  // factor on the environment's radiance
  vec2 environment_turn;        // cosine and sine of its rotation about +Y
  vec3 background;              // linear colour without a visible environment, towards the ground
  vec3 background_zenith;       // the same, overhead
  float background_lod;   // LOD of the environment image with texels of one pixel; < 0: background colour
  vec3 world_from_ndc_x;  // ray direction of a pixel: x * ndc.x + y * ndc.y + origin
  vec3 world_from_ndc_y;
  vec3 world_from_ndc_origin;
  vec2 half_pixel_depth;  // depth change of half a pixel's width, at depth z: x * z + y
  uint shadows;           // FIRE3DV_SHADOWS_*
  uint width;             // of the image
  uint height;
  uint visibility_generation;  // of the buffer's depths: a multiple of FIRE3DV_GENERATION
  uint map_generation;         // the same for shadow_maps
  uint mask_words;
  uint planar_caster_count;
  uint part_count;
  uint primitive_count;
  uint ray_box_count;
  float ground_height_m;  // world y of the shadow catcher
  float ground_radius_m;  // 0: none
  vec2 ground_center;     // world x and z
  uint sky_texture;       // replaces the background colours; FIRE3DV_NO_INDEX: none
  float sky_lod;          // LOD of its image with texels of one pixel
};

#ifdef __cplusplus
static_assert(sizeof(PostPush) <= 128 && sizeof(TransformsPush) <= 128 && sizeof(DeformPush) <= 128 &&
              sizeof(MarkerPush) <= 128);
#endif

FIRE3DV_SHARED_END
#endif
