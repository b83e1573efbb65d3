// Layers of blended surfaces in a pixel; see docs/design/transparency.md.
#ifndef FIRE3DV_SHARED_LAYER_TYPES_H
#define FIRE3DV_SHARED_LAYER_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

#define FIRE3DV_LAYERS_PER_PASS 8u
#define FIRE3DV_LAYER_PASSES 4u
// Of a LayerWork that has work: above the draws of a command, and within every device's limit.
#define FIRE3DV_LAYER_DRAWS 65535u

// Key of a fragment, from the highest bit: 30 bits of the largest reversed depth of its covered samples, 30
// of its number in the image, 4 of its covered samples. Greater is nearer; 0: none. Fragments of a pixel
// differ in number or coverage.
#define FIRE3DV_LAYER_DEPTH_SHIFT 34
#define FIRE3DV_LAYER_NUMBER_BITS 30

// A fragment of a blended surface, marker, line or point.
struct LayerRecord {
  uint light_rg;  // halves: premultiplied linear light
  uint light_b;   // half
  uint behind;    // transmittance of red, green and blue, 10 bits each; FIRE3DV_LAYER_*
  uint slope;     // halves: change of the depth per pixel in x and y, relative to the depth
  uint instance;  // part of the scene; FIRE3DV_NO_INDEX: a marker
};
#define FIRE3DV_LAYER_SCENE_REFERRED 0x40000000u
#define FIRE3DV_LAYER_IS_DRAWN 0x80000000u

// Light and transmittance of all layers of a sample. Their fourth values: scene-referred share, and the
// transmittance of that of the background.
struct LayerSample {
  uint light[2];   // halves
  uint behind[2];  // halves
};

// Mean of the layers behind those of all passes, weighted by opacity. Sums of the fragments, which do not
// depend on their order, in steps of 1 / FIRE3DV_LAYER_REST_STEPS and times their share of the pixel.
struct LayerRest {
  uint64_t light[3];  // premultiplied
  uint64_t alpha;     // 1 - transmittance
  uint64_t density;   // - log2(transmittance)
};
#define FIRE3DV_LAYER_REST_STEPS 65536.0f

// Work of one pass: arguments of its draws and of the dispatch that composites them.
struct LayerWork {
  uint draw_count;  // 0: none; FIRE3DV_LAYER_DRAWS: all
  uint groups_x;
  uint groups_y;
  uint groups_z;
};

// Layers of a rectangle of an image. Arrays over pixels are row by row.
struct LayerTarget {
  FIRE3DV_ADDRESS keys;     // uint64_t[FIRE3DV_LAYERS_PER_PASS + 1][pixel], zero before and after
  FIRE3DV_ADDRESS records;  // LayerRecord[FIRE3DV_LAYERS_PER_PASS][pixel]
  FIRE3DV_ADDRESS samples;  // LayerSample[sample][pixel]
  FIRE3DV_ADDRESS states;   // uint64_t[pixel]: FIRE3DV_LAYERS_*, or the key of the farthest composited layer
  FIRE3DV_ADDRESS rests;    // LayerRest[pixel], zero before and after
  FIRE3DV_ADDRESS work;     // LayerWork[FIRE3DV_LAYER_PASSES]
  uint first_x;
  uint first_y;
  uint width;
  uint height;
  uint sample_count;
};
#define FIRE3DV_LAYERS_NONE 0
#define FIRE3DV_LAYERS_DONE 1

struct LayerPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS target;  // LayerTarget
  uint pass;
  uint is_flat;  // lines and points: their depth does not change within a pixel
  uint draw_count;
  uint piece_triangles;  // of a draw, split at a time limit: gl_InstanceIndex = piece * draw_count + draw
};

FIRE3DV_SHARED_END
#endif
