// First step of depth of field: the mean light of each pixel's samples in two layers, up to the plane in focus and behind
// it, with the circles of confusion. Variants: FIRE3DV_MULTISAMPLED.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/generations.glsl"
#include "common/halves.glsl"
#include "post/depth_of_field.glsl"

layout(local_size_x = FIRE3DV_BLUR_TILE, local_size_y = FIRE3DV_BLUR_TILE) in;
layout(push_constant, scalar) uniform Push { DepthOfFieldPush push; };
#ifdef FIRE3DV_MULTISAMPLED
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba16f) uniform readonly image2DMS hdr;
#define kSampleIndex(i) , i
#else
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba16f) uniform readonly image2D hdr;
#define kSampleIndex(i)
#endif
// id, encode_depth()
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SampleRef { uvec2 at[]; };

const float kLargestLight = 65504;  // of half floats

shared uint near_radius, far_radius;

// Radius of a disc with an edge one pixel wide that has the second moment of a disc with a sharp edge.
float drawn_radius(float radius) { return sqrt(max(radius * radius - 5.0 / 12, kSharpRadius * kSharpRadius)); }

// Mean of samples, times their share of the pixel.
struct Layer {
  vec3 light;
  float share, radius, scene_referred;
  float radius_weight;
};

// The radius of a pixel is the mean by light, so that a bright sample keeps its circle.
void add(inout Layer layer, vec3 light, float radius, float scene_referred) {
  const float weight = light.r + light.g + light.b + 1e-6;
  layer.light += light;
  layer.share += 1;
  layer.radius += weight * radius;
  layer.radius_weight += weight;
  layer.scene_referred += scene_referred;
}

void take_mean(inout Layer layer, float samples) {
  if (layer.share > 0) layer.radius /= layer.radius_weight;
  layer.light = min(layer.light / samples, vec3(kLargestLight));
  layer.share /= samples;
  layer.scene_referred /= samples;
}

void split(ivec2 pixel) {
  const uint index = pixel.y * push.width + pixel.x;
  Layer near_layer = Layer(vec3(0), 0, 0, 0, 0), far_layer = near_layer;
  for (int i = 0; i < push.samples; ++i) {
    const vec4 color = imageLoad(hdr, pixel kSampleIndex(i));
    const uvec2 seen = SampleRef(push.visibility).at[index * push.samples + i];
    const bool is_background = seen.y < push.generation || seen.x == 0;
    const float signed_radius = is_background ? push.radius_of_background
                                              : push.radius_at_zero + push.radius_per_depth * decode_depth(seen.y, push.generation);
    const float radius = min(drawn_radius(abs(signed_radius)), FIRE3DV_MAX_BLUR_RADIUS);
    const float scene_referred = clamp(color.a, 0, 1);
    // Display-referred colours count as light of the brightness that the display shows.
    vec3 light = scene_referred * max(color.rgb, vec3(0)) + (1 - scene_referred) * clamp(color.rgb, vec3(0), vec3(1));
    light = min(mix(light, vec3(0), isnan(light)), vec3(65504));  // blending may exceed the largest half
    if (signed_radius < 0 || radius <= kSharpRadius) {
      add(near_layer, light, radius, scene_referred);
    } else {
      add(far_layer, light, radius, scene_referred);
    }
  }
  take_mean(near_layer, push.samples);
  take_mean(far_layer, push.samples);
  const uvec2 near_light = pack_halves(near_layer.light, near_layer.share);
  const uvec2 far_light = pack_halves(far_layer.light, far_layer.share);
  BlurTexelOut(push.texels).at[index] =
      BlurTexel(uint[2](near_light.x, near_light.y), uint[2](far_light.x, far_light.y),
                packHalf2x16(vec2(near_layer.radius, far_layer.radius)),
                packHalf2x16(vec2(near_layer.scene_referred, far_layer.scene_referred)));
  atomicMax(near_radius, floatBitsToUint(near_layer.radius));
  atomicMax(far_radius, floatBitsToUint(far_layer.radius));
}

void main() {
  if (gl_LocalInvocationIndex == 0) near_radius = far_radius = 0;
  barrier();
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x < push.width && pixel.y < push.height) split(pixel);
  barrier();
  if (gl_LocalInvocationIndex == 0)
    BlurTileOut(push.tiles).at[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = BlurTile(near_radius, far_radius);
}
