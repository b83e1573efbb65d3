// Test of the glTF loader on public collections of valid and broken files (FIRE3DV_ASSETS, or shared/assets
// beside the source tree). Generated files always run, intact and with each byte damaged in turn.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <set>

#include "renderer/scene/gltf/gltf_extensions.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/corpus_deviations.h"
#include "tests/unit/renderer/scene/gltf/motion_file.h"

namespace fire3dv::scene {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void expect_consistent_deformation(const Scene& scene, const Node& node, const std::string& file) {
  ASSERT_LE(size_t{node.first_morph_weight} + node.morph_weight_count, scene.morph_weights.size()) << file;
  if (node.mesh == kNone) return;
  const Mesh& mesh = scene.meshes[node.mesh];
  ASSERT_EQ(node.morph_weight_count, mesh.morph_target_count) << file;
  ASSERT_TRUE(node.skin == kNone || node.skin < scene.skins.size()) << file;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const Primitive& primitive = scene.primitives[p];
    ASSERT_EQ(primitive.morph_target_count, mesh.morph_target_count) << file;
    if (node.skin == kNone) continue;
    ASSERT_LE(primitive.joint_limit, scene.skins[node.skin].joint_count) << file;
  }
}

void expect_consistent_motion(const Scene& scene, const std::string& file) {
  for (const Primitive& primitive : scene.primitives) {
    if (primitive.morph_target_count > 0) {
      const size_t deltas = size_t{primitive.morph_target_count} * primitive.vertex_count;
      ASSERT_LE(primitive.first_morph_delta + deltas, scene.morph_deltas.size()) << file;
    }
    if (primitive.first_influence == kNone) continue;
    const size_t sets = size_t{primitive.vertex_count} * primitive.influence_sets;
    ASSERT_LE(primitive.first_influence + sets, scene.influences.size()) << file;
    for (size_t i = 0; i < sets; ++i) {
      for (const uint16_t joint : scene.influences[primitive.first_influence + i].joints)
        ASSERT_LT(joint, primitive.joint_limit) << file;
    }
    ASSERT_LE(size_t{primitive.first_joint_bounds} + primitive.joint_bounds_count, scene.joint_bounds.size());
    for (uint32_t b = 0; b < primitive.joint_bounds_count; ++b)
      ASSERT_LT(scene.joint_bounds[primitive.first_joint_bounds + b].joint, primitive.joint_limit) << file;
  }
  for (const Skin& skin : scene.skins)
    ASSERT_LE(size_t{skin.first_joint} + skin.joint_count, scene.joints.size()) << file;
  for (const Joint& joint : scene.joints) ASSERT_LT(joint.node, scene.nodes.size()) << file;
  for (const Animation& animation : scene.animations)
    ASSERT_LE(size_t{animation.first_channel} + animation.channel_count, scene.channels.size()) << file;
  for (const AnimationChannel& channel : scene.channels) {
    ASSERT_LT(channel.node, scene.nodes.size()) << file;
    ASSERT_GT(channel.key_count, 0u) << file;
    ASSERT_LE(size_t{channel.first_time} + channel.key_count, scene.key_times_s.size()) << file;
    const size_t values = channel.interpolation == Interpolation::cubic_spline ? 3 : 1;
    ASSERT_LE(channel.first_value + values * channel.key_count * channel.width, scene.key_values.size())
        << file;
    if (channel.path == AnimationPath::weights) {
      ASSERT_EQ(channel.width, scene.nodes[channel.node].morph_weight_count) << file;
    }
  }
}

// Checks the invariants that later code relies on.
void expect_consistent(const Scene& scene, const std::string& file) {
  ASSERT_EQ(scene.positions.size(), scene.frames.size()) << file;
  ASSERT_EQ(scene.positions.size(), scene.uvs.size()) << file;
  ASSERT_TRUE(scene.tangents.empty() || scene.tangents.size() == scene.positions.size()) << file;
  ASSERT_TRUE(scene.extras.empty() || scene.extras.size() == scene.positions.size()) << file;
  ASSERT_FALSE(scene.materials.empty()) << file;
  for (const Primitive& primitive : scene.primitives) {
    ASSERT_LE(size_t{primitive.first_index} + primitive.index_count, scene.indices.size()) << file;
    ASSERT_LE(size_t{primitive.first_vertex} + primitive.vertex_count, scene.positions.size()) << file;
    const uint32_t corners = primitive.topology == Topology::triangles ? 3
                             : primitive.topology == Topology::lines   ? 2
                                                                       : 1;
    ASSERT_EQ(primitive.index_count % corners, 0u) << file;
    ASSERT_LT(primitive.material, scene.materials.size()) << file;
    for (uint32_t i = 0; i < primitive.index_count; ++i) {
      ASSERT_LT(scene.indices[primitive.first_index + i], primitive.vertex_count) << file;
    }
  }
  for (const Mesh& mesh : scene.meshes) {
    ASSERT_LE(size_t{mesh.first_primitive} + mesh.primitive_count, scene.primitives.size()) << file;
  }
  for (uint32_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    ASSERT_TRUE(node.parent == kNone || node.parent < i) << file;
    ASSERT_TRUE(node.mesh == kNone || node.mesh < scene.meshes.size()) << file;
    ASSERT_TRUE(node.camera == kNone || node.camera < scene.cameras.size()) << file;
    ASSERT_TRUE(node.light == kNone || node.light < scene.lights.size()) << file;
    expect_consistent_deformation(scene, node, file);
  }
  expect_consistent_motion(scene, file);
  for (const Texture& texture : scene.textures) ASSERT_LT(texture.image, scene.images.size()) << file;
  for (const Image& image : scene.images)
    ASSERT_EQ(image.rgba8.size(), size_t{image.width} * image.height * 4) << file;
  for (const Material& material : scene.materials) {
    for (const TextureRef* ref :
         {&material.base_color_texture, &material.metallic_roughness_texture, &material.normal_texture,
          &material.occlusion_texture, &material.emissive_texture, &material.specular_texture,
          &material.specular_color_texture, &material.clearcoat_texture,
          &material.clearcoat_roughness_texture, &material.clearcoat_normal_texture,
          &material.sheen_color_texture, &material.sheen_roughness_texture, &material.anisotropy_texture,
          &material.iridescence_texture, &material.iridescence_thickness_texture,
          &material.transmission_texture, &material.diffuse_transmission_texture,
          &material.diffuse_transmission_color_texture}) {
      ASSERT_TRUE(ref->texture == kNone || ref->texture < scene.textures.size()) << file;
      ASSERT_LE(ref->uv_set, 1u) << file;
    }
  }
}

test::GltfBuilder rich_file() {
  test::GltfBuilder builder;
  const size_t positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  const size_t normals = builder.add_data<int8_t>({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0},
                                                  "VEC3", test::kByte, 4, true);
  builder.root["bufferViews"].back()["byteStride"] = 4;
  const size_t uv = builder.add_data<float>({0, 0, 1, 0, 0, 1, 1, 1}, "VEC2", test::kFloat, 2);
  const size_t material = builder.add_textured_material(test::png(2, 2, 0xff8040ff));
  builder.root["materials"][material]["normalTexture"] = {{"index", 0}};
  const size_t mesh =
      builder.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}}},
                        {"indices", builder.add_indices({0, 1, 2, 3})},
                        {"mode", 5},
                        {"material", material}});
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  builder.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  const size_t node = builder.add_node("body", {{"mesh", mesh}, {"rotation", {0, 0, 0, 1}}});
  builder.add_child(node, "eye", {{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  return builder;
}

void damage_every_byte(const std::vector<std::byte>& good) {
  const test::ScratchFolder folder;
  {
    const auto scene = load_gltf(folder.write("good.glb", good));
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    expect_consistent(*scene, "good.glb");
  }
  size_t still_loads = 0, refused = 0;
  for (size_t i = 0; i < good.size(); ++i) {
    for (const int flip : {0x01, 0x10, 0x80}) {
      std::vector<std::byte> bytes = good;
      bytes[i] ^= static_cast<std::byte>(flip);
      const auto scene = load_gltf(folder.write("damaged.glb", bytes));
      if (scene) expect_consistent(*scene, "damaged at byte " + std::to_string(i));
      ++(scene ? still_loads : refused);
    }
  }
  std::cout << "damaged files: " << still_loads << " load, " << refused << " are refused\n";
  EXPECT_GT(refused, good.size() / 4);
}

TEST(SceneCorpus, DamageInEveryByte) {
  damage_every_byte(rich_file().glb());
}

TEST(SceneCorpus, MovingFileSurvivesDamage) {
  damage_every_byte(test::motion_file().glb());
}

const std::set<std::string>& supported() {
  static const std::set<std::string> names{"KHR_lights_punctual",
                                           "KHR_materials_unlit",
                                           "KHR_materials_emissive_strength",
                                           "KHR_materials_ior",
                                           "KHR_materials_specular",
                                           "KHR_materials_clearcoat",
                                           "KHR_materials_sheen",
                                           "KHR_materials_transmission",
                                           "KHR_materials_volume",
                                           "KHR_materials_dispersion",
                                           "KHR_materials_diffuse_transmission",
                                           "KHR_texture_transform",
                                           "KHR_mesh_quantization",
                                           "EXT_mesh_gpu_instancing",
                                           "EXT_meshopt_compression",
                                           "EXT_texture_webp",
                                           "KHR_texture_basisu",
                                           "KHR_node_visibility",
                                           "KHR_materials_pbrSpecularGlossiness",
                                           "KHR_materials_variants",
                                           "KHR_materials_anisotropy",
                                           "KHR_materials_iridescence"};
  return names;
}

// Returns the first unsupported name that may change geometry or data; empty if there is none.
std::string first_unsupported(const json& names) {
  for (const json& name : names) {
    const auto text = name.get<std::string>();
    if (!supported().contains(text) && effect_of_omission(text).empty()) return text;
  }
  return {};
}

json parsed(const fs::path& file) {
  std::ifstream bytes(file);
  return bytes ? json::parse(bytes) : json::object();
}

// Uses the expected report beside the file, else the validator's result from the collection's creation.
bool is_faulty(const fs::path& file, const json& result) {
  const json report = parsed(file.string() + ".report.json");
  if (report.contains("issues")) return report["issues"]["numErrors"] != 0;
  return result.at("e") != 0;
}

template <size_t N>
const Deviation* find(const std::array<Deviation, N>& table, const std::string& file) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Deviation& d) { return d.file == file; });
  return found == table.end() ? nullptr : &*found;
}

struct Counts {
  size_t files = 0, loaded = 0, refused = 0, valid = 0, unsupported = 0, loaded_though_faulty = 0;
};

void expect_as_reported(const std::string& file, const json& result, bool faulty, const Result<Scene>& scene,
                        Counts& counts) {
  const std::string missing = first_unsupported(result.value("req", json::array()));
  if (!missing.empty()) {
    ++counts.unsupported;
    ASSERT_FALSE(scene.ok()) << file << " requires " << missing;
    const bool named = scene.error().message.find(missing) != std::string::npos;
    EXPECT_TRUE(named || faulty) << scene.error().message;
    return;
  }
  if (!faulty) {
    ++counts.valid;
    const bool refused = find(kRefusedThoughValid, file) != nullptr;
    EXPECT_EQ(scene.ok(), !refused) << file << " is valid: " << (scene ? "" : scene.error().message);
  } else {
    const Deviation* deviation = find(kLoadedThoughFaulty, file);
    counts.loaded_though_faulty += scene.ok();
    EXPECT_EQ(scene.ok(), deviation != nullptr)
        << file << " is faulty: " << result["codes"] << (scene ? "" : scene.error().message);
  }
  if (!scene) return;
  for (const json& name : result.value("ext", json::array())) {
    const bool warned =
        std::any_of(scene->warnings.begin(), scene->warnings.end(), [&](const std::string& warning) {
          return warning.find(name.get<std::string>()) != std::string::npos;
        });
    EXPECT_TRUE(warned || supported().contains(name.get<std::string>())) << file << " uses " << name;
  }
}

TEST(SceneCorpus, CollectionLoadsAsItsReportsSay) {
  FIRE3DV_NEEDS_ASSETS();
  const fs::path root = test::asset_collection_folder();
  const json results = parsed(root / "VALIDATION.json").at("files");
  Counts counts;
  std::set<std::string> seen;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension().string();
    if (!entry.is_regular_file() || (extension != ".gltf" && extension != ".glb")) continue;
    const std::string file = fs::relative(entry.path(), root).generic_string();
    seen.insert(file);
    const auto scene = load_gltf(entry.path());
    ++counts.files;
    ++(scene ? counts.loaded : counts.refused);
    if (scene) {
      expect_consistent(*scene, file);
    } else {
      EXPECT_NE(scene.error().message.find(entry.path().filename().string()), std::string::npos)
          << scene.error().message;
    }
    ASSERT_TRUE(results.contains(file)) << file << " has no report";
    expect_as_reported(file, results[file], is_faulty(entry.path(), results[file]), scene, counts);
  }
  for (const Deviation& deviation : kLoadedThoughFaulty)
    EXPECT_TRUE(seen.contains(deviation.file)) << deviation.file;
  for (const Deviation& deviation : kRefusedThoughValid)
    EXPECT_TRUE(seen.contains(deviation.file)) << deviation.file;
  std::cout << counts.files << " files: " << counts.loaded << " load, " << counts.refused << " are refused; "
            << counts.valid << " are valid, " << counts.unsupported << " require what is not supported, "
            << counts.loaded_though_faulty << " are faulty but load\n";
  EXPECT_GT(counts.files, 0u);
}

}  // namespace
}  // namespace fire3dv::scene
