// Test of invalid skins, morph targets and animations: refused with an error message, or dropped with a
// warning.
#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/renderer/scene/gltf/motion_file.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

struct Fault {
  const char* name;
  std::function<void(GltfBuilder&)> plant;
  const char* expected;  // part of the message
};

json& attributes(GltfBuilder& b) {
  return b.root["meshes"][0]["primitives"][0]["attributes"];
}
json& targets(GltfBuilder& b) {
  return b.root["meshes"][0]["primitives"][0]["targets"];
}
json& channel(GltfBuilder& b) {
  return b.root["animations"][0]["channels"][0];
}
json& sampler(GltfBuilder& b) {
  return b.root["animations"][0]["samplers"][0];
}
size_t floats(GltfBuilder& b, const std::vector<float>& values, const char* type, size_t components) {
  return b.add_data<float>(values, type, test::kFloat, components);
}

const std::vector<Fault>& refused() {
  static const std::vector<Fault> list{
      {"skin of a missing joint",
       [](auto& b) {
         b.root["skins"][0]["joints"] = {1, 7};
       },
       "skins[0].joints refers to nodes[7]"},
      {"skin without joints", [](auto& b) { b.root["skins"][0]["joints"] = json::array(); },
       "skins[0] has no joints"},
      {"joints of a wrong type", [](auto& b) { b.root["skins"][0]["joints"] = {"a"}; }, "skins[0]: joints"},
      {"too many joints without matrices",
       [](auto& b) {
         b.root["skins"][0].erase("inverseBindMatrices");
         b.root["skins"][0]["joints"] = std::vector<int>((1 << 22) + 1, 1);
       },
       "skins[0]: the file holds more than 4194304 joints"},
      {"missing matrices", [](auto& b) { b.root["skins"][0]["inverseBindMatrices"] = 99; }, "accessors[99]"},
      {"matrices of another shape",
       [](auto& b) { b.root["skins"][0]["inverseBindMatrices"] = test::kPositions; },
       "components an element"},
      {"too few matrices", [](auto& b) { b.root["accessors"][test::kInverseBind]["count"] = 1; },
       "holds 1 matrices for 2 joints"},
      {"a matrix that is not affine",
       [](auto& b) {
         std::vector<float> m(32, 0.0f);
         b.root["skins"][0]["inverseBindMatrices"] = floats(b, m, "MAT4", 16);
       },
       "matrix 0 is not affine"},
      {"node of a missing skin", [](auto& b) { b.root["nodes"][0]["skin"] = 3; },
       "nodes[0] refers to skins[3]"},
      {"joint beyond the skin", [](auto& b) { b.root["skins"][0]["joints"] = {1}; },
       "refers to joint 1, but skins[0] has 1"},
      {"joints without weights", [](auto& b) { attributes(b).erase("WEIGHTS_0"); },
       "has JOINTS_0, but no WEIGHTS_0"},
      {"weights without joints", [](auto& b) { attributes(b).erase("JOINTS_0"); },
       "has WEIGHTS_0, but no JOINTS_0"},
      {"second set alone",
       [](auto& b) {
         attributes(b)["JOINTS_1"] = attributes(b)["JOINTS_0"];
         attributes(b)["WEIGHTS_1"] = attributes(b)["WEIGHTS_0"];
         attributes(b).erase("JOINTS_0");
         attributes(b).erase("WEIGHTS_0");
       },
       "has JOINTS_1, but no JOINTS_0"},
      {"fewer joints than vertices", [](auto& b) { b.root["accessors"][test::kJoints]["count"] = 2; },
       "JOINTS_0 has 2 elements, but POSITION has 3"},
      {"joints that are fractions", [](auto& b) { b.root["accessors"][test::kJoints]["normalized"] = true; },
       "not the index of a joint"},
      {"negative joints",
       [](auto& b) { attributes(b)["JOINTS_0"] = floats(b, std::vector<float>(12, -1.0f), "VEC4", 4); },
       "not the index of a joint"},
      {"weights that are no numbers",
       [](auto& b) { attributes(b)["WEIGHTS_0"] = floats(b, std::vector<float>(12, NAN), "VEC4", 4); },
       "not a finite number"},
      {"morph target of a missing accessor", [](auto& b) { targets(b)[0]["POSITION"] = 50; },
       "accessors[50]"},
      {"morph target of another length", [](auto& b) { b.root["accessors"][test::kTargetA]["count"] = 2; },
       "targets[0].POSITION has 2 elements"},
      {"morph target that is no object", [](auto& b) { targets(b)[0] = 5; }, "targets is not of the type"},
      {"unequal morph targets",
       [](auto& b) {
         json& primitives = b.root["meshes"][0]["primitives"];
         primitives.push_back(primitives[0]);
         primitives[1]["targets"].erase(1);
       },
       "primitives[1] has 1 morph targets"},
      {"weights of another number",
       [](auto& b) {
         b.root["meshes"][0]["weights"] = {1, 2, 3};
       },
       "meshes[0].weights holds 3 numbers for 2 morph targets"},
      {"node weights of another number", [](auto& b) { b.root["nodes"][0]["weights"] = {1}; },
       "nodes[0].weights holds 1 numbers for 2"},
      {"channel without a sampler", [](auto& b) { channel(b).erase("sampler"); },
       "channels[0]: sampler is missing"},
      {"channel without a target", [](auto& b) { channel(b).erase("target"); },
       "channels[0]: target is missing"},
      {"channel without a path", [](auto& b) { channel(b)["target"].erase("path"); }, "path is missing"},
      {"channel of a missing sampler", [](auto& b) { channel(b)["sampler"] = 8; }, "refers to samplers[8]"},
      {"channel of a missing node", [](auto& b) { channel(b)["target"]["node"] = 8; }, "refers to nodes[8]"},
      {"sampler without input", [](auto& b) { sampler(b).erase("input"); }, "samplers[0]: input is missing"},
      {"sampler of a missing accessor", [](auto& b) { sampler(b)["output"] = 80; }, "accessors[80]"},
      {"unknown interpolation", [](auto& b) { sampler(b)["interpolation"] = "BOUNCE"; },
       "interpolation is none of"},
      {"times that are no scalars", [](auto& b) { sampler(b)["input"] = test::kPositions; },
       "components an element"},
      {"times that fall",
       [](auto& b) {
         sampler(b)["input"] = floats(b, {0, 2, 1}, "SCALAR", 1);
       },
       "key 2 is not later than the one before"},
      {"times that stand",
       [](auto& b) {
         sampler(b)["input"] = floats(b, {0, 1, 1}, "SCALAR", 1);
       },
       "key 2 is not later"},
      {"negative times",
       [](auto& b) {
         sampler(b)["input"] = floats(b, {-1, 0, 1}, "SCALAR", 1);
       },
       "key 0 lies before time 0"},
      {"times that are no numbers",
       [](auto& b) {
         sampler(b)["input"] = floats(b, {0, NAN, 1}, "SCALAR", 1);
       },
       "not a finite number"},
      {"too few values", [](auto& b) { b.root["accessors"][test::kTranslations]["count"] = 2; },
       "holds 2 elements, but its 3 keys need 3"},
      {"splines without tangents", [](auto& b) { sampler(b)["interpolation"] = "CUBICSPLINE"; }, "need 9"},
      {"values that are no vectors", [](auto& b) { channel(b)["target"]["path"] = "rotation"; },
       "components an element"},
      {"rotation of no length",
       [](auto& b) {
         channel(b)["target"]["path"] = "rotation";
         sampler(b)["output"] = floats(b, {0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1}, "VEC4", 4);
       },
       "holds no rotation at element 1"},
  };
  return list;
}

TEST(SceneMotionRefuse, FaultsHaveSentences) {
  for (const Fault& fault : refused()) {
    GltfBuilder builder = test::motion_file();
    fault.plant(builder);
    const test::ScratchFolder folder;
    const auto scene = load_gltf(folder.write("broken.glb", builder.glb()));
    ASSERT_FALSE(scene.ok()) << fault.name;
    EXPECT_NE(scene.error().message.find(fault.expected), std::string::npos)
        << fault.name << ": " << scene.error().message;
    EXPECT_NE(scene.error().message.find("broken.glb"), std::string::npos) << scene.error().message;
  }
}

// Faults that affect nothing else: the object is dropped with a warning.
const std::vector<Fault>& left_out() {
  static const std::vector<Fault> list{
      {"channel without a node", [](auto& b) { channel(b)["target"].erase("node"); },
       "channels[0] moves no node"},
      {"unknown path", [](auto& b) { channel(b)["target"]["path"] = "shear"; }, "has a path other than"},
      {"weights of a node without targets",
       [](auto& b) { b.root["animations"][0]["channels"][2]["target"]["node"] = 1; },
       "which has no morph targets"},
      {"part of a node given by a matrix",
       [](auto& b) {
         b.root["nodes"][2].erase("translation");
         b.root["nodes"][2]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1};
       },
       "which is given by a matrix"},
  };
  return list;
}

TEST(SceneMotionRefuse, UnplayableChannelsAreReported) {
  for (const Fault& fault : left_out()) {
    GltfBuilder builder = test::motion_file();
    fault.plant(builder);
    const Scene scene = test::loaded_scene(builder);
    ASSERT_EQ(scene.warnings.size(), 1u) << fault.name;
    EXPECT_NE(scene.warnings[0].find(fault.expected), std::string::npos) << scene.warnings[0];
    EXPECT_EQ(scene.animations.at(0).channel_count, 2u) << fault.name;
  }
}

TEST(SceneMotionRefuse, IdleSkinIsReported) {
  GltfBuilder builder = test::motion_file();
  attributes(builder).erase("JOINTS_0");
  attributes(builder).erase("WEIGHTS_0");
  builder.root["nodes"][1]["skin"] = 0;
  const Scene scene = test::loaded_scene(builder);
  ASSERT_EQ(scene.warnings.size(), 2u);
  EXPECT_NE(scene.warnings[0].find("its mesh has no JOINTS_0"), std::string::npos);
  EXPECT_NE(scene.warnings[1].find("nodes[1] has a skin, but no mesh"), std::string::npos);
  EXPECT_EQ(scene.nodes[0].skin, kNone);
}

TEST(SceneMotionRefuse, SharedBytesBoundMemory) {
  GltfBuilder builder = test::motion_file();
  // 5,000 targets of 100,000 vertices each, without data.
  for (const size_t accessor :
       {test::kPositions, test::kNormals, test::kJoints, test::kWeights, test::kTargetA}) {
    builder.root["accessors"][accessor].erase("bufferView");
    builder.root["accessors"][accessor]["count"] = 99999;
  }
  targets(builder) = json(5000, json{{"POSITION", test::kTargetA}});
  builder.root["meshes"][0].erase("weights");
  const test::ScratchFolder folder;
  const auto scene = load_gltf(folder.write("large.glb", builder.glb()));
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("the morph targets of the file hold more than"), std::string::npos)
      << scene.error().message;
}

// Each node has its own copy of the deformed vertices.
TEST(SceneMotionRefuse, ManyNodesBoundMemory) {
  GltfBuilder builder = test::motion_file();
  for (const size_t accessor :
       {test::kPositions, test::kNormals, test::kJoints, test::kWeights, test::kTargetA}) {
    builder.root["accessors"][accessor].erase("bufferView");
    builder.root["accessors"][accessor]["count"] = 99999;
  }
  targets(builder) = json(1, json{{"POSITION", test::kTargetA}});
  builder.root["meshes"][0].erase("weights");
  builder.root.erase("animations");
  const test::ScratchFolder folder;
  EXPECT_TRUE(load_gltf(folder.write("one.glb", builder.glb())).ok());
  for (int i = 0; i < 1000; ++i) builder.add_node("another", {{"mesh", 0}});
  const auto scene = load_gltf(folder.write("many.glb", builder.glb()));
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("the nodes with skins or morph targets have more than"),
            std::string::npos)
      << scene.error().message;
}

}  // namespace
}  // namespace fire3dv::scene
