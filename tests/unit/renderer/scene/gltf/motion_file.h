// Small glTF file of all animated features: a triangle with two joints, two morph targets, and an animation
// of each path.
#pragma once

#include <gtest/gtest.h>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::test {

// accessor indices of the file, in order of creation
enum MotionAccessor : size_t {
  kPositions,
  kNormals,
  kJoints,
  kWeights,
  kTargetA,
  kTargetB,
  kTargetBNormals,
  kInverseBind,
  kTimes,
  kTranslations,
  kRotations,
  kMorphWeights
};

// nodes: 0 "figure" (mesh, skin), 1 "root" joint, 2 "tip" joint below it, one metre up.
inline GltfBuilder motion_file() {
  using nlohmann::json;
  GltfBuilder b;
  b.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  b.add_data<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", kFloat, 3);
  b.add_data<uint8_t>({0, 0, 0, 0, 0, 1, 0, 0, 1, 9, 0, 0}, "VEC4", kUnsignedByte, 4);
  b.add_data<uint8_t>({255, 0, 0, 0, 51, 204, 0, 0, 200, 0, 0, 0}, "VEC4", kUnsignedByte, 4, true);
  b.add_data<float>({0, 0, 2, 0, 0, 2, 0, 0, 2}, "VEC3", kFloat, 3);
  b.add_data<float>({0, 0, 0, 4, 0, 0, 0, 0, 0}, "VEC3", kFloat, 3);
  b.add_data<float>({0, 0, 0, 0.5f, 0, 0, 0, 0, 0}, "VEC3", kFloat, 3);
  // Inverse bind matrix of "tip": one metre down.
  b.add_data<float>(
      {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
      "MAT4", kFloat, 16);
  b.add_data<float>({0, 1, 4}, "SCALAR", kFloat, 1);
  b.add_data<float>({0, 1, 0, 0, 2, 0, 0, 6, 0}, "VEC3", kFloat, 3);
  b.add_data<int16_t>({0, 0, 0, 32767, 0, 0, 32767, 0, 0, 0, 0, 32767}, "VEC4", kShort, 4, true);
  b.add_data<float>({0, 0, 1, 0.5f, 0, 0}, "SCALAR", kFloat, 1);
  const size_t mesh = b.add_mesh(
      {{"attributes",
        {{"POSITION", kPositions}, {"NORMAL", kNormals}, {"JOINTS_0", kJoints}, {"WEIGHTS_0", kWeights}}},
       {"targets", {{{"POSITION", kTargetA}}, {{"POSITION", kTargetB}, {"NORMAL", kTargetBNormals}}}}});
  b.root["meshes"][mesh]["weights"] = {0.25, 0};
  b.root["skins"] = {{{"name", "bones"}, {"joints", {1, 2}}, {"inverseBindMatrices", kInverseBind}}};
  b.add_node("figure", {{"mesh", mesh}, {"skin", 0}, {"translation", {100, 0, 0}}});
  const size_t root = b.add_node("root");
  b.add_child(root, "tip", {{"translation", {0, 1, 0}}});
  b.root["animations"] = {{{"name", "wave"},
                           {"samplers",
                            {{{"input", kTimes}, {"output", kTranslations}},
                             {{"input", kTimes}, {"output", kRotations}, {"interpolation", "STEP"}},
                             {{"input", kTimes}, {"output", kMorphWeights}}}},
                           {"channels",
                            {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "translation"}}}},
                             {{"sampler", 1}, {"target", {{"node", 1}, {"path", "rotation"}}}},
                             {{"sampler", 2}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  return b;
}

inline scene::Scene loaded_scene(const GltfBuilder& builder) {
  const ScratchFolder folder;
  auto loaded = scene::load_gltf(folder.write("scene.glb", builder.glb()));
  EXPECT_TRUE(loaded.ok()) << loaded.error().message;
  return loaded ? std::move(*loaded) : scene::Scene{};
}

}  // namespace fire3dv::test
