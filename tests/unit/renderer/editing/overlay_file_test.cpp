// Test of overlay files: what is written is read back, and damaged or wrong ones are refused by their member.
#include <gtest/gtest.h>

#include <random>
#include <span>
#include <string>
#include <utility>

#include "renderer/editing/document_additions.h"
#include "renderer/editing/overlay_file.h"

namespace fire3dv::state {
namespace {

std::string fault_of(const std::string& edits, const std::string& version = "1") {
  const std::string text = R"({"fire3dv_overlay": {"version": )" + version + R"(, "edits": )" + edits + "}}";
  const Result<EditDocument> read = parse_overlay(std::as_bytes(std::span(text)));
  return read.ok() ? "" : read.error().message;
}

TEST(OverlayFiles, FaultsNameTheMember) {
  const std::pair<const char*, const char*> kFaults[] = {
      {R"([{"node": "a"}])", "edits[0] changes nothing"},
      {R"([{"node": "a", "visible": 1}])", "edits[0].visible"},
      {R"([{"node": 7, "visible": true}])", "edits[0].node"},
      {R"([{"visible": true}])", "edits[0] names no"},
      {R"([{"node": "a", "visble": true}])", "unknown member \"visble\""},
      {R"([{"node": "a", "visible": false}, {"node": "a", "visible": true}])",
       "edits[1] edits the visibility"},
      {R"([{"node": "a", "occurrence": -1, "visible": true}])", "edits[0].occurrence"},
      {R"([{"node": "a", "translation": [0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}])",
       "translation"},
      {R"([{"node": "a", "translation": [0, 0, 1e99], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}])",
       "translation[2]"},
      {R"([{"node": "a", "translation": [0, 0, 0], "rotation": [0, 0, 0, 0], "scale": [1, 1, 1]}])",
       "invalid transform"},
      {R"([{"node": "a", "translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 0, 1]}])",
       "invalid transform"},
      {R"([{"node": "a", "translation": [0, 0, 0], "rotation": [0, 0, 0, 1]}])", "\"scale\""},
      {R"([{"node": "a", "matrix": [1, 2, 3]}])", "matrix"},
      {R"([{"node": "a", "light": {"type": "area"}}])", "edits[0].light.type"},
      {R"([{"node": "a", "light": {"type": "point", "color": [1, 1, 1], "intensity": -1}}])",
       "light.intensity"},
      {R"([{"node": "a", "light": {"type": "spot", "color": [1, 1, 1], "intensity": 1, "inner_cone": 1,
            "outer_cone": 0.5}}])",
       "inner_cone"},
      {R"([{"material": "m", "base_color": [1, 1, 1, 1]}])", "emissive"},
      {R"([{"material": "m", "of": ""}])", "edits[0].of is empty"},
      {R"([{"node": "a", "of": "b", "visible": true}])", "unknown member \"of\""},
      {R"([{"node": "a", "instance": 0.5, "visible": true}])", "edits[0].instance"},
      {R"([{"joint": "a", "instance": 0, "position": [0]}])", "unknown member \"instance\""},
      {R"([{"joint": "j", "position": []}])", "edits[0].position"},
      {R"([{"variant": 1}])", "edits[0].variant is no text"},
      {R"([{"variant": "a", "node": "b"}])", "unknown member \"node\""},
      {R"([{"variant": "a"}, {"variant": "b"}])", "edits[1] edits the material variant a second time"},
      {R"([{"add": "a"}])", "edits[0] does not have one of light, camera, copy and asset"},
      {R"([{"add": "", "copy": "b"}])", "edits[0].add"},
      {R"([{"add": "a", "copy": "b", "asset": "c"}])", "does not have one of"},
      {R"([{"add": "a", "copy": "b", "scale": [1, 1, 1]}])", "members that do not belong together"},
      {R"([{"add": "a", "copy": "b", "visible": false}])", "unknown member \"visible\""},
      {R"([{"add": "a", "copy": "b"}, {"add": "a", "copy": "c"}])", "edits[1] edits the addition of node"},
      {R"([{"add": "a", "copy": ""}])", "edits[0].copy is empty"},
      {R"([{"add": "a", "asset": 3}])", "edits[0].asset"},
      {R"([{"add": "a", "parent": 3, "copy": "b"}])", "edits[0].parent"},
      {R"([{"add": "a", "light": {"type": "sun"}}])", "edits[0].light.type"},
      {R"([{"add": "a", "camera": {"near": 0.1}}])", "\"vertical_fov\""},
      {R"([{"add": "a", "camera": {"vertical_fov": 4, "near": 0.1}}])",
       "edits[0].camera.vertical_fov is not between 1e-06 and 3.1415"},
      {R"([{"add": "a", "camera": {"vertical_fov": 1, "near": 0}}])",
       "edits[0].camera.near must be more than 0"},
      {R"([{"add": "a", "camera": {"vertical_fov": 1, "near": 2, "far": 1}}])", "edits[0].camera.far"},
      {R"([{"add": "a", "camera": {"half_extent": [1, 1], "near": 0}}])", "edits[0].camera.far"},
      {R"([{"add": "a", "camera": {"vertical_fov": 1, "near": 1, "f_number": 2}}])", "only one of"},
      {R"({"node": "a"})", "edits is no list"},
      {R"([3])", "edits[0] is no object"},
      {R"([)", "JSON is invalid"}};
  for (const auto& [edits, fault] : kFaults)
    EXPECT_NE(fault_of(edits).find(fault), std::string::npos) << edits << ": " << fault_of(edits);
  EXPECT_NE(fault_of("[]", "3").find("version 3"), std::string::npos);
  EXPECT_EQ(fault_of("[]", "2"), "");
  EXPECT_NE(fault_of("[]", "0").find("version"), std::string::npos);
  EXPECT_EQ(fault_of("[]"), "");
  std::string many = "[";
  for (size_t i = 0; i <= kMaxOverlayEdits; ++i)
    many += (i ? ",{\"node\":\"" : "{\"node\":\"") + std::to_string(i) + "\",\"visible\":false}";
  EXPECT_NE(fault_of(many + "]").find("more than 100000"), std::string::npos);
  const std::string other = R"({"asset": {"version": "2.0"}})";
  EXPECT_NE(parse_overlay(std::as_bytes(std::span(other))).error().message.find("no overlay file"),
            std::string::npos);
}

TEST(OverlayFiles, AdditionsRoundTrip) {
  EditDocument document;
  const auto add = [&](const char* name, Addition addition) {
    document[key_of_addition(name)] = std::move(addition);
  };
  scene::Light spot;
  spot.type = scene::LightType::spot;
  spot.intensity = 0.1f;
  spot.casts_shadow = false;
  NodeTransform place;
  place.translation = {0.1f, -1e-9f, 3};
  place.rotation = glm::angleAxis(0.3f, glm::normalize(glm::vec3(1, 2, 3)));
  add("lamp \"1\"", {"cell/arm", place, spot});
  scene::Camera camera;
  camera.vertical_fov_rad = 0.7f;
  camera.near_m = 1e-3f;
  camera.far_m = 9;
  camera.lens = {2.8f, 1.5f};
  add("view", {"", place, camera});
  camera = {};
  camera.orthographic = true;
  camera.half_extent_m = {2, 1.1f};
  camera.far_m = 100;
  add("plan", {"", {}, camera});
  add("arm.1", {"cell", {}, CopiedNode{"cell/arm"}});
  add("part", {"", {}, AddedAsset{"parts/part.glb"}});
  document[{EditedObject::node, "arm", 0, EditedProperty::visible}] = false;
  const std::string text = overlay_text(document, "cell.glb");
  const Result<EditDocument> read = parse_overlay(std::as_bytes(std::span(text)));
  ASSERT_TRUE(read.ok()) << read.error().message << "\n" << text;
  EXPECT_EQ(*read, document) << text;
  EXPECT_NE(text.find("\"version\": 2"), std::string::npos);
  std::erase_if(document, [](const auto& edit) { return edit.first.object == EditedObject::addition; });
  EXPECT_NE(overlay_text(document, "").find("\"version\": 1"), std::string::npos) << "older programs read it";
  std::string many = "[";
  for (size_t i = 0; i <= kMaxOverlayAdditions; ++i)
    many += (i ? ",{\"add\":\"" : "{\"add\":\"") + std::to_string(i) + "\",\"copy\":\"b\"}";
  EXPECT_NE(fault_of(many + "]", "2").find("more than 10000 additions"), std::string::npos);
}

// Every truncation and every changed byte of a file is read or refused.
TEST(OverlayFiles, DamagedFilesAreSafe) {
  std::mt19937 random(11);
  EditDocument document;
  document[{EditedObject::node, "arm", 0, EditedProperty::transform}] = NodeTransform{};
  document[{EditedObject::node, "arm", 0, EditedProperty::light}] = scene::Light{};
  document[{EditedObject::material, "m", 3, EditedProperty::factors, "c"}] = scene::MaterialFactors{};
  document[{EditedObject::node, "arm", 0, EditedProperty::visible, {}, 7}] = false;
  document[key_of_addition("c")] = Addition{{}, {}, CopiedNode{"arm"}};
  document[key_of_addition("v")].emplace<Addition>().content = scene::Camera{};
  const std::string text = overlay_text(document, "a");
  size_t refused = 0;
  for (size_t length = 0; length + 1 < text.size(); ++length)
    refused += parse_overlay(std::as_bytes(std::span(text.data(), length))).ok() ? 0 : 1;
  EXPECT_EQ(refused, text.size() - 1);
  for (int i = 0; i < 5000; ++i) {
    std::string damaged = text;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    if (const auto read = parse_overlay(std::as_bytes(std::span(damaged))); read.ok())
      (void)overlay_text(*read, "a");
  }
}

}  // namespace
}  // namespace fire3dv::state
