/* Scene edits of the FIRE-3DV client: changes of a stream to the scene apart from poses. C11 and C++.
 *
 *   fire3dv_set_visible(stream, "door", 0);
 *   fire3dv_publish(stream, sim_time_ns, poses, count, 0);   // shown together with the edit, never without
 * it fire3dv_clear(stream, "door", FIRE3DV_PROPERTY_VISIBLE); // back to the value of the scene file
 *
 * State: an edit is keyed state with key (node, property); the newest value of a key replaces older ones.
 * Renderers that join late or read slowly receive the newest values only. A frame is shown with all edits set
 * before it was published. fire3dv_describe keeps edits; the end of the stream undoes them. Nodes: looked up
 * by name or path, like nodes that poses move. A name without a scene node is not an error; renderers report
 * edits without effect, one after the other, in fire3dv_status.welcome_message of fire3dv_poll. Budget: all
 * encoded values together may take fire3dv_options.scene_budget_bytes. An edit beyond it fails with
 *   FIRE3DV_ERROR_BUDGET and changes nothing.
 * Blocking, ownership, thread-safety: as in client.h. Edits may be set before fire3dv_describe.
 * Errors: numbers out of range fail with FIRE3DV_ERROR_ARGUMENT.
 * Units and frames: as in glTF: metres, radians, linear colour.
 */
#ifndef FIRE3DV_SCENE_H
#define FIRE3DV_SCENE_H

#include "fire3dv/client.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  FIRE3DV_PROPERTY_VISIBLE = 0,
  FIRE3DV_PROPERTY_BASE_COLOR = 1,
  FIRE3DV_PROPERTY_LIGHT = 2,
  FIRE3DV_PROPERTY_CAMERA = 3,
  FIRE3DV_PROPERTY_NODE = 4, /* existence of the node: added and removed nodes */
  FIRE3DV_PROPERTY_VERTICES = 5,
  FIRE3DV_PROPERTY_MARKER = 6 /* fire3dv/markers.h; the name is the marker's */
};

enum { FIRE3DV_LIGHT_DIRECTIONAL = 0, FIRE3DV_LIGHT_POINT = 1, FIRE3DV_LIGHT_SPOT = 2 };

/* struct_size must be set. Other fields have no defaults: 0 means 0. */
typedef struct fire3dv_light {
  size_t struct_size;   /* sizeof(fire3dv_light) */
  int32_t kind;         /* FIRE3DV_LIGHT_*; shines along the node's -Z */
  float color_rgb[3];   /* linear, not negative */
  float intensity;      /* candela (point, spot) or lux (directional) */
  float range_m;        /* 0 = infinite */
  float inner_cone_rad; /* spot: 0 <= inner < outer <= pi / 2 */
  float outer_cone_rad;
  int32_t casts_shadow; /* 0 or 1 */
} fire3dv_light;

typedef struct fire3dv_camera {
  size_t struct_size;     /* sizeof(fire3dv_camera) */
  float vertical_fov_rad; /* between 0 and pi, exclusive; looks along the node's -Z */
  float near_m;           /* above 0 */
  float far_m;            /* above near_m; 0 = infinite */
  float exposure;         /* factor on linear colour; 0 = the renderer's setting */
  /* Thin lens for depth of field. Both 0 = as the scene file or the renderer's settings have it. */
  float f_number;         /* 0.1 to 1000 */
  float focus_distance_m; /* 0.001 to 1000000, along the view direction to the plane in focus */
} fire3dv_camera;

typedef struct fire3dv_node {
  size_t struct_size;            /* sizeof(fire3dv_node) */
  const char* parent;            /* name of the parent node; NULL = the scene root */
  const float* parent_from_node; /* 12 floats, row-major, rest pose; NULL = identity */
  const char* asset_uri;         /* glTF file below the renderer's asset folder; or NULL */
  const void* asset_glb; /* contents of a .glb file; or NULL. Not both; with neither the node is empty */
  size_t asset_glb_bytes;
  const char*
      variant; /* material variant of the asset (KHR_materials_variants); NULL = its default materials */
} fire3dv_node;

typedef struct fire3dv_vertices {
  size_t struct_size;     /* sizeof(fire3dv_vertices) */
  const float* positions; /* vertex_count times x y z in the mesh frame: all primitives, in file order */
  const float* normals;   /* vertex_count times x y z, or NULL: computed by the renderer */
  size_t vertex_count;
} fire3dv_vertices;

/* Shows or hides the node and its subtree. Hidden nodes are not drawn and cast no shadows. */
FIRE3DV_API int fire3dv_set_visible(fire3dv_stream* stream, const char* node, int visible);

/* Sets the base colour factor (linear, 0 to 1) of the node's mesh for this node only. */
FIRE3DV_API int fire3dv_set_base_color(fire3dv_stream* stream, const char* node, const float rgba[4]);

/* Adds a light or camera to the node, or replaces the one of the scene file. */
FIRE3DV_API int fire3dv_set_light(fire3dv_stream* stream, const char* node, const fire3dv_light* light);
FIRE3DV_API int fire3dv_set_camera(fire3dv_stream* stream, const char* node, const fire3dv_camera* camera);

/* Adds a node that the scene does not have. The root nodes of the asset become its children. */
FIRE3DV_API int fire3dv_add_node(fire3dv_stream* stream, const char* node, const fire3dv_node* added);

/* Removes the node, of the scene file or added, with its subtree. */
FIRE3DV_API int fire3dv_remove_node(fire3dv_stream* stream, const char* node);

/* Replaces the vertex positions of the node's mesh. Copies the arrays; allocates. */
FIRE3DV_API int fire3dv_set_vertices(fire3dv_stream* stream, const char* node,
                                     const fire3dv_vertices* vertices);

/* Reverts one property to the value of the scene file. property: FIRE3DV_PROPERTY_*. */
FIRE3DV_API int fire3dv_clear(fire3dv_stream* stream, const char* node, int property);

#ifdef __cplusplus
}
#endif
#endif
