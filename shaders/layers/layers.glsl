// Layers of blended fragments in a pixel, in the order of their depths whatever the order of their draws.
#ifndef FIRE3DV_LAYERS_GLSL
#define FIRE3DV_LAYERS_GLSL
#include "common/buffers.glsl"
#extension GL_EXT_shader_atomic_int64 : require

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LayerTargetRef { LayerTarget value; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer LayerKeyRef { uint64_t at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LayerRecordRef { LayerRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer LayerRestRef { LayerRest at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer LayerSampleRef { LayerSample at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer LayerWorkRef { LayerWork at[]; };

const uint64_t kLayerIdentity = (1ul << FIRE3DV_LAYER_DEPTH_SHIFT) - 1ul;

uint layer_pixels(LayerTarget target) { return target.width * target.height; }

// Offset of a sample from the pixel's centre, in pixels.
vec2 layer_sample_offset(uint s, uint sample_count) {
  const vec2 offsets[4] = vec2[4](vec2(-0.125, -0.375), vec2(0.375, -0.125), vec2(-0.375, 0.125), vec2(0.125, 0.375));
  return sample_count == 1 ? vec2(0) : offsets[s];
}

// Covered sample with the largest depth. slope: in any unit.
uint nearest_sample(vec2 slope, uint coverage, uint sample_count) {
  uint nearest = 0;
  float largest_change = -1e30;
  for (uint s = 0; s < sample_count; ++s) {
    if ((coverage & (1u << s)) == 0) continue;
    const float change = dot(slope, layer_sample_offset(s, sample_count));
    if (change > largest_change) {
      largest_change = change;
      nearest = s;
    }
  }
  return nearest;
}

// depth: reversed. number: of the fragment's primitive in the image.
uint64_t layer_key(float depth, uint number, uint coverage) {
  const uint64_t identity = uint64_t(number & ((1u << FIRE3DV_LAYER_NUMBER_BITS) - 1)) << 4 | uint64_t(coverage & 15u);
  return uint64_t(floatBitsToUint(clamp(depth, 0, 1))) << FIRE3DV_LAYER_DEPTH_SHIFT | identity;
}

#ifdef FIRE3DV_LAYER_FRAGMENT
// The fragment's pixel in the target. Helper invocations may lie outside of it, and read that of a neighbour.
uint layer_pixel(LayerTarget target) {
  const ivec2 pixel = ivec2(gl_FragCoord.xy) - ivec2(target.first_x, target.first_y);
  const ivec2 inside = clamp(pixel, ivec2(0), ivec2(target.width, target.height) - 1);
  return inside.y * target.width + inside.x;
}

struct LayerFragment {
  uint64_t key;
  vec2 slope;  // relative to the depth of the key
};

// Call it before lanes diverge.
LayerFragment layer_fragment(LayerTarget target, uint number, uint coverage, bool is_flat) {
  // Both passes need the same bits.
  precise vec2 slope = is_flat ? vec2(0) : vec2(dFdxFine(gl_FragCoord.z), dFdyFine(gl_FragCoord.z));
  const vec2 offset = layer_sample_offset(nearest_sample(slope, coverage, target.sample_count), target.sample_count);
  precise float depth = gl_FragCoord.z + slope.x * offset.x;
  depth = depth + slope.y * offset.y;
  return LayerFragment(layer_key(depth, number, coverage), slope / max(depth, 1e-30));
}

// True for fragments behind the layers of the earlier passes.
bool is_layer_of_pass(LayerTarget target, uint pixel, uint64_t key, uint pass) {
  return pass == 0 || key < LayerKeyRef(target.states).at[pixel];
}

// Adds the key to the nearest ones of the pixel. The last slot tells whether there are more.
void insert_layer(LayerTarget target, uint pixel, uint64_t key) {
  const uint pixels = layer_pixels(target);
  LayerKeyRef keys = LayerKeyRef(target.keys);
  for (uint k = 0; k <= FIRE3DV_LAYERS_PER_PASS; ++k) {
    const uint64_t old = atomicMax(keys.at[k * pixels + pixel], key);
    key = min(key, old);
    if (key == 0ul) return;
  }
}

// Slot of the fragment; FIRE3DV_LAYERS_PER_PASS: none in this pass.
uint layer_slot(LayerTarget target, uint pixel, uint64_t key) {
  const uint pixels = layer_pixels(target);
  LayerKeyRef keys = LayerKeyRef(target.keys);
  for (uint k = 0; k < FIRE3DV_LAYERS_PER_PASS; ++k) {
    const uint64_t other = keys.at[k * pixels + pixel];
    if (other == 0ul) break;
    if ((other & kLayerIdentity) == (key & kLayerIdentity)) return k;
  }
  return FIRE3DV_LAYERS_PER_PASS;
}

uint64_t rest_steps(float value) { return uint64_t(max(value, 0) * FIRE3DV_LAYER_REST_STEPS + 0.5); }

// Adds a fragment behind the layers of the last pass to their rest.
void add_rest(LayerTarget target, uint pixel, LayerFragment fragment, uint coverage, vec3 light, vec3 behind) {
  const uint64_t farthest = LayerKeyRef(target.keys).at[(FIRE3DV_LAYERS_PER_PASS - 1) * layer_pixels(target) + pixel];
  if (fragment.key >= farthest) return;
  const float share = float(bitCount(coverage)) / target.sample_count;
  const float passed = clamp(dot(behind, vec3(1.0 / 3)), 0, 1);
  LayerRestRef rests = LayerRestRef(target.rests);
  for (int c = 0; c < 3; ++c) atomicAdd(rests.at[pixel].light[c], rest_steps(share * min(light[c], 65504)));
  atomicAdd(rests.at[pixel].alpha, rest_steps(share * (1 - passed)));
  atomicAdd(rests.at[pixel].density, rest_steps(share * -log2(max(passed, 1e-6))));
}

// light: premultiplied.
void store_layer(LayerTarget target, uint pixel, LayerFragment fragment, uint coverage, uint pass, vec3 light, vec3 behind,
                 bool is_scene_referred, uint instance) {
  const uint slot = layer_slot(target, pixel, fragment.key);
  if (slot == FIRE3DV_LAYERS_PER_PASS) {
    if (pass + 1 == FIRE3DV_LAYER_PASSES) add_rest(target, pixel, fragment, coverage, light, behind);
    return;
  }
  const uvec3 steps = uvec3(round(clamp(behind, vec3(0), vec3(1)) * 1023));
  LayerRecord record;
  record.light_rg = packHalf2x16(min(light.rg, vec2(65504)));
  record.light_b = packHalf2x16(vec2(min(light.b, 65504), 0));
  record.behind = steps.r | steps.g << 10 | steps.b << 20 | FIRE3DV_LAYER_IS_DRAWN |
                  (is_scene_referred ? FIRE3DV_LAYER_SCENE_REFERRED : 0);
  record.slope = packHalf2x16(clamp(fragment.slope, vec2(-65504), vec2(65504)));
  record.instance = instance;
  LayerRecordRef(target.records).at[slot * layer_pixels(target) + pixel] = record;
}

// Whether the fragment is shaded in a pass.
bool is_shaded(LayerTarget target, uint pixel, uint64_t key, uint pass) {
  if (!is_layer_of_pass(target, pixel, key, pass)) return false;
  return pass + 1 == FIRE3DV_LAYER_PASSES || layer_slot(target, pixel, key) < FIRE3DV_LAYERS_PER_PASS;
}
#endif

#endif
