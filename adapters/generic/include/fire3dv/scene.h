/* FIRE-3DV client, scene edits: what a stream changes about the scene besides poses. C11 and C++.
 *
 *   fire3dv_set_visible(stream, "door", 0);
 *   fire3dv_publish(stream, sim_time_ns, poses, count, 0);   // shown together with the edit, never without it
 *   fire3dv_clear(stream, "door", FIRE3DV_PROPERTY_VISIBLE); // as the scene's file says
 *
 * An edit is state: the newest value of each (node, property) counts. Renderers that join later, and those that were
 * slow, get the newest values; what was set before is gone. A frame is shown with all edits that were set before it was
 * published. Edits are kept over fire3dv_describe, and undone in renderers when the stream ends.
 * Nodes are found by name or path, as those that poses move; a name that no scene node has is no error here.
 * Budget: all values together, encoded, may take fire3dv_options.scene_budget_bytes. An edit over it is refused with
 * FIRE3DV_ERROR_BUDGET and changes nothing.
 * Waiting, ownership, threads: as in client.h. Edits may be set before fire3dv_describe. Numbers that no renderer would
 * take are refused with FIRE3DV_ERROR_ARGUMENT. Units and frames are glTF's: metres, radians, linear colour.
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
  FIRE3DV_PROPERTY_NODE = 4, /* that the node is there: added and removed nodes */
  FIRE3DV_PROPERTY_VERTICES = 5
};

enum { FIRE3DV_LIGHT_DIRECTIONAL = 0, FIRE3DV_LIGHT_POINT = 1, FIRE3DV_LIGHT_SPOT = 2 };

/* struct_size must be set; all other fields mean what they say, 0 included. */
typedef struct fire3dv_light {
  size_t struct_size;   /* sizeof(fire3dv_light) */
  int32_t kind;         /* FIRE3DV_LIGHT_*; it shines along the node's -Z */
  float color_rgb[3];   /* linear, not negative */
  float intensity;      /* candela (point, spot) or lux (directional) */
  float range_m;        /* 0 = infinite */
  float inner_cone_rad; /* spot: 0 <= inner < outer <= pi / 2 */
  float outer_cone_rad;
  int32_t casts_shadow; /* 0 or 1 */
} fire3dv_light;

typedef struct fire3dv_camera {
  size_t struct_size;     /* sizeof(fire3dv_camera) */
  float vertical_fov_rad; /* above 0, below pi; it looks along the node's -Z */
  float near_m;           /* above 0 */
  float far_m;            /* above near_m; 0 = infinite */
  float exposure;         /* factor on linear colour; 0 = as the renderer was told */
} fire3dv_camera;

typedef struct fire3dv_node {
  size_t struct_size;            /* sizeof(fire3dv_node) */
  const char *parent;            /* name of another node; NULL = the scene's root */
  const float *parent_from_node; /* 12 floats, row-major, at rest; NULL = identity */
  const char *asset_uri;         /* glTF file below the folder that the renderer's user named for assets; or NULL */
  const void *asset_glb;         /* a whole .glb file; or NULL. Not both; with neither the node is empty */
  size_t asset_glb_bytes;
} fire3dv_node;

typedef struct fire3dv_vertices {
  size_t struct_size;     /* sizeof(fire3dv_vertices) */
  const float *positions; /* vertex_count times x y z, in the frame of the node's mesh: all its primitives, as in the file */
  const float *normals;   /* as many, or NULL: the renderer finds them */
  size_t vertex_count;
} fire3dv_vertices;

/* The node and all below it: neither drawn nor casting shadows when visible is 0. */
FIRE3DV_API int fire3dv_set_visible(fire3dv_stream *stream, const char *node, int visible);

/* Base colour factor of the node's own mesh, linear, 0 to 1, for this node alone. */
FIRE3DV_API int fire3dv_set_base_color(fire3dv_stream *stream, const char *node, const float rgba[4]);

/* The light, or the camera, on the node: new, or instead of the file's. */
FIRE3DV_API int fire3dv_set_light(fire3dv_stream *stream, const char *node, const fire3dv_light *light);
FIRE3DV_API int fire3dv_set_camera(fire3dv_stream *stream, const char *node, const fire3dv_camera *camera);

/* A node that the scene does not have; the asset's roots become its children. */
FIRE3DV_API int fire3dv_add_node(fire3dv_stream *stream, const char *node, const fire3dv_node *added);

/* The node, added or the file's, and all below it are not there. */
FIRE3DV_API int fire3dv_remove_node(fire3dv_stream *stream, const char *node);

/* New places of the vertices of the node's own mesh. Copies them; allocates. */
FIRE3DV_API int fire3dv_set_vertices(fire3dv_stream *stream, const char *node, const fire3dv_vertices *vertices);

/* Takes the edit of one property back: as the scene's file says. property: FIRE3DV_PROPERTY_*. */
FIRE3DV_API int fire3dv_clear(fire3dv_stream *stream, const char *node, int property);

#ifdef __cplusplus
}
#endif
#endif
