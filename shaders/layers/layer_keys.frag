// First step of a pass over blended draws: finds the nearest fragments of each pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_post_depth_coverage : require
#define FIRE3DV_LAYER_FRAGMENT
#include "layers/layers.glsl"

layout(early_fragment_tests) in;
layout(post_depth_coverage) in;
layout(push_constant, scalar) uniform Push { LayerPush push; };
layout(location = 10) flat in uint in_first_number;

void main() {
  const LayerTarget target = LayerTargetRef(push.target).value;
  const LayerFragment fragment =
      layer_fragment(target, in_first_number + gl_PrimitiveID, uint(gl_SampleMaskIn[0]), push.is_flat != 0);
  const uint pixel = layer_pixel(target);
  if (is_layer_of_pass(target, pixel, fragment.key, push.pass)) insert_layer(target, pixel, fragment.key);
}
