/* Markers of the FIRE-3DV client: geometry that a stream shows besides bodies, such as contact forces,
 * trajectories, point clouds and frames. C11 and C++.
 *
 *   fire3dv_marker marker = {sizeof marker};
 *   marker.kind = FIRE3DV_MARKER_ARROWS;
 *   marker.width = 3;
 *   marker.positions = tails_and_tips;
 *   marker.position_count = 2 * contact_count;
 *   fire3dv_set_marker(stream, "contacts/forces", &marker);
 *   fire3dv_publish(stream, sim_time_ns, poses, count, 0);   // shown together with the marker
 *
 * State: a marker is a scene edit (fire3dv/scene.h) whose key is its name, "namespace/name" by convention:
 * setting it again replaces it, late renderers receive the newest one, the end of the stream removes it, and
 * all together may take fire3dv_options.scene_budget_bytes. Shown: in the window, in the live view of
 * browsers and in images that the renderer itself writes. Requested images (fire3dv/image.h) have none unless
 * they ask for them, so that sensor data stay free of them. Frames: without a parent, positions are in the
 * stream's frame, like poses. With one, they are in the frame of that scene node, in metres, and a hidden
 * parent hides the marker. Colours: sRGB, shown as they are: no exposure, no tone mapping, no lights. Solids
 * are shaded by their angle to the viewer.
 */
#ifndef FIRE3DV_MARKERS_H
#define FIRE3DV_MARKERS_H

#include "fire3dv/client.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  FIRE3DV_MARKER_POINTS = 0,     /* round discs that face the viewer; width: diameter */
  FIRE3DV_MARKER_LINES = 1,      /* segments: pairs of positions */
  FIRE3DV_MARKER_LINE_STRIP = 2, /* connected segments */
  FIRE3DV_MARKER_ARROWS = 3,     /* pairs of positions, tail and tip; width: diameter of the shaft */
  FIRE3DV_MARKER_AXES = 4,       /* frames: x red, y green, z blue; sizes: lengths of the axes */
  FIRE3DV_MARKER_BOXES = 5,
  FIRE3DV_MARKER_SPHERES = 6,   /* sizes: diameters */
  FIRE3DV_MARKER_CYLINDERS = 7, /* sizes: diameters x and y, length along z */
  FIRE3DV_MARKER_CAPSULES = 8,  /* as cylinders, with a half sphere added at each end */
  FIRE3DV_MARKER_TRIANGLES = 9, /* triples of positions, seen from both sides */
  FIRE3DV_MARKER_TEXTS = 10,    /* texts that face the viewer, centred on their positions */
  FIRE3DV_MARKER_IMAGES = 11 /* an image on a rectangle, seen from both sides; sizes: width x, height y, z is
                              * ignored. Left is at -x, the top at +y */
};

enum { FIRE3DV_MARKER_PIXELS = 0, FIRE3DV_MARKER_LENGTHS = 1 };

#define FIRE3DV_MARKER_OVERLAID 1u /* in front of all surfaces: not hidden by them */

/* struct_size must be set. Other fields have no defaults: 0 means 0. */
typedef struct fire3dv_marker {
  size_t struct_size; /* sizeof(fire3dv_marker) */
  int32_t kind;       /* FIRE3DV_MARKER_* */
  int32_t width_unit; /* FIRE3DV_MARKER_PIXELS, or LENGTHS of the marker's frame */
  float width;        /* not negative; of points, lines, arrows and axes; of texts the font size (em) */
  uint32_t flags;     /* FIRE3DV_MARKER_OVERLAID or 0 */
  /* In nanoseconds of simulator time, from the frame published last; longer than a time step. 0 = until
   * replaced or cleared. */
  uint64_t lifetime_ns;
  const char* parent;              /* scene node; NULL = the frame of the stream's poses */
  const float* parent_from_marker; /* 12 floats, row-major; NULL = identity */
  const float* positions;          /* position_count times x y z; no positions: nothing is shown */
  size_t position_count;
  const float*
      rotations; /* x y z w; of axes, solids and images. NULL = none, one for all, or one per position */
  size_t rotation_count;
  const float* sizes; /* x y z, full extents; of axes, solids and images. One for all, or one per position */
  size_t size_count;
  const uint8_t* colors; /* r g b a, sRGB. NULL = white, one for all, or one per position */
  size_t color_count;
  /* Of texts: one per position. UTF-8 that ends with NUL, 1024 bytes at most, without control characters
   * except line feeds; 1 MiB in all. Of other kinds NULL. */
  const char* const* texts;
  size_t text_count;
  /* Of images: rows from the top without padding, image_width * image_height * image_channels bytes, sRGB,
   * shown as they are, on each position. 1 to 1024 pixels a side; channels: 1 grey, 3 r g b, 4 r g b a. Of
   * other kinds NULL and 0. */
  const uint8_t* image_pixels;
  uint32_t image_width;
  uint32_t image_height;
  uint32_t image_channels;
} fire3dv_marker;

/* Sets or replaces the marker of this name. Copies the arrays; allocates. */
FIRE3DV_API int fire3dv_set_marker(fire3dv_stream* stream, const char* name, const fire3dv_marker* marker);

/* Removes the marker. A name without a marker is no error. */
FIRE3DV_API int fire3dv_clear_marker(fire3dv_stream* stream, const char* name);

#ifdef __cplusplus
}
#endif
#endif
