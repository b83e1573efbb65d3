// Output of marker fragments: blended over the target or, with FIRE3DV_LAYERS, a layer of the pixel.
// FIRE3DV_LAYER_KEYS: only its key.
#ifndef FIRE3DV_MARKER_OUTPUT_GLSL
#define FIRE3DV_MARKER_OUTPUT_GLSL
#include "common/buffers.glsl"

layout(push_constant, scalar) uniform Push { MarkerPush push; };

#ifdef FIRE3DV_LAYERS
#extension GL_EXT_post_depth_coverage : require
#define FIRE3DV_LAYER_FRAGMENT
#include "layers/layers.glsl"

layout(early_fragment_tests) in;
layout(post_depth_coverage) in;
layout(location = 2) flat in uint in_number;

LayerTarget layer_target;
LayerFragment layer;
uint layer_at, layer_coverage;

// Call it first. Returns false if there is nothing to shade. inside: samples within the shape.
bool begin_marker(uint inside) {
  layer_target = LayerTargetRef(push.target).value;
  layer_coverage = uint(gl_SampleMaskIn[0]) & inside;
  layer = layer_fragment(layer_target, in_number, layer_coverage, false);
  layer_at = layer_pixel(layer_target);
  if (layer_coverage == 0) return false;
#ifdef FIRE3DV_LAYER_KEYS
  if (is_layer_of_pass(layer_target, layer_at, layer.key, push.pass)) insert_layer(layer_target, layer_at, layer.key);
  return false;
#else
  return is_shaded(layer_target, layer_at, layer.key, push.pass);
#endif
}

// premultiplied: display-referred.
void draw_marker(vec4 premultiplied) {
  store_layer(layer_target, layer_at, layer, layer_coverage, push.pass, premultiplied.rgb, vec3(1 - premultiplied.a), false,
              FIRE3DV_NO_INDEX);
}
#else
layout(location = 0) out vec4 out_color;

bool begin_marker(uint inside) { return true; }
void draw_marker(vec4 premultiplied) { out_color = premultiplied; }
#endif

#endif
