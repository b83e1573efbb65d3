/* FIRE-3DV client, images: what cameras of the scene see of a stream's frames, sent back by the renderer. C11 and C++.
 *
 *   fire3dv_image_request request = {sizeof request};
 *   request.node = "wrist_camera";              // its own projection, since fx is 0
 *   request.width = 640; request.height = 480;
 *   request.when = FIRE3DV_IMAGE_EVERY_NTH;
 *   uint64_t id;
 *   fire3dv_request_image(stream, &request, &id);
 *   loop {
 *     fire3dv_publish(stream, sim_time_ns, poses, count, 0);
 *     fire3dv_image *image;
 *     if (fire3dv_wait_image(stream, id, 1000, &image) == FIRE3DV_OK) {   // or 0 ms: take what is there
 *       use(image->planes[0].data, image->sequence);
 *       fire3dv_release_image(&image);
 *     }
 *   }
 *
 * Each image says which frame it shows (sequence, sim_time_ns). Lockstep is to wait for the image of a frame before the
 * next one is published. Without waiting, images come when they come; of a request the newest one takes the place of
 * one that was not taken yet, and fire3dv_image.lost counts those.
 * Links: shm:// (pixels are looked at where the renderer wrote them, without a copy), tcp:// and tls://. Over shm:// each
 * request makes room for two images besides those that are held or lie here untaken by then: who holds back more of a
 * standing request gets no new ones. Of what nobody takes the oldest goes once it is more than 1 GiB, or 4096 images.
 * A renderer bounds what it makes, too (fire3dv: 64 MiB an image, 1 GiB for all open requests of a stream).
 * Cameras look along their -Z, with +Y up, as in glTF. Pixels are counted as OpenCV does: the middle of the upper left
 * one is (0, 0). Metres, radians, linear colour. SPEC.md section 13 has the whole of it.
 * Waiting: none of these waits but fire3dv_wait_image. The first request, and larger ones, may take memory and, over
 * shm://, the time to set it aside; later ones cost about as much as a publish.
 * Threads: as in client.h, but an image may be released on any thread, also after its stream is closed.
 */
#ifndef FIRE3DV_IMAGE_H
#define FIRE3DV_IMAGE_H

#include "fire3dv/client.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { FIRE3DV_ERROR_REFUSED = -6 }; /* the renderer does not make this image; the sentence is its own */

/* Outputs, as bits of a set. Which of them a renderer makes, it says when it refuses others. */
enum {
  FIRE3DV_IMAGE_COLOR_SRGB8 = 1,      /* 4 uint8: red, green, blue as they are shown, 255 */
  FIRE3DV_IMAGE_COLOR_LINEAR_F16 = 2, /* 4 half floats: linear, before tone mapping */
  FIRE3DV_IMAGE_DEPTH_F32 = 4,        /* float: metres along the camera's axis; infinity where nothing is */
  FIRE3DV_IMAGE_INSTANCE_U32 = 8,     /* uint32: 1 + index of the scene's node; 0 where nothing is */
  FIRE3DV_IMAGE_SEMANTIC_U32 = 16,    /* uint32: class of that node; 0 = none */
  FIRE3DV_IMAGE_NORMAL = 32,          /* 4 half floats: x, y, z in the world, 0 */
  FIRE3DV_IMAGE_MOTION = 64,          /* 2 floats: pixels since this request's image before */
  FIRE3DV_IMAGE_BOXES2D = 128,        /* records of 32 bytes; SPEC.md section 13 */
  FIRE3DV_IMAGE_BOXES3D = 256         /* records of 64 bytes; SPEC.md section 13 */
};

enum {
  FIRE3DV_IMAGE_ONCE = 1,      /* one image, of the newest frame published, or a later one */
  FIRE3DV_IMAGE_EVERY_NTH = 2, /* of each frame that is shown, or of every `every`th */
  FIRE3DV_IMAGE_RATE = 3,      /* of newer frames, at most rate_hz a second */
  FIRE3DV_IMAGE_EXACTLY = 4    /* one image, of the frame `sequence` and no other; else it is refused */
};

enum { FIRE3DV_LENS_NONE = 0, FIRE3DV_LENS_PLUMB_BOB = 1, FIRE3DV_LENS_FISHEYE = 2 };

/* Zero-initialised fields mean the default, but struct_size, width and height must be set. */
typedef struct fire3dv_image_request {
  size_t struct_size;              /* sizeof(fire3dv_image_request) */
  const char *node;                /* node that carries the camera; NULL = the stream's own frame does */
  const float *parent_from_camera; /* 12 floats, row-major: where on that node, or in the stream; NULL = identity */
  uint32_t width, height;          /* pixels, 1 to 8192 */
  float fx, fy, cx, cy;            /* pixels; fx = fy = 0: the projection of the node's own camera */
  float near_m, far_m;             /* with fx; near_m 0 = 0.01, far_m 0 = infinite */
  int32_t lens;                    /* FIRE3DV_LENS_*, with fx */
  float lens_coefficients[5];      /* plumb_bob: k1 k2 p1 p2 k3; fisheye: k1 k2 k3 k4 */
  uint32_t outputs;                /* FIRE3DV_IMAGE_* bits; 0 = FIRE3DV_IMAGE_COLOR_SRGB8 */
  int32_t when;                    /* 0 = FIRE3DV_IMAGE_ONCE */
  uint32_t every;                  /* with FIRE3DV_IMAGE_EVERY_NTH; 0 = 1 */
  double rate_hz;                  /* with FIRE3DV_IMAGE_RATE */
  uint64_t sequence;               /* of the first frame that may be shown; 0 = the newest that is published */
} fire3dv_image_request;

typedef struct fire3dv_image_plane {
  uint32_t output;        /* one FIRE3DV_IMAGE_* bit */
  uint32_t width, height; /* elements; of boxes their number, and 1 */
  uint32_t row_stride;    /* bytes from one row to the next; the upper one is first */
  const void *data;       /* row_stride * height bytes, aligned to 16 bytes or more */
} fire3dv_image_plane;

/* Read it until it is released. */
typedef struct fire3dv_image {
  uint64_t request;            /* id */
  uint64_t epoch, sequence;    /* the frame that is shown; sequence 0 = none had been published */
  int64_t sim_time_ns;         /* of that frame */
  uint64_t number;             /* of this request's images, from 1 */
  uint64_t lost;               /* images of this request between the last one taken and this one */
  float world_from_camera[12]; /* row-major; a rotation and a place */
  uint32_t width, height;
  float fx, fy, cx, cy, near_m, far_m; /* as they were used */
  int32_t lens;
  float lens_coefficients[5];
  size_t plane_count;
  const fire3dv_image_plane *planes; /* in the order of their bits */
} fire3dv_image;

/* Asks for images; *id names the request from now on. Call fire3dv_describe before. Requests are kept when a connection
 * is lost and for renderers that come later; fire3dv_describe keeps those of FIRE3DV_IMAGE_EVERY_NTH and _RATE, and
 * ends the others. At most 4096 may be open. */
FIRE3DV_API int fire3dv_request_image(fire3dv_stream *stream, const fire3dv_image_request *request, uint64_t *id);

/* No more images of this request, and those that came and were not taken are gone. One that is over already is no
 * error. */
FIRE3DV_API int fire3dv_cancel_image(fire3dv_stream *stream, uint64_t id);

/* The next image of a request, or with id 0 of any. Waits until it has come, or timeout_ms is over
 * (FIRE3DV_ERROR_TIMEOUT); 0 does not wait. FIRE3DV_ERROR_REFUSED: there will be none, and why. The image is the
 * caller's until it is released. */
FIRE3DV_API int fire3dv_wait_image(fire3dv_stream *stream, uint64_t id, uint32_t timeout_ms, fire3dv_image **image);

/* Gives the image back and sets *image to NULL. NULL and pointer to NULL are fine. */
FIRE3DV_API void fire3dv_release_image(fire3dv_image **image);

#ifdef __cplusplus
}
#endif
#endif
