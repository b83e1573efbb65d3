// Last step of a pass over blended draws: composites the nearest fragments of each pixel, sample by sample, behind those
// of the earlier passes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "layers/layers.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { LayerPush push; };

vec4 behind_of(LayerRecord record) {
  const vec3 behind = vec3(record.behind & 1023u, record.behind >> 10 & 1023u, record.behind >> 20 & 1023u) / 1023;
  return vec4(behind, dot(behind, vec3(1.0 / 3)));
}

vec4 light_of(LayerRecord record, vec4 behind) {
  const bool is_scene_referred = (record.behind & FIRE3DV_LAYER_SCENE_REFERRED) != 0;
  return vec4(unpackHalf2x16(record.light_rg), unpackHalf2x16(record.light_b).x, is_scene_referred ? 1 - behind.a : 0);
}

// Light and transmittance of the rest.
void take_rest(LayerRestRef rests, uint pixel, out vec4 light, out vec4 behind) {
  const LayerRest rest = rests.at[pixel];
  rests.at[pixel] = LayerRest(uint64_t[3](0ul, 0ul, 0ul), 0ul, 0ul);
  behind = vec4(exp2(-float(rest.density) / FIRE3DV_LAYER_REST_STEPS));
  const vec3 sum = vec3(float(rest.light[0]), float(rest.light[1]), float(rest.light[2]));
  light = rest.alpha == 0ul ? vec4(0) : vec4(sum / float(rest.alpha), 1) * (1 - behind.x);
}

void main() {
  const LayerTarget target = LayerTargetRef(push.target).value;
  const uint pixels = layer_pixels(target), pixel = gl_GlobalInvocationID.x;
  if (pixel >= pixels) return;
  LayerKeyRef keys = LayerKeyRef(target.keys), states = LayerKeyRef(target.states);
  LayerRecordRef records = LayerRecordRef(target.records);
  uint64_t key[FIRE3DV_LAYERS_PER_PASS];
  LayerRecord record[FIRE3DV_LAYERS_PER_PASS];
  uint count = 0;
  for (; count < FIRE3DV_LAYERS_PER_PASS; ++count) {
    const uint index = count * pixels + pixel;
    key[count] = keys.at[index];
    if (key[count] == 0ul) break;
    record[count] = records.at[index];
    keys.at[index] = 0ul;
    records.at[index].behind = 0;  // draws that end early leave none
  }
  if (count == 0) {
    if (push.pass == 0) states.at[pixel] = FIRE3DV_LAYERS_NONE;
    return;
  }
  bool has_more = false, has_rest = false;
  if (count == FIRE3DV_LAYERS_PER_PASS) {
    const uint index = count * pixels + pixel;
    const bool is_last = push.pass + 1 == FIRE3DV_LAYER_PASSES;
    has_more = keys.at[index] != 0ul && !is_last;
    has_rest = keys.at[index] != 0ul && is_last;
    keys.at[index] = 0ul;
  }
  vec4 rest_light = vec4(0), rest_behind = vec4(1);
  if (has_rest) take_rest(LayerRestRef(target.rests), pixel, rest_light, rest_behind);
  states.at[pixel] = has_more ? key[count - 1] : FIRE3DV_LAYERS_DONE;
  if (has_more) {
    LayerWorkRef work = LayerWorkRef(target.work);
    work.at[push.pass + 1].draw_count = FIRE3DV_LAYER_DRAWS;
    work.at[push.pass + 1].groups_x = gl_NumWorkGroups.x;
  }
  LayerSampleRef samples = LayerSampleRef(target.samples);
  for (uint s = 0; s < target.sample_count; ++s) {
    float depth[FIRE3DV_LAYERS_PER_PASS];
    uint left = 0;
    for (uint i = 0; i < count; ++i) {
      const uint coverage = uint(key[i]) & 15u;
      if ((coverage & (1u << s)) == 0 || (record[i].behind & FIRE3DV_LAYER_IS_DRAWN) == 0) continue;
      left |= 1u << i;
      const vec2 slope = unpackHalf2x16(record[i].slope);
      const vec2 offset = layer_sample_offset(s, target.sample_count) -
                          layer_sample_offset(nearest_sample(slope, coverage, target.sample_count), target.sample_count);
      depth[i] = uintBitsToFloat(uint(key[i] >> FIRE3DV_LAYER_DEPTH_SHIFT)) * (1 + dot(slope, offset));
    }
    vec4 light = vec4(0), behind = vec4(1);
    if (push.pass > 0) {
      const LayerSample before = samples.at[s * pixels + pixel];
      light = vec4(unpackHalf2x16(before.light[0]), unpackHalf2x16(before.light[1]));
      behind = vec4(unpackHalf2x16(before.behind[0]), unpackHalf2x16(before.behind[1]));
    }
    // Front to back. Equal depths keep the order of their keys.
    while (left != 0) {
      uint nearest = findLSB(left);
      for (uint i = nearest + 1; i < count; ++i)
        if ((left & (1u << i)) != 0 && depth[i] > depth[nearest]) nearest = i;
      left &= ~(1u << nearest);
      const vec4 passed = behind_of(record[nearest]);
      light += behind * light_of(record[nearest], passed);
      behind *= passed;
    }
    light = min(light + behind * rest_light, vec4(65504));
    behind *= rest_behind;
    samples.at[s * pixels + pixel] = LayerSample(uint[2](packHalf2x16(light.rg), packHalf2x16(light.ba)),
                                                 uint[2](packHalf2x16(behind.rg), packHalf2x16(behind.ba)));
  }
}
