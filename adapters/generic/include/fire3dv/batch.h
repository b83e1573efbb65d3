/* Batches of worlds: many small images of many copies of the scene, by one request and one answer. C11 and
 * C++.
 *
 *   fire3dv_batch_request request = {sizeof request};
 *   request.worlds = 1024; request.poses = poses; request.pose_worlds = 1024;   // [1024][nodes][12]
 *   request.width = request.height = 64;
 *   request.fx = request.fy = 60; request.cx = request.cy = 31.5f;
 *   request.outputs = FIRE3DV_IMAGE_COLOR_SRGB8 | FIRE3DV_IMAGE_DEPTH_F32;
 *   uint64_t id;
 *   fire3dv_image *images = NULL;
 *   if (fire3dv_request_batch(stream, &request, &id) == FIRE3DV_OK &&
 *       fire3dv_wait_image(stream, id, 60000, &images) == FIRE3DV_OK) {
 *     const fire3dv_image_plane *color = fire3dv_plane_of(images, FIRE3DV_IMAGE_COLOR_SRGB8);
 *     use(color->data);                                           // [views][height][width][4], contiguous
 *     fire3dv_release_image(&images);
 *   }
 *
 * Worlds: a world is the renderer's scene with its edits, in which the request's poses move the named nodes
 * of the stream, and all other nodes rest as in the file, whatever streams publish. Edits take part that the
 * renderer shows when it draws; a batch does not wait for assets that are still loaded. Worlds differ in
 * their poses alone. Each request has the poses of all worlds, so that requests are independent of each
 * other and of fire3dv_publish; answers carry the request's id. Several requests may be open; they are drawn
 * in order, and may have other worlds, views and sizes.
 * Images: view v of the answer shows world world_of_view[v]. Its pixels are those that a batch of this world
 * alone has, byte for byte, unless shadow maps of very many worlds exceed a quarter of the device memory:
 * then they are smaller or missing in all worlds. A plane has views * height rows: the images of all views
 * in order, without padding. Views of inactive worlds have zeros in all outputs. Frames and units: as in
 * client.h and image.h.
 * Poses are stream_from_body, metres; cameras look along -Z, +Y up; pixel (0, 0) is the centre of the top
 * left one.
 * Not in batches: lenses, depth of field, markers, boxes, motion, occlusion, linear colours and the effects
 * of the renderer's settings that need single images (FXAA, ...). Scenes with blended surfaces, lines or
 * points are refused.
 * Limits: 65535 worlds, 65536 views, 256 MiB for poses and for images. A renderer refuses worlds beyond its
 * memory or the peer's limits: of gpu-bytes, and of pose-bytes for the memory of worlds, with the number
 * that fits; of request-bytes, and of pose-bytes for the request itself, with the limit. A batch is drawn as
 * a whole, while others wait: request very many views in parts.
 * Links: shm://, tcp:// and tls://, as images. Renderers before protocol 1.10 refuse batches. Thread-safety
 * and blocking: as in image.h.
 */
#ifndef FIRE3DV_BATCH_H
#define FIRE3DV_BATCH_H

#include "fire3dv/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Zero-initialised fields select the default. struct_size, worlds, poses, pose_worlds, width and height must
 * be set. Arrays are copied. A leading dimension of 1 is shared by all worlds or views. */
typedef struct fire3dv_batch_request {
  size_t struct_size; /* sizeof(fire3dv_batch_request) */
  uint32_t worlds;
  const uint32_t*
      node_indices;     /* node_count distinct indices into the description's node_names; NULL = all */
  uint32_t node_count;  /* 0 with NULL */
  uint32_t pose_worlds; /* leading dimension of poses: 1 or worlds */
  const float* poses;   /* [pose_worlds][node_count][12]: stream_from_body, 3x4, row-major */
  const uint32_t* world_of_view; /* [views], each below worlds; NULL with views 0 = view v shows world v */
  uint32_t views;
  uint32_t pose_views; /* leading dimension of parent_from_camera: 1 or views; 0 with NULL */
  const float*
      parent_from_camera;   /* [pose_views][12]: camera pose in the node or the stream; NULL = identity */
  const char* node;         /* node that carries the cameras, in each world; NULL = the stream frame */
  uint32_t width, height;   /* pixels of a view, 1 to 8192 */
  float fx, fy, cx, cy;     /* pixels, of all views; fx = fy = 0: projection of the node's own camera */
  const float* projections; /* [views][4]: fx, fy, cx, cy of each view, instead of those above; or NULL */
  float near_m, far_m;      /* metres, used with fx; near_m 0 = 0.01, far_m 0 = infinite */
  const uint8_t* active;    /* [worlds], 1 = drawn, 0 = not drawn; NULL = all are drawn */
  uint32_t outputs;         /* FIRE3DV_IMAGE_* bits; 0 = FIRE3DV_IMAGE_COLOR_SRGB8 */
} fire3dv_batch_request;

/* Requests one batch and sets *id to the request's id. Call fire3dv_describe first. fire3dv_wait_image
 * returns the answer, fire3dv_cancel_image takes the request back. Does not block. Errors:
 * FIRE3DV_ERROR_ARGUMENT for invalid numbers, FIRE3DV_ERROR_SYSTEM where the link has no room. */
FIRE3DV_API int fire3dv_request_batch(fire3dv_stream* stream, const fire3dv_batch_request* request,
                                      uint64_t* id);

#ifdef __cplusplus
}
#endif
#endif
