// Test of inconsistent glTF files: each is refused with a message that names the file, the object and the
// fault.
#include <gtest/gtest.h>

#include <functional>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

std::string refusal(std::span<const std::byte> file, const LoadLimits& limits = {}) {
  const test::ScratchFolder folder;
  const auto scene = load_gltf(folder.write("broken.glb", file), limits);
  if (scene) return "loaded";
  EXPECT_NE(scene.error().message.find("broken.glb"), std::string::npos) << scene.error().message;
  EXPECT_EQ(scene.error().message.find('\n'), std::string::npos) << scene.error().message;
  return scene.error().message;
}

std::string refusal_of_text(std::string_view text, const LoadLimits& limits = {}) {
  return refusal(std::as_bytes(std::span(text)), limits);
}

struct Fault {
  const char* name;
  std::function<void(GltfBuilder&)> plant;  // applied to a valid file
  const char* expected;                     // part of the message
};

json& primitive(GltfBuilder& builder) {
  return builder.root["meshes"][0]["primitives"][0];
}

json sparse(GltfBuilder& builder, const std::vector<uint8_t>& indices, size_t values) {
  const size_t index_view = builder.add_view(std::as_bytes(std::span(indices)));
  const std::vector<float> data(values * 3, 1.0f);
  const size_t value_view = builder.add_view(std::as_bytes(std::span(data)));
  return {{"count", indices.size()},
          {"indices", {{"bufferView", index_view}, {"componentType", 5121}}},
          {"values", {{"bufferView", value_view}}}};
}

const std::vector<Fault>& faults() {
  static const std::vector<Fault> list{
      // Accessors and buffers; accessors[0] are the positions, accessors[1] the indices.
      {"count of zero", [](auto& b) { b.root["accessors"][0]["count"] = 0; },
       "accessors[0] has a count of 0"},
      {"count beyond the view", [](auto& b) { b.root["accessors"][0]["count"] = 4; },
       "reaches beyond the end of bufferViews[0]"},
      {"count times stride overflows", [](auto& b) { b.root["accessors"][0]["count"] = 1ull << 53; },
       "accessors[0] has 9007199254740992 elements"},
      {"count in int range but not in memory", [](auto& b) { b.root["accessors"][0]["count"] = 1u << 31; },
       "reaches beyond"},
      {"huge zero-filled accessor",
       [](auto& b) {
         b.root["accessors"][0] = {{"count", 1u << 31}, {"type", "VEC3"}, {"componentType", 5126}};
       },
       "accessors[0] has no bufferView"},
      {"negative count", [](auto& b) { b.root["accessors"][0]["count"] = -1; }, "accessors[0]: count"},
      {"offset beyond the view", [](auto& b) { b.root["accessors"][0]["byteOffset"] = 1ull << 52; },
       "reaches beyond"},
      {"negative offset", [](auto& b) { b.root["accessors"][0]["byteOffset"] = -4; },
       "accessors[0]: byteOffset"},
      {"stride smaller than an element", [](auto& b) { b.root["bufferViews"][0]["byteStride"] = 8; },
       "byteStride of 8"},
      {"stride that is no multiple of 4", [](auto& b) { b.root["bufferViews"][0]["byteStride"] = 13; },
       "byteStride"},
      {"unknown component type", [](auto& b) { b.root["accessors"][0]["componentType"] = 5130; },
       "accessors[0] has the unknown componentType 5130"},
      {"unknown element type", [](auto& b) { b.root["accessors"][0]["type"] = "VEC5"; }, "VEC5"},
      {"view beyond the buffer", [](auto& b) { b.root["bufferViews"][0]["byteLength"] = 1000; },
       "bufferViews[0] reaches"},
      {"view offset wraps", [](auto& b) { b.root["bufferViews"][0]["byteOffset"] = (1ull << 53) - 4; },
       "bufferViews[0] reaches"},
      {"view of a missing buffer", [](auto& b) { b.root["bufferViews"][0]["buffer"] = 3; }, "buffers[3]"},
      {"buffer longer than its bytes",
       [](auto& b) {
         b.root["buffers"] = {{{"byteLength", 5000}}};
       },
       "buffers[0]: byteLength is 5000"},
      {"accessor of a missing view", [](auto& b) { b.root["accessors"][0]["bufferView"] = 9; },
       "bufferViews[9]"},
      {"not a number",
       [](auto& b) {
         const uint32_t nan = 0x7fc00000;
         std::memcpy(b.bin.data(), &nan, 4);
       },
       "not a finite number"},
      // Sparse accessors.
      {"sparse index out of range",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {1, 3}, 2);
       },
       "accessors[0].sparse.indices holds 3"},
      {"sparse indices out of order",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {2, 1}, 2);
       },
       "rising order"},
      {"sparse index twice",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {1, 1}, 2);
       },
       "rising order"},
      {"sparse count above count",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {0, 1, 2, 3}, 4);
       },
       "sparse has a count of 4"},
      {"sparse count of zero",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {0}, 1);
         b.root["accessors"][0]["sparse"]["count"] = 0;
       },
       "sparse has a count of 0"},
      {"sparse values too short",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {0, 1}, 1);
       },
       "sparse.values"},
      {"sparse indices too short",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {0, 1}, 3);
         b.root["accessors"][0]["sparse"]["count"] = 3;
       },
       "sparse.indices"},
      {"sparse count overflows",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {0}, 1);
         b.root["accessors"][0]["sparse"]["count"] = 1ull << 32;
       },
       "accessors[0].sparse: count"},
      {"sparse offset overflows",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {0}, 1);
         b.root["accessors"][0]["sparse"]["values"]["byteOffset"] = INT32_MAX;
       },
       "sparse.values"},
      {"sparse indices of floats",
       [](auto& b) {
         b.root["accessors"][0]["sparse"] = sparse(b, {0}, 1);
         b.root["accessors"][0]["sparse"]["indices"]["componentType"] = 5126;
       },
       "not for indices"},
      // Meshes.
      {"index beyond the vertices", [](auto& b) { b.root["accessors"][0]["count"] = 2; },
       "holds the index 2, but there are 2 vertices"},
      {"signed indices", [](auto& b) { b.root["accessors"][1]["componentType"] = 5122; }, "not for indices"},
      {"missing attributes", [](auto& b) { primitive(b).erase("attributes"); },
       "meshes[0].primitives[0]: attributes is missing"},
      {"missing primitives", [](auto& b) { b.root["meshes"][0].erase("primitives"); },
       "meshes[0] has no primitives"},
      {"attribute counts differ",
       [](auto& b) {
         primitive(b)["attributes"]["NORMAL"] = b.add_positions({0, 0, 1, 0, 0, 1});
       },
       "NORMAL has 2 elements"},
      {"positions of two components", [](auto& b) { b.root["accessors"][0]["type"] = "VEC2"; },
       "2 components"},
      {"positions of a missing accessor", [](auto& b) { primitive(b)["attributes"]["POSITION"] = 7; },
       "meshes[0].primitives[0].POSITION refers to accessors[7]"},
      {"indices of a missing accessor", [](auto& b) { primitive(b)["indices"] = 7; },
       "meshes[0].primitives[0].indices refers to accessors[7]"},
      {"missing material", [](auto& b) { primitive(b)["material"] = 0; }, "materials[0]"},
      {"unknown mode", [](auto& b) { primitive(b)["mode"] = 7; }, "unknown mode 7"},
      // Nodes.
      {"missing mesh", [](auto& b) { b.root["nodes"][0]["mesh"] = 5; }, "nodes[0] refers to meshes[5]"},
      {"missing camera", [](auto& b) { b.root["nodes"][0]["camera"] = 0; }, "cameras[0]"},
      {"missing light", [](auto& b) { b.root["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 2; },
       "lights[2]"},
      {"missing child", [](auto& b) { b.root["nodes"][0]["children"] = {4}; }, "nodes[4]"},
      {"missing root", [](auto& b) { b.root["scenes"][0]["nodes"] = {4}; }, "nodes[4]"},
      {"missing scene", [](auto& b) { b.root["scene"] = 4; }, "scenes[4]"},
      {"index too large for an int", [](auto& b) { b.root["nodes"][0]["mesh"] = 1ull << 32; },
       "nodes[0]: mesh"},
      {"index that is a string", [](auto& b) { b.root["nodes"][0]["mesh"] = "0"; }, "nodes[0]: mesh"},
      {"fractional index", [](auto& b) { b.root["nodes"][0]["mesh"] = 0.5; }, "nodes[0]: mesh"},
      {"node that is its own child", [](auto& b) { b.root["nodes"][0]["children"] = {0}; },
       "nodes[0] is its own ancestor"},
      {"cycle of two",
       [](auto& b) {
         const size_t child = b.add_child(0, "child");
         b.root["nodes"][child]["children"] = {0};
       },
       "is its own ancestor"},
      {"cycle outside the scene",
       [](auto& b) {
         b.root["nodes"].push_back({{"children", {2}}});
         b.root["nodes"].push_back({{"children", {1}}});
       },
       "is its own ancestor"},
      {"two parents",
       [](auto& b) {
         const size_t child = b.add_child(0, "child");
         b.add_node("other", {{"children", {child}}});
       },
       "nodes[1] is a child of nodes[0] and of nodes[2]"},
      {"matrix of 15 numbers", [](auto& b) { b.root["nodes"][0]["matrix"] = std::vector<int>(15, 1); },
       "nodes[0].matrix holds 15"},
      {"matrix of 17 numbers", [](auto& b) { b.root["nodes"][0]["matrix"] = std::vector<int>(17, 1); },
       "nodes[0].matrix holds 17"},
      {"matrix of strings", [](auto& b) { b.root["nodes"][0]["matrix"] = std::vector<std::string>(16, "1"); },
       "nodes[0]: matrix"},
      {"projective matrix", [](auto& b) { b.root["nodes"][0]["matrix"] = std::vector<int>(16, 1); },
       "not affine"},
      {"rotation of three numbers",
       [](auto& b) {
         b.root["nodes"][0]["rotation"] = {0, 0, 1};
       },
       "nodes[0].rotation holds 3"},
      {"rotation of length zero",
       [](auto& b) {
         b.root["nodes"][0]["rotation"] = {0, 0, 0, 0};
       },
       "no rotation"},
      // Materials, textures, images.
      {"missing texture",
       [](auto& b) {
         b.root["materials"] = {{{"normalTexture", {{"index", 1}}}}};
       },
       "materials[0].normalTexture refers to textures[1]"},
      {"missing image",
       [](auto& b) {
         b.root["textures"] = {{{"source", 3}}};
       },
       "textures[0] refers to images[3]"},
      {"missing sampler",
       [](auto& b) {
         b.root["textures"] = {{{"sampler", 3}}};
       },
       "textures[0] refers to samplers[3]"},
      {"base colour of three numbers",
       [](auto& b) {
         b.root["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1}}}}}};
       },
       "baseColorFactor"},
      {"unknown alpha mode",
       [](auto& b) {
         b.root["materials"] = {{{"alphaMode", "HALF"}}};
       },
       "HALF"},
      {"unknown wrap mode",
       [](auto& b) {
         b.add_textured_material(test::png(1, 1, 0));
         b.root["samplers"] = {{{"wrapS", 1}}};
         b.root["textures"][0]["sampler"] = 0;
       },
       "samplers[0] has the unknown wrap mode 1"},
      // Lights and cameras.
      {"cone angles reversed",
       [](auto& b) {
         b.root["extensions"]["KHR_lights_punctual"]["lights"] = {
             {{"type", "spot"}, {"spot", {{"innerConeAngle", 1}, {"outerConeAngle", 0.5}}}}};
       },
       "lights[0].spot"},
      {"camera without a field of view",
       [](auto& b) {
         b.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 1}}}}};
       },
       "cameras[0].perspective"},
      // The file.
      {"version 1", [](auto& b) { b.root["asset"]["version"] = "1.0"; }, "only glTF 2.0"},
      {"no asset", [](auto& b) { b.root.erase("asset"); }, "asset is missing"},
      {"required extension", [](auto& b) { b.root["extensionsRequired"] = {"KHR_gaussian_splatting"}; },
       "KHR_gaussian_splatting"},
      {"nodes that are no array",
       [](auto& b) {
         b.root["nodes"] = {{"0", json::object()}};
       },
       "nodes is not an array"},
      {"nodes that are no objects", [](auto& b) { b.root["nodes"] = {1}; },
       "nodes is not an array of objects"},
  };
  return list;
}

TEST(SceneRefuse, FileWithoutFaultLoads) {
  EXPECT_EQ(refusal(test::triangle_file().glb()), "loaded");
}

TEST(SceneRefuse, EachFaultByName) {
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(fault.name);
    GltfBuilder builder = test::triangle_file();
    fault.plant(builder);
    const std::string message = refusal(builder.glb());
    EXPECT_NE(message.find(fault.expected), std::string::npos) << message;
  }
}

TEST(SceneRefuse, DeepJson) {
  const std::string deep = R"({"asset":{"version":"2.0"},"extras":)" + std::string(2'000'000, '[');
  EXPECT_NE(refusal_of_text(deep).find("nested deeper than 64"), std::string::npos);
  const std::string in_string =
      R"({"asset":{"version":"2.0","generator":")" + std::string(100, '[') + R"(\"["}})";
  EXPECT_EQ(refusal_of_text(in_string), "loaded");
}

TEST(SceneRefuse, TextThatIsNoGltf) {
  for (const char* text : {"", "{", "[]", "null", "{\"asset\":1}", "glT", "glTF", "\xff\xfe",
                           "{\"asset\":{\"version\":\"2.0\"}} x"}) {
    EXPECT_NE(refusal_of_text(text), "loaded") << text;
  }
}

// Length fields of a GLB: of the file at 8, of the JSON chunk at 12.
TEST(SceneRefuse, GlbLengths) {
  const std::vector<std::byte> good = test::triangle_file().glb();
  const auto with_word = [&](size_t offset, uint32_t word) {
    std::vector<std::byte> bytes = good;
    std::memcpy(bytes.data() + offset, &word, sizeof word);
    return bytes;
  };
  const auto size = static_cast<uint32_t>(good.size());
  EXPECT_NE(refusal(with_word(4, 1)).find("version 1"), std::string::npos);
  EXPECT_NE(refusal(with_word(8, size + 1)).find("header states"), std::string::npos);
  EXPECT_NE(refusal(with_word(8, 0)).find("header states"), std::string::npos);
  EXPECT_NE(refusal(with_word(8, UINT32_MAX)).find("header states"), std::string::npos);
  EXPECT_NE(refusal(with_word(8, size - 6)).find("chunk 1"), std::string::npos);
  for (const uint32_t length : {size, UINT32_MAX, UINT32_MAX - 7, uint32_t{0}, uint32_t{4}}) {
    EXPECT_NE(refusal(with_word(12, length)), "loaded") << length;
  }
  EXPECT_NE(refusal(with_word(16, 0)).find("chunk 0 is not the JSON"), std::string::npos);
}

TEST(SceneRefuse, EveryTruncationOfAGlb) {
  const std::vector<std::byte> good = test::triangle_file().glb();
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_NE(refusal(std::span(good).first(size)), "loaded") << size;
  }
}

TEST(SceneRefuse, LimitsAreEnforced) {
  LoadLimits limits;
  limits.max_file_bytes = 100;
  EXPECT_NE(refusal(test::triangle_file().glb(), limits).find("at most 100"), std::string::npos);
  GltfBuilder builder = test::triangle_file();
  builder.add_textured_material(test::png(8, 8, 0));
  limits = {};
  EXPECT_EQ(refusal(builder.glb(), limits), "loaded");
  limits.max_elements = 2;
  EXPECT_NE(refusal(builder.glb(), limits).find("at most 2 are read"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::scene
