// Test of structures shared by C++ and GLSL: the member offsets in SPIR-V equal offsetof. Also checks that
// every embedded shader is SPIR-V.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <map>
#include <string>

#include "shaders/embedded.h"
#include "shaders/shared/types.h"

namespace fire3dv {
namespace {

using Offsets = std::map<std::string, uint32_t>;  // member -> offset in bytes

// SPIR-V instructions with the names and offsets of members (specification, sections 3.49.2-3).
constexpr uint32_t kOpName = 5, kOpMemberName = 6, kOpMemberDecorate = 72;
constexpr uint32_t kDecorationOffset = 35;

std::string literal_string(const uint32_t* words, uint32_t count) {
  const char* text = reinterpret_cast<const char*>(words);
  return std::string(text, strnlen(text, count * sizeof(uint32_t)));
}

// Returns the structures of all shaders by name. Ids of one name within a module must agree.
std::map<std::string, Offsets> reflect() {
  std::map<std::string, Offsets> structures;
  for (std::string_view name : shaders::names()) {
    const std::span<const uint32_t> code = shaders::embedded(name);
    std::map<uint32_t, std::string> names;
    std::map<uint32_t, std::map<uint32_t, std::string>> members;
    std::map<uint32_t, std::map<uint32_t, uint32_t>> offsets;
    for (size_t i = 5; i < code.size();) {
      const uint32_t op = code[i] & 0xffff, length = code[i] >> 16;
      if (length == 0 || i + length > code.size()) {
        ADD_FAILURE() << name << " is not well-formed SPIR-V";
        break;
      }
      const uint32_t* word = code.data() + i;
      if (op == kOpName) names[word[1]] = literal_string(word + 2, length - 2);
      if (op == kOpMemberName) members[word[1]][word[2]] = literal_string(word + 3, length - 3);
      if (op == kOpMemberDecorate && length == 5 && word[3] == kDecorationOffset)
        offsets[word[1]][word[2]] = word[4];
      i += length;
    }
    for (const auto& [id, member_offsets] : offsets) {
      for (const auto& [member, offset] : member_offsets) {
        const auto [known, inserted] = structures[names[id]].emplace(members[id][member], offset);
        EXPECT_TRUE(inserted || known->second == offset)
            << name << ": " << names[id] << "." << members[id][member];
      }
    }
  }
  return structures;
}

class ShaderLayout : public ::testing::Test {
 protected:
  void expect_offset(const char* structure, const char* member, size_t offset) {
    static const std::map<std::string, Offsets> structures = reflect();
    const auto found = structures.find(structure);
    ASSERT_NE(found, structures.end()) << structure << " is used by no shader";
    const auto at = found->second.find(member);
    ASSERT_NE(at, found->second.end()) << structure << "." << member;
    EXPECT_EQ(at->second, offset) << structure << "." << member;
  }
};

#define EXPECT_SAME_OFFSET(structure, member) \
  expect_offset(#structure, #member, offsetof(gpu_types::structure, member))

TEST_F(ShaderLayout, MembersMatchInCppAndGlsl) {
  EXPECT_SAME_OFFSET(AffineRows, row0);
  EXPECT_SAME_OFFSET(AffineRows, row2);
  EXPECT_SAME_OFFSET(NodeSource, stream);
  EXPECT_SAME_OFFSET(NodeSource, pose_index);
  EXPECT_SAME_OFFSET(MarkerPush, globals);
  EXPECT_SAME_OFFSET(MarkerPush, world_from_marker);
  EXPECT_SAME_OFFSET(MarkerPush, width);
  EXPECT_SAME_OFFSET(MarkerPush, rings);
  EXPECT_SAME_OFFSET(StreamSource, poses);
  EXPECT_SAME_OFFSET(StreamSource, world_from_stream);
  EXPECT_SAME_OFFSET(TextureUse, uv_rows);
  EXPECT_SAME_OFFSET(TextureUse, uv_offset);
  EXPECT_SAME_OFFSET(MaterialRecord, emissive);
  EXPECT_SAME_OFFSET(MaterialRecord, metallic);
  EXPECT_SAME_OFFSET(MaterialRecord, flags);
  EXPECT_SAME_OFFSET(MaterialRecord, base_color_texture);
  EXPECT_SAME_OFFSET(MaterialRecord, emissive_texture);
  EXPECT_SAME_OFFSET(MaterialRecord, extension);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, specular);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, anisotropy);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, iridescence_thickness_nm);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, transmission);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, specular_texture);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, absorption_per_m);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, diffuse_transmission_color);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, transmission_texture);
  EXPECT_SAME_OFFSET(MaterialExtensionRecord, diffuse_transmission_color_texture);
  EXPECT_SAME_OFFSET(FrameRecord, normal_z_tangent_z);
  EXPECT_SAME_OFFSET(ExtrasRecord, color_ba);
  EXPECT_SAME_OFFSET(PrimitiveRecord, material);
  EXPECT_SAME_OFFSET(PrimitiveRecord, mesh_radius);
  EXPECT_SAME_OFFSET(PrimitiveRecord, first_ray_box);
  EXPECT_SAME_OFFSET(RayBoxRecord, high);
  EXPECT_SAME_OFFSET(RayBoxRecord, triangles);
  EXPECT_SAME_OFFSET(InfluenceRecord, weights);
  EXPECT_SAME_OFFSET(JointRecord, node);
  EXPECT_SAME_OFFSET(JointBoundsRecord, high);
  EXPECT_SAME_OFFSET(MorphDeltaRecord, tangent);
  EXPECT_SAME_OFFSET(DeformRecord, skinned);
  EXPECT_SAME_OFFSET(DeformRecord, first_weight);
  EXPECT_SAME_OFFSET(DeformGroup, first_vertex);
  EXPECT_SAME_OFFSET(DrawRecord, primitive);
  EXPECT_SAME_OFFSET(DrawRecord, first_number);
  EXPECT_SAME_OFFSET(LightRecord, range_m);
  EXPECT_SAME_OFFSET(LightRecord, cone_offset);
  EXPECT_SAME_OFFSET(LightRecord, angular_radius_rad);
  EXPECT_SAME_OFFSET(Globals, indices);
  EXPECT_SAME_OFFSET(Globals, clip_from_world);
  EXPECT_SAME_OFFSET(Globals, eye_world);
  EXPECT_SAME_OFFSET(Globals, light_count);
  EXPECT_SAME_OFFSET(Globals, environment_turn);
  EXPECT_SAME_OFFSET(Globals, background_lod);
  EXPECT_SAME_OFFSET(Globals, world_from_ndc_origin);
  EXPECT_SAME_OFFSET(Globals, shadows);
  // Push constant blocks hold their structure at offset 0.
  EXPECT_SAME_OFFSET(TransformsPush, node_count);
  EXPECT_SAME_OFFSET(DeformPush, group_count);
  EXPECT_SAME_OFFSET(EnvironmentPush, lod);
  EXPECT_SAME_OFFSET(ForwardPush, globals);
  EXPECT_SAME_OFFSET(PostPush, width);
  EXPECT_SAME_OFFSET(LayerPush, piece_triangles);
  EXPECT_SAME_OFFSET(LayerTarget, sample_count);
  EXPECT_SAME_OFFSET(LayerRecord, instance);
  EXPECT_SAME_OFFSET(LayerSample, behind);
  EXPECT_SAME_OFFSET(LayerWork, groups_x);
  EXPECT_SAME_OFFSET(PostPush, tone_map);
  EXPECT_SAME_OFFSET(BloomLightPush, exposure);
  EXPECT_SAME_OFFSET(SensorPush, along_rows);
  EXPECT_SAME_OFFSET(SensorRecord, ray_x);
  EXPECT_SAME_OFFSET(SensorRecord, frame_high);
  EXPECT_SAME_OFFSET(MaskPlanesPush, mask_cut);
  EXPECT_SAME_OFFSET(LightMeterPush, samples);
  EXPECT_SAME_OFFSET(LightMeterResolvePush, fallback);
  EXPECT_SAME_OFFSET(EnvironmentCell, density);
  EXPECT_SAME_OFFSET(PathState, direction_world);
  EXPECT_SAME_OFFSET(PathState, throughput);
  EXPECT_SAME_OFFSET(PathState, radiance);
  EXPECT_SAME_OFFSET(PathState, media);
  EXPECT_SAME_OFFSET(PathSum, radiance_samples);
  EXPECT_SAME_OFFSET(PathSum, display);
  EXPECT_SAME_OFFSET(PathSum, samples);
  EXPECT_SAME_OFFSET(PathParameters, origin_x);
  EXPECT_SAME_OFFSET(PathParameters, lens_y_m);
  EXPECT_SAME_OFFSET(PathParameters, look_world);
  EXPECT_SAME_OFFSET(PathParameters, seed);
  EXPECT_SAME_OFFSET(PathPush, segments);
  EXPECT_SAME_OFFSET(RayEffectsPush, globals);
  EXPECT_SAME_OFFSET(RayEffectsPush, pixel_angle_rad);
  EXPECT_SAME_OFFSET(RayEffectRecord, normal);
  EXPECT_SAME_OFFSET(BouncedRecord, all);
  EXPECT_SAME_OFFSET(PathResolvePush, tone_map);
  EXPECT_SAME_OFFSET(PickedSurface, part);
  EXPECT_SAME_OFFSET(PickedSurface, transform);
  EXPECT_SAME_OFFSET(PickPush, y);
  EXPECT_SAME_OFFSET(DepthRange, farthest);
  EXPECT_SAME_OFFSET(DebugViewPush, view);
  EXPECT_SAME_OFFSET(UnresolvedPixelsPush, marks);
  EXPECT_SAME_OFFSET(OutlinePush, selected);
}

// Every member: an address that is off by one would write another plane.
TEST_F(ShaderLayout, MembersOfOutputsMatch) {
  EXPECT_SAME_OFFSET(PartLabels, instance);
  EXPECT_SAME_OFFSET(PartLabels, semantic);
  EXPECT_SAME_OFFSET(OutputsWanted, depth);
  EXPECT_SAME_OFFSET(OutputsWanted, instance);
  EXPECT_SAME_OFFSET(OutputsWanted, semantic);
  EXPECT_SAME_OFFSET(OutputsWanted, normal);
  EXPECT_SAME_OFFSET(OutputsWanted, motion);
  EXPECT_SAME_OFFSET(OutputsWanted, albedo);
  EXPECT_SAME_OFFSET(OutputsWanted, roughness);
  EXPECT_SAME_OFFSET(OutputsWanted, metallic);
  EXPECT_SAME_OFFSET(OutputsWanted, position);
  EXPECT_SAME_OFFSET(OutputsWanted, occlusion);
  EXPECT_SAME_OFFSET(OutputsWanted, labels);
  EXPECT_SAME_OFFSET(OutputsWanted, last_world_from_node);
  EXPECT_SAME_OFFSET(OutputsWanted, last_positions);
  EXPECT_SAME_OFFSET(OutputsWanted, last_depth);
  EXPECT_SAME_OFFSET(OutputsWanted, last_clip_from_world);
  EXPECT_SAME_OFFSET(OutputsWanted, last_eye_world);
  EXPECT_SAME_OFFSET(OutputsWanted, first_deforming_vertex);
  EXPECT_SAME_OFFSET(OutputsWanted, last_look_world);
  EXPECT_SAME_OFFSET(OutputsWanted, last_world_from_ndc_x);
  EXPECT_SAME_OFFSET(OutputsWanted, last_world_from_ndc_y);
  EXPECT_SAME_OFFSET(OutputsWanted, last_world_from_ndc_origin);
  EXPECT_SAME_OFFSET(OutputsWanted, last_orthographic);
  EXPECT_SAME_OFFSET(OutputsWanted, look_world);
  EXPECT_SAME_OFFSET(OutputsWanted, orthographic);
  EXPECT_SAME_OFFSET(OutputsPush, globals);
  EXPECT_SAME_OFFSET(OutputsPush, visibility);
  EXPECT_SAME_OFFSET(OutputsPush, wanted);
  EXPECT_SAME_OFFSET(LabelPart, slot);
  EXPECT_SAME_OFFSET(LabelPart, is_overlaid);
  EXPECT_SAME_OFFSET(LabelPart, alpha_limit);
  EXPECT_SAME_OFFSET(SilhouettesWanted, globals);
  EXPECT_SAME_OFFSET(SilhouettesWanted, parts);
  EXPECT_SAME_OFFSET(SilhouettesWanted, bits);
  EXPECT_SAME_OFFSET(SilhouettesWanted, truncated);
  EXPECT_SAME_OFFSET(SilhouettesWanted, visibility);
  EXPECT_SAME_OFFSET(SilhouettesWanted, cluster_count);
  EXPECT_SAME_OFFSET(SilhouettesPush, wanted);
  EXPECT_SAME_OFFSET(LensWanted, color_in);
  EXPECT_SAME_OFFSET(LensWanted, color_out);
  EXPECT_SAME_OFFSET(LensWanted, linear_in);
  EXPECT_SAME_OFFSET(LensWanted, linear_out);
  EXPECT_SAME_OFFSET(LensWanted, depth_in);
  EXPECT_SAME_OFFSET(LensWanted, depth_out);
  EXPECT_SAME_OFFSET(LensWanted, instance_in);
  EXPECT_SAME_OFFSET(LensWanted, instance_out);
  EXPECT_SAME_OFFSET(LensWanted, semantic_in);
  EXPECT_SAME_OFFSET(LensWanted, semantic_out);
  EXPECT_SAME_OFFSET(LensWanted, normal_in);
  EXPECT_SAME_OFFSET(LensWanted, normal_out);
  EXPECT_SAME_OFFSET(LensWanted, motion_in);
  EXPECT_SAME_OFFSET(LensWanted, motion_out);
  EXPECT_SAME_OFFSET(LensWanted, albedo_in);
  EXPECT_SAME_OFFSET(LensWanted, albedo_out);
  EXPECT_SAME_OFFSET(LensWanted, roughness_in);
  EXPECT_SAME_OFFSET(LensWanted, roughness_out);
  EXPECT_SAME_OFFSET(LensWanted, metallic_in);
  EXPECT_SAME_OFFSET(LensWanted, metallic_out);
  EXPECT_SAME_OFFSET(LensWanted, position_in);
  EXPECT_SAME_OFFSET(LensWanted, position_out);
  EXPECT_SAME_OFFSET(LensWanted, occlusion_in);
  EXPECT_SAME_OFFSET(LensWanted, occlusion_out);
  EXPECT_SAME_OFFSET(LensWanted, width);
  EXPECT_SAME_OFFSET(LensWanted, height);
  EXPECT_SAME_OFFSET(LensWanted, width_in);
  EXPECT_SAME_OFFSET(LensWanted, height_in);
  EXPECT_SAME_OFFSET(LensWanted, focal);
  EXPECT_SAME_OFFSET(LensWanted, principal_point);
  EXPECT_SAME_OFFSET(LensWanted, focal_in);
  EXPECT_SAME_OFFSET(LensWanted, principal_point_in);
  EXPECT_SAME_OFFSET(LensWanted, coefficients);
  EXPECT_SAME_OFFSET(LensWanted, last_coefficient);
  EXPECT_SAME_OFFSET(LensWanted, largest_radius);
  EXPECT_SAME_OFFSET(LensWanted, fisheye);
  EXPECT_SAME_OFFSET(LensPush, wanted);
}

// shaders/common/lanes.glsl reads these records as words, by word index.
constexpr size_t words(size_t bytes) {
  return bytes / sizeof(uint32_t);
}
#define AT_WORD(structure, member, word) \
  static_assert(words(offsetof(gpu_types::structure, member)) == (word), #structure "." #member)

static_assert(words(sizeof(gpu_types::AffineRows)) == 12);
AT_WORD(AffineRows, row1, 4);
AT_WORD(AffineRows, row2, 8);
static_assert(words(sizeof(gpu_types::PartRecord)) == 4);
AT_WORD(PartRecord, primitive, 1);
AT_WORD(PartRecord, flags, 2);
AT_WORD(PartRecord, material, 3);
static_assert(words(sizeof(gpu_types::ClusterRecord)) == 16);
AT_WORD(ClusterRecord, first_vertex, 8);
AT_WORD(ClusterRecord, first_triangle, 9);
AT_WORD(ClusterRecord, vertex_count, 10);
AT_WORD(ClusterRecord, triangle_count, 11);
AT_WORD(ClusterRecord, surface_error, 14);
static_assert(words(sizeof(gpu_types::RasterView)) == 52);
AT_WORD(RasterView, clip_from_world, 0);
AT_WORD(RasterView, eye_world, 40);
AT_WORD(RasterView, width, 44);
AT_WORD(RasterView, height, 45);
AT_WORD(RasterView, first_texel, 46);
AT_WORD(RasterView, depth_m, 47);
AT_WORD(RasterView, texel_m, 48);
AT_WORD(RasterView, level_scale, 49);
static_assert(words(sizeof(gpu_types::LightPose)) == 16);
AT_WORD(LightPose, range_m, 3);
AT_WORD(LightPose, position_world, 4);
AT_WORD(LightPose, type, 7);
AT_WORD(LightPose, light_direction_world, 8);
AT_WORD(LightPose, cone_scale, 11);
AT_WORD(LightPose, cone_offset, 12);
AT_WORD(LightPose, radius_m, 13);
AT_WORD(LightPose, angular_radius_rad, 14);
AT_WORD(LightPose, sine, 15);
static_assert(words(sizeof(gpu_types::MaterialRecord)) == 56);
AT_WORD(MaterialRecord, emissive, 4);
AT_WORD(MaterialRecord, metallic, 7);
AT_WORD(MaterialRecord, roughness, 8);
AT_WORD(MaterialRecord, normal_scale, 9);
AT_WORD(MaterialRecord, occlusion_strength, 10);
AT_WORD(MaterialRecord, alpha_cutoff, 11);
AT_WORD(MaterialRecord, flags, 12);
AT_WORD(MaterialRecord, extension, 13);
AT_WORD(MaterialRecord, base_color_texture, 16);
AT_WORD(MaterialRecord, metallic_roughness_texture, 24);
AT_WORD(MaterialRecord, normal_texture, 32);
AT_WORD(MaterialRecord, occlusion_texture, 40);
AT_WORD(MaterialRecord, emissive_texture, 48);
static_assert(words(sizeof(gpu_types::TextureUse)) == 8);
AT_WORD(TextureUse, size, 1);
AT_WORD(TextureUse, uv_offset, 2);
AT_WORD(TextureUse, uv_rows, 4);

TEST_F(ShaderLayout, EveryShaderIsEmbedded) {
  EXPECT_GE(shaders::names().size(), 8u);
  for (std::string_view name : shaders::names()) {
    ASSERT_FALSE(shaders::embedded(name).empty()) << name;
    EXPECT_EQ(shaders::embedded(name)[0], 0x07230203u) << name;  // SPIR-V's magic number
  }
  EXPECT_TRUE(shaders::embedded("no such shader").empty());
}

}  // namespace
}  // namespace fire3dv
