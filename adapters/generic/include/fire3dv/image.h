/* Image requests of the FIRE-3DV client: rendered camera images of a stream's frames. C11 and C++.
 *
 *   fire3dv_image_request request = {sizeof request};
 *   request.node = "wrist_camera";              // its own projection, since fx is 0
 *   request.width = 640; request.height = 480;
 *   request.when = FIRE3DV_IMAGE_EVERY_NTH;
 *   uint64_t id;
 *   fire3dv_request_image(stream, &request, &id);
 *   loop {
 *     fire3dv_publish(stream, sim_time_ns, poses, count, 0);
 *     fire3dv_image *image = NULL;
 *     if (fire3dv_wait_image(stream, id, 1000, &image) == FIRE3DV_OK) {   // timeout 0: poll
 *       const fire3dv_image_plane *color = fire3dv_plane_of(image, FIRE3DV_IMAGE_COLOR_SRGB8);
 *       for (uint32_t y = 0; color && y < color->height; ++y)
 *         use_row((const uint8_t *)color->data + (size_t)y * color->row_stride, 4 * color->width);
 *       fire3dv_release_image(&image);
 *     }
 *   }
 *
 * Frames: each image carries the pose frame that it shows (sequence, sim_time_ns). Lockstep: wait for the
 * image of a frame before publishing the next one. Otherwise the newest image of a request replaces an older
 * one that was not taken; fire3dv_image.lost counts these. Renderers are not trusted: an image has the width,
 * height, outputs and lens of its request and shows a frame that was published, and its 2D boxes are inside
 * it; others are dropped and counted (fire3dv_status.images_dropped). Cameras: look along -Z, +Y up, as in
 * glTF. Pixel coordinates follow OpenCV: the centre of the top left pixel is (0, 0). Metres, radians, linear
 * colour. Full definition: protocol/SPEC.md, section 13. Links: shm:// (planes point into shared memory, into
 * which the renderer copies the pixels once from its read-back buffer), tcp:// and tls://. Limits: over
 * shm:// each request reserves slots for two images, 8 at least. A caller that borrows more than half of them
 * gets copies in its own memory instead. Beyond 1 GiB or 4096 images, the client drops the oldest images that
 * were not taken; until then they are copies in the client's memory. Shared memory that larger requests have
 * replaced, and its two descriptors, go back after 2 s and a call that polls or waits, but for borrowed
 * images. A renderer has limits, too (fire3dv: 64 MiB an image, 1 GiB for all open requests of a stream).
 * Blocking: only fire3dv_wait_image blocks. The first request, and larger ones, may allocate memory and, over
 * shm://, take the time to reserve it. Later requests cost about as much as a publish. Thread-safety: as in
 * client.h, except that any thread may release an image, even after its stream is closed.
 */
#ifndef FIRE3DV_IMAGE_H
#define FIRE3DV_IMAGE_H

#include "fire3dv/client.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  FIRE3DV_ERROR_REFUSED = -6
}; /* the renderer does not render this image; the message is the renderer's */

/* Outputs, a bit mask. A renderer refuses unsupported outputs. */
enum {
  FIRE3DV_IMAGE_COLOR_SRGB8 = 1,      /* 4 uint8: sRGB red, green, blue after tone mapping; 255 */
  FIRE3DV_IMAGE_COLOR_LINEAR_F16 = 2, /* 4 half floats: linear RGB before tone mapping; 1 */
  FIRE3DV_IMAGE_DEPTH_F32 =
      4, /* float: metres along the camera axis (planar depth); infinity for background */
  FIRE3DV_IMAGE_INSTANCE_U32 = 8,  /* uint32: 1 + index of the scene node; 0 for background */
  FIRE3DV_IMAGE_SEMANTIC_U32 = 16, /* uint32: semantic class of that node; 0 = none */
  FIRE3DV_IMAGE_NORMAL = 32,       /* 4 half floats: world-space unit normal x, y, z; 0 */
  FIRE3DV_IMAGE_MOTION = 64, /* 2 floats: motion vector in pixels since the previous image of this request */
  FIRE3DV_IMAGE_BOXES2D = 128, /* 32-byte records; SPEC.md section 13 */
  FIRE3DV_IMAGE_BOXES3D = 256, /* 64-byte records; SPEC.md section 13 */
  /* Material of the surface; all 0 for background. Renderers of earlier versions refuse these and the rest.
   */
  FIRE3DV_IMAGE_ALBEDO_F16 = 512,     /* 4 half floats: linear base colour; 1 */
  FIRE3DV_IMAGE_ROUGHNESS_F32 = 1024, /* float: perceptual roughness, 0 to 1 */
  FIRE3DV_IMAGE_METALLIC_F32 = 2048,  /* float: 0 to 1 */
  FIRE3DV_IMAGE_POSITION_F32 = 4096,  /* 4 floats: x, y, z in the world in metres; 1; all 0 for background */
  FIRE3DV_IMAGE_OCCLUSION_U32 = 8192  /* uint32: how this request's previous image showed the point: 0 seen, 1
                                         hidden, 2 outside */
};

enum {
  FIRE3DV_IMAGE_ONCE = 1,      /* one image of the newest published frame, or of a later one */
  FIRE3DV_IMAGE_EVERY_NTH = 2, /* every shown frame, or every `every`th */
  FIRE3DV_IMAGE_RATE = 3,      /* newer frames only, at most rate_hz per second of the renderer's clock */
  FIRE3DV_IMAGE_EXACTLY =
      4 /* one image of frame `sequence` only; refused when a newer frame is shown first */
};

enum { FIRE3DV_LENS_NONE = 0, FIRE3DV_LENS_PLUMB_BOB = 1, FIRE3DV_LENS_FISHEYE = 2 };

/* Zero-initialised fields select the default. struct_size, width and height must be set. */
typedef struct fire3dv_image_request {
  size_t struct_size; /* sizeof(fire3dv_image_request) */
  const char* node;   /* node that carries the camera; NULL = the stream frame */
  const float*
      parent_from_camera; /* 12 floats, row-major: camera pose in that node or the stream; NULL = identity */
  uint32_t width, height; /* pixels, 1 to 8192 */
  float fx, fy, cx, cy;   /* pixels; fx = fy = 0: projection of the node's own camera */
  float near_m, far_m;    /* metres, used with fx; near_m 0 = 0.01, far_m 0 = infinite */
  int32_t lens;           /* FIRE3DV_LENS_*, used with fx */
  float lens_coefficients[5]; /* plumb_bob: k1 k2 p1 p2 k3; fisheye: k1 k2 k3 k4 */
  uint32_t outputs;           /* FIRE3DV_IMAGE_* bits; 0 = FIRE3DV_IMAGE_COLOR_SRGB8 */
  int32_t when;               /* FIRE3DV_IMAGE_ONCE, ...; 0 = FIRE3DV_IMAGE_ONCE */
  uint32_t every;             /* period in frames of FIRE3DV_IMAGE_EVERY_NTH; 0 = 1 */
  double rate_hz;             /* limit of FIRE3DV_IMAGE_RATE */
  uint64_t sequence;          /* first frame that may be shown; 0 = the newest published one */
  int32_t markers; /* 1: FIRE3DV_IMAGE_COLOR_SRGB8 shows markers (fire3dv/markers.h), other outputs do not;
                    * not together with FIRE3DV_IMAGE_COLOR_LINEAR_F16. Renderers of protocol 1.5 ignore it */
  /* Thin lens for depth of field of the colours. Both 0 = that of the node's camera, or of the renderer's
   * settings. Renderers of protocol 1.6 ignore it; fire3dv_image has the lens as used. */
  float f_number;         /* 0.1 to 1000 */
  float focus_distance_m; /* 0.001 to 1000000, along the view direction to the plane in focus */
  uint32_t reserved;      /* 0 */
  int32_t complete; /* 1: refuse the request while the renderer hides content of a stream that takes too much
                     * drawing time, instead of an image without it. Renderers of protocol 1.7 ignore it */
} fire3dv_image_request;

typedef struct fire3dv_image_plane {
  uint32_t output;        /* one FIRE3DV_IMAGE_* bit */
  uint32_t width, height; /* elements; for boxes: their count, and 1 */
  uint32_t row_stride;    /* bytes between rows; the top row is first */
  const void* data;       /* row_stride * height bytes, aligned to 16 bytes or more */
} fire3dv_image_plane;

/* Borrowed image: read-only, valid until fire3dv_release_image. */
typedef struct fire3dv_image {
  uint64_t request;            /* request id */
  uint64_t epoch, sequence;    /* pose frame shown; sequence 0 = none was published yet */
  int64_t sim_time_ns;         /* simulator time of that frame */
  uint64_t number;             /* index among the images of this request, from 1 */
  uint64_t lost;               /* images of this request lost between the previously taken one and this one */
  float world_from_camera[12]; /* row-major; rotation and translation, without scale */
  uint32_t width, height;
  float fx, fy, cx, cy, near_m, far_m; /* as used for rendering */
  int32_t lens;
  float lens_coefficients[5];
  size_t plane_count;
  const fire3dv_image_plane* planes; /* sorted by output bit */
  float f_number, focus_distance_m;  /* thin lens of the colours, as used; 0 = a pinhole */
  uint32_t hidden_streams; /* streams whose content the image lacks, since it takes too much drawing time */
  /* Number of views; 1 but for batches (fire3dv/batch.h). Planes have views * height rows; camera and
   * projection are those of the first view that is drawn. */
  uint32_t views;
} fire3dv_image;

/* Returns the plane of one FIRE3DV_IMAGE_* output; NULL if the image has none. The image owns the plane. */
static inline const fire3dv_image_plane* fire3dv_plane_of(const fire3dv_image* image, uint32_t output) {
  size_t i;
  for (i = 0; image && i < image->plane_count; ++i)
    if (image->planes[i].output == output) return &image->planes[i];
  return NULL;
}

/* Requests images and sets *id to the request's id. Call fire3dv_describe first. Requests survive a lost
 * connection and reach renderers that join later. fire3dv_describe keeps FIRE3DV_IMAGE_EVERY_NTH and _RATE
 * requests and ends others. At most 4096 requests may be open: beyond that, FIRE3DV_ERROR_SYSTEM. */
FIRE3DV_API int fire3dv_request_image(fire3dv_stream* stream, const fire3dv_image_request* request,
                                      uint64_t* id);

/* Cancels a request and drops its images that were not taken. A request that has ended already is not an
 * error. */
FIRE3DV_API int fire3dv_cancel_image(fire3dv_stream* stream, uint64_t id);

/* Returns the next image of a request, or of any request but batches with id 0. Waits at most timeout_ms
 * (FIRE3DV_ERROR_TIMEOUT); 0 only polls. FIRE3DV_ERROR_REFUSED: the renderer refused the request;
 * fire3dv_last_error has the reason. The caller must release the image. */
FIRE3DV_API int fire3dv_wait_image(fire3dv_stream* stream, uint64_t id, uint32_t timeout_ms,
                                   fire3dv_image** image);

/* Releases the image and sets *image to NULL. Accepts NULL and a pointer to NULL. */
FIRE3DV_API void fire3dv_release_image(fire3dv_image** image);

#ifdef __cplusplus
}
#endif
#endif
