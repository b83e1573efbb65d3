// Subgroup helpers of variant FIRE3DV_CPU, for devices that are a CPU: invocations are lanes of one 8-wide
// vector (see pipeline.cpp). A read costs as much as some dozen additions, and each lane repeats it, even for
// a uniform address. The driver merges only reads at statically known addresses outside of branches. So these
// variants copy the globals first, and each lane reads one word of a uniform record and broadcasts it. Limit:
// all loops of an invocation together end after 65535 iterations without an error (gallivm). Sequential work
// must stay far below it.
#ifndef FIRE3DV_LANES_GLSL
#define FIRE3DV_LANES_GLSL

#include "common/scene_variant.glsl"

#ifdef FIRE3DV_CPU
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer GlobalsAddress { Globals value; };

struct GlobalsRef {
  Globals value;
};
GlobalsRef globals_at(uint64_t address) {
  GlobalsRef globals;
  globals.value = GlobalsAddress(address).value;
  return globals;
}

// Records as words, for FIRE3DV_OWN_WORD(record, 0): words 0 to 7, one in each lane.
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AffineWords { uint at[12]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PartWords { uint at[4]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightWords { uint at[16]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialWords { uint at[56]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewWords { uint at[52]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PreparedWords { uint at[11]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstanceWords { uint at[6]; };

#define FIRE3DV_OWN_WORD(record, first, count) (record).at[min((first) + gl_SubgroupInvocationID, (count) - 1)]
#define FIRE3DV_WORD(own_words, i) subgroupBroadcast(own_words, i)
#define FIRE3DV_NUMBER(own_words, i) uintBitsToFloat(subgroupBroadcast(own_words, i))

// Maximum over all lanes; 0 if x is 0 in all of them.
uint largest_of_lanes(uint x) {
  const uint a = max(subgroupBroadcast(x, 0), subgroupBroadcast(x, 1)), b = max(subgroupBroadcast(x, 2), subgroupBroadcast(x, 3)),
             c = max(subgroupBroadcast(x, 4), subgroupBroadcast(x, 5)), d = max(subgroupBroadcast(x, 6), subgroupBroadcast(x, 7));
  return max(max(a, b), max(c, d));
}

float min_of_lanes(float x) {
  const float a = min(subgroupBroadcast(x, 0), subgroupBroadcast(x, 1)), b = min(subgroupBroadcast(x, 2), subgroupBroadcast(x, 3)),
              c = min(subgroupBroadcast(x, 4), subgroupBroadcast(x, 5)), d = min(subgroupBroadcast(x, 6), subgroupBroadcast(x, 7));
  return min(min(a, b), min(c, d));
}

bool all_lanes_have(uint x) { return subgroupBallot(x != subgroupBroadcast(x, 0)).x == 0; }

// The functions below need uniform arguments and all lanes active.
AffineRows affine_for_all(uint64_t affines, uint index) {
  AffineWords record = AffineWords(affines)[index];
  const uint low = FIRE3DV_OWN_WORD(record, 0, 12), high = FIRE3DV_OWN_WORD(record, 8, 12);
  AffineRows rows;
  rows.row0 = vec4(FIRE3DV_NUMBER(low, 0), FIRE3DV_NUMBER(low, 1), FIRE3DV_NUMBER(low, 2), FIRE3DV_NUMBER(low, 3));
  rows.row1 = vec4(FIRE3DV_NUMBER(low, 4), FIRE3DV_NUMBER(low, 5), FIRE3DV_NUMBER(low, 6), FIRE3DV_NUMBER(low, 7));
  rows.row2 = vec4(FIRE3DV_NUMBER(high, 0), FIRE3DV_NUMBER(high, 1), FIRE3DV_NUMBER(high, 2), FIRE3DV_NUMBER(high, 3));
  return rows;
}

PartRecord part_for_all(uint64_t parts, uint index) {
  PartWords record = PartWords(parts)[index];
  const uint words = FIRE3DV_OWN_WORD(record, 0, 4);
  return PartRecord(FIRE3DV_WORD(words, 0), FIRE3DV_WORD(words, 1), FIRE3DV_WORD(words, 2), FIRE3DV_WORD(words, 3));
}

ClusterInstance instance_for_all(uint64_t instances, uint index) {
  InstanceWords record = InstanceWords(instances)[index];
  const uint words = FIRE3DV_OWN_WORD(record, 0, 6);
  return ClusterInstance(FIRE3DV_WORD(words, 0), FIRE3DV_WORD(words, 1), FIRE3DV_WORD(words, 2), FIRE3DV_WORD(words, 3),
                         FIRE3DV_WORD(words, 4), FIRE3DV_WORD(words, 5));
}

// Three vertex positions are nine words: the lanes read the first eight.
void positions_for_all(uint64_t positions, uint vertex[3], out vec3 node[3]) {
  const uint lane = gl_SubgroupInvocationID, corner = lane < 3 ? vertex[0] : lane < 6 ? vertex[1] : vertex[2];
  const uint words = UintRef(positions).at[corner * 3 + lane % 3], last = UintRef(positions).at[vertex[2] * 3 + 2];
  node[0] = vec3(FIRE3DV_NUMBER(words, 0), FIRE3DV_NUMBER(words, 1), FIRE3DV_NUMBER(words, 2));
  node[1] = vec3(FIRE3DV_NUMBER(words, 3), FIRE3DV_NUMBER(words, 4), FIRE3DV_NUMBER(words, 5));
  node[2] = vec3(FIRE3DV_NUMBER(words, 6), FIRE3DV_NUMBER(words, 7), uintBitsToFloat(last));
}

// First two words of three vertices' records with record_words words each.
void pairs_for_all(uint64_t records, const uint record_words, uint vertex[3], out uvec2 pair[3]) {
  const uint lane = gl_SubgroupInvocationID, corner = lane < 2 ? vertex[0] : lane < 4 ? vertex[1] : vertex[2];
  const uint words = UintRef(records).at[corner * record_words + lane % 2];
  for (uint i = 0; i < 3; ++i) pair[i] = uvec2(FIRE3DV_WORD(words, 2 * i), FIRE3DV_WORD(words, 2 * i + 1));
}

// Reads the view without its frustum planes.
RasterView view_for_all(uint64_t views, uint index) {
  ViewWords record = ViewWords(views)[index];
  const uint a = FIRE3DV_OWN_WORD(record, 0, 52), b = FIRE3DV_OWN_WORD(record, 8, 52), c = FIRE3DV_OWN_WORD(record, 40, 52),
             d = FIRE3DV_OWN_WORD(record, 48, 52);
  RasterView view;
  view.clip_from_world =
      mat4(FIRE3DV_NUMBER(a, 0), FIRE3DV_NUMBER(a, 1), FIRE3DV_NUMBER(a, 2), FIRE3DV_NUMBER(a, 3),  //
           FIRE3DV_NUMBER(a, 4), FIRE3DV_NUMBER(a, 5), FIRE3DV_NUMBER(a, 6), FIRE3DV_NUMBER(a, 7),  //
           FIRE3DV_NUMBER(b, 0), FIRE3DV_NUMBER(b, 1), FIRE3DV_NUMBER(b, 2), FIRE3DV_NUMBER(b, 3),  //
           FIRE3DV_NUMBER(b, 4), FIRE3DV_NUMBER(b, 5), FIRE3DV_NUMBER(b, 6), FIRE3DV_NUMBER(b, 7));
  view.eye_world = vec4(FIRE3DV_NUMBER(c, 0), FIRE3DV_NUMBER(c, 1), FIRE3DV_NUMBER(c, 2), FIRE3DV_NUMBER(c, 3));
  view.width = FIRE3DV_WORD(c, 4);
  view.height = FIRE3DV_WORD(c, 5);
  view.first_texel = FIRE3DV_WORD(c, 6);
  view.depth_m = FIRE3DV_NUMBER(c, 7);
  view.texel_m = FIRE3DV_NUMBER(d, 0);
  view.level_scale = FIRE3DV_NUMBER(d, 1);
  view.first_tile = FIRE3DV_WORD(d, 2);
  return view;
}

PreparedTriangle prepared_for_all(uint64_t prepared, uint index) {
  PreparedWords record = PreparedWords(prepared)[index];
  const uint low = FIRE3DV_OWN_WORD(record, 0, 11), high = FIRE3DV_OWN_WORD(record, 8, 11);
  PreparedTriangle triangle;
  triangle.a = ivec2(FIRE3DV_WORD(low, 0), FIRE3DV_WORD(low, 1));
  triangle.b = ivec2(FIRE3DV_WORD(low, 2), FIRE3DV_WORD(low, 3));
  triangle.c = ivec2(FIRE3DV_WORD(low, 4), FIRE3DV_WORD(low, 5));
  triangle.za = FIRE3DV_NUMBER(low, 6);
  triangle.zb = FIRE3DV_NUMBER(low, 7);
  triangle.zc = FIRE3DV_NUMBER(high, 0);
  triangle.id = FIRE3DV_WORD(high, 1);
  triangle.view = FIRE3DV_WORD(high, 2);
  return triangle;
}

LightPose light_for_all(uint64_t lights, uint index) {
  LightWords record = LightWords(lights)[index];
  const uint low = FIRE3DV_OWN_WORD(record, 0, 16), high = FIRE3DV_OWN_WORD(record, 8, 16);
  LightPose light;
  light.color = vec3(FIRE3DV_NUMBER(low, 0), FIRE3DV_NUMBER(low, 1), FIRE3DV_NUMBER(low, 2));
  light.range_m = FIRE3DV_NUMBER(low, 3);
  light.position_world = vec3(FIRE3DV_NUMBER(low, 4), FIRE3DV_NUMBER(low, 5), FIRE3DV_NUMBER(low, 6));
  light.type = FIRE3DV_WORD(low, 7);
  light.light_direction_world = vec3(FIRE3DV_NUMBER(high, 0), FIRE3DV_NUMBER(high, 1), FIRE3DV_NUMBER(high, 2));
  light.cone_scale = FIRE3DV_NUMBER(high, 3);
  light.cone_offset = FIRE3DV_NUMBER(high, 4);
  light.radius_m = FIRE3DV_NUMBER(high, 5);
  light.angular_radius_rad = FIRE3DV_NUMBER(high, 6);
  light.sine = FIRE3DV_NUMBER(high, 7);
  return light;
}

TextureUse texture_use_for_all(MaterialWords record, uint first) {
  const uint words = FIRE3DV_OWN_WORD(record, first, 56);
  TextureUse use;
  use.texture = FIRE3DV_WORD(words, 0);
  use.size = FIRE3DV_WORD(words, 1);
  use.uv_offset = vec2(FIRE3DV_NUMBER(words, 2), FIRE3DV_NUMBER(words, 3));
  use.uv_rows = vec4(FIRE3DV_NUMBER(words, 4), FIRE3DV_NUMBER(words, 5), FIRE3DV_NUMBER(words, 6), FIRE3DV_NUMBER(words, 7));
  return use;
}

MaterialRecord material_for_all(uint64_t materials, uint index) {
  MaterialWords record = MaterialWords(materials)[index];
  const uint low = FIRE3DV_OWN_WORD(record, 0, 14), high = FIRE3DV_OWN_WORD(record, 8, 14);
  MaterialRecord material;
  material.base_color =
      vec4(FIRE3DV_NUMBER(low, 0), FIRE3DV_NUMBER(low, 1), FIRE3DV_NUMBER(low, 2), FIRE3DV_NUMBER(low, 3));
  material.emissive = vec3(FIRE3DV_NUMBER(low, 4), FIRE3DV_NUMBER(low, 5), FIRE3DV_NUMBER(low, 6));
  material.metallic = FIRE3DV_NUMBER(low, 7);
  material.roughness = FIRE3DV_NUMBER(high, 0);
  material.normal_scale = FIRE3DV_NUMBER(high, 1);
  material.occlusion_strength = FIRE3DV_NUMBER(high, 2);
  material.alpha_cutoff = FIRE3DV_NUMBER(high, 3);
  material.flags = FIRE3DV_WORD(high, 4);
  material.extension = FIRE3DV_WORD(high, 5);
  if (kTextures && (material.flags & FIRE3DV_MATERIAL_TEXTURED) != 0) {
    material.base_color_texture = texture_use_for_all(record, 16);
    material.metallic_roughness_texture = texture_use_for_all(record, 24);
    material.normal_texture = texture_use_for_all(record, 32);
    material.occlusion_texture = texture_use_for_all(record, 40);
    material.emissive_texture = texture_use_for_all(record, 48);
  } else {
    const TextureUse none = TextureUse(FIRE3DV_NO_INDEX, 0, vec2(0), vec4(0));
    material.base_color_texture = material.metallic_roughness_texture = material.normal_texture =
        material.occlusion_texture = material.emissive_texture = none;
  }
  return material;
}
#else
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer GlobalsRef { Globals value; };

GlobalsRef globals_at(uint64_t address) { return GlobalsRef(address); }
#endif

#endif
