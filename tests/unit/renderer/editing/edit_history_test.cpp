// Test of the user's edits as a document: undo restores its bytes, keys name objects of equal names, and
// transforms survive their parts.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "renderer/editing/document_additions.h"
#include "renderer/editing/edit_history.h"
#include "renderer/editing/overlay_file.h"
#include "renderer/editing/target_index.h"

namespace fire3dv::state {
namespace {

// Three nodes of one path, and materials of equal and of no names.
scene::Scene twins() {
  scene::Scene scene;
  for (const char* path : {"arm", "arm/hand", "arm/hand", "lamp", "arm/hand"}) {
    scene::Node node;
    node.path = path;
    node.name = std::string(path).substr(std::string(path).rfind('/') + 1);
    node.parent = node.path.size() > 4 ? 0 : scene::kNone;
    scene.nodes.push_back(node);
  }
  scene.nodes[3].light = 0;
  scene.lights.resize(1);
  scene.lights[0].name = "bulb";
  scene.materials.resize(5);
  scene.materials[2].name = scene.materials[4].name = "steel";
  scene.variants = {"day", "night"};
  return scene;
}

class Editing : public ::testing::Test {
 protected:
  std::mt19937 random_{7};
  float number(float least, float most) {
    return std::uniform_real_distribution<float>(least, most)(random_);
  }
  NodeTransform transform() {
    NodeTransform made;
    made.translation = {number(-9, 9), number(-9, 9), number(-9, 9)};
    made.rotation = glm::normalize(glm::quat(number(-1, 1), number(-1, 1), number(-1, 1), 1));
    made.scale = {number(0.1f, 3), number(0.1f, 3), number(-3, -0.1f)};
    return made;
  }
  // Changes, adds or removes one edit.
  void edit(UserEdits& edits) {
    const uint32_t node = static_cast<uint32_t>(random_() % 5),
                   material = static_cast<uint32_t>(random_() % 5);
    switch (random_() % 8) {
      case 6:
        edits.variant = edits.variant == scene::kNone ? random_() % 2 : scene::kNone;
        break;
      case 5:
        if (edits.removed.erase(node) == 0) edits.removed.insert(node);
        break;
      case 0:
        if (edits.hidden.erase(node) == 0) edits.hidden.insert(node);
        break;
      case 1:
        edits.transforms[node] = transform();
        break;
      case 2:
        edits.transforms.erase(node);
        break;
      case 3:
        edits.lights[3].intensity = number(0, 1e6f);
        edits.lights[3].type = static_cast<scene::LightType>(random_() % 3);
        edits.lights[3].name = "bulb";
        break;
      case 4:
        edits.materials[material].base_color = {number(0, 1), number(0, 1), number(0, 1), number(0, 1)};
        edits.materials[material].emissive = {number(0, 100), 1e-30f, 0};
        break;
      default:
        edits.materials.erase(material);
    }
  }

  scene::Scene scene_ = twins();
  NodeNames names_{scene_};
  EditTargets targets_{scene_, names_};
};

TEST_F(Editing, ThousandEditsUndoneAreOriginalBytes) {
  UserEdits edits;
  for (int i = 0; i < 20; ++i) edit(edits);
  EditHistory history;
  history.reset(to_document(edits, targets_));
  const std::string original = overlay_text(history.document(), "twins.glb");
  const UserEdits first = edits;
  // 200 drags of five changes each: one step per drag, as many as the history holds.
  std::vector<std::string> texts{original};
  int changes = 0;
  while (history.undo_steps() < EditHistory::kMaxSteps) {
    for (int i = 0; i < 5; ++i, ++changes) edit(edits);
    if (history.record(to_document(edits, targets_)))
      texts.push_back(overlay_text(history.document(), "twins.glb"));
  }
  ASSERT_GE(changes, 1000);
  ASSERT_EQ(texts.size(), EditHistory::kMaxSteps + 1);
  for (size_t step = EditHistory::kMaxSteps; step-- > 0;) {
    ASSERT_TRUE(history.undo());
    ASSERT_EQ(overlay_text(history.document(), "twins.glb"), texts[step]) << "after step " << step;
  }
  EXPECT_FALSE(history.undo());
  EXPECT_EQ(to_edits(history.document(), targets_, {}), first);
  for (size_t step = 1; step <= EditHistory::kMaxSteps; ++step) {
    ASSERT_TRUE(history.redo());
    ASSERT_EQ(overlay_text(history.document(), "twins.glb"), texts[step]);
  }
  EXPECT_FALSE(history.redo());
}

TEST_F(Editing, OldestStepsAreDropped) {
  EditHistory history;
  UserEdits edits;
  for (int i = 0; i < 250; ++i) {
    edits.transforms[0].translation.x = static_cast<float>(i + 1);
    ASSERT_TRUE(history.record(to_document(edits, targets_)));
    EXPECT_FALSE(history.record(to_document(edits, targets_))) << "nothing has changed";
  }
  EXPECT_EQ(history.undo_steps(), 200u);
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(history.undo());
  EXPECT_FALSE(history.undo());
  EXPECT_EQ(to_edits(history.document(), targets_, {}).transforms.at(0).translation.x, 50);
  EXPECT_EQ(history.redo_text(), "the transform of node \"arm\"");
  edits = {};
  history.record(to_document(edits, targets_));
  EXPECT_EQ(history.redo_steps(), 0u);
  EXPECT_EQ(history.undo_steps(), 1u);
  EXPECT_TRUE(history.is_saved()) << "the document is empty as at first";
}

TEST_F(Editing, EqualNamesAreDistinguished) {
  UserEdits edits;
  edits.hidden = {1, 4};
  edits.transforms[2] = transform();
  edits.materials[1].metallic = 0.25f;   // the second one without a name
  edits.materials[4].roughness = 0.75f;  // the second "steel"
  const EditDocument document = to_document(edits, targets_);
  EXPECT_TRUE(document.contains({EditedObject::node, "arm/hand", 2, EditedProperty::visible}));
  EXPECT_TRUE(document.contains({EditedObject::material, "", 1, EditedProperty::factors}));
  EXPECT_TRUE(document.contains({EditedObject::material, "steel", 1, EditedProperty::factors}));
  EXPECT_EQ(to_edits(document, targets_, {}), edits);
  // In another scene only what it has is edited, and the rest is reported.
  scene::Scene less = scene_;
  less.nodes.resize(4);
  less.materials.resize(3);
  const NodeNames names(less);
  std::vector<EditKey> unmatched;
  const UserEdits rest = to_edits(document, {less, names}, {}, &unmatched);
  EXPECT_EQ(rest.hidden, std::set<uint32_t>{1});
  EXPECT_EQ(rest.materials.size(), 1u);
  EXPECT_EQ(unmatched.size(), 2u);
}

// Materials of added files are counted within their file, those of the scene's file without them.
TEST_F(Editing, AddedMaterialsHaveOwnKeys) {
  scene_.materials.resize(8);
  for (const size_t steel : {5, 6, 7}) scene_.materials[steel].name = "steel";
  const std::vector<AddedMaterials> chair_and_table{{"chair", 5, 1}, {"table", 6, 2}};
  const std::vector<AddedMaterials> table{{"table", 5, 2}};
  const EditTargets both{scene_, names_, nullptr, chair_and_table};
  UserEdits edits;
  for (const uint32_t material : {4, 5, 7}) edits.materials[material].metallic = static_cast<float>(material);
  const EditDocument document = to_document(edits, both);
  const auto key = [](uint32_t occurrence, const char* owner) {
    return EditKey{EditedObject::material, "steel", occurrence, EditedProperty::factors, owner};
  };
  ASSERT_EQ(document.size(), 3u);
  EXPECT_TRUE(document.contains(key(1, "")));
  EXPECT_TRUE(document.contains(key(0, "chair")));
  EXPECT_TRUE(document.contains(key(1, "table")));
  EXPECT_EQ(to_edits(document, both, {}), edits);
  EXPECT_EQ(describe(key(0, "chair")), "the factors of material \"steel\" of \"chair\"");
  EXPECT_EQ(find_target(key(2, ""), both), scene::kNone) << "of the file, which has two";
  EXPECT_EQ(find_target(key(0, "nobody"), both), scene::kNone);
  EXPECT_NE(missing_target_text(key(2, ""), both).find("(\"of\")"), std::string::npos) << "of an older file";
  EXPECT_EQ(missing_target_text(key(0, "nobody"), both).find("(\"of\")"), std::string::npos);
  // The chair is missing: nothing else has its edit, and the table's is that of its new number.
  scene_.materials.pop_back();
  std::vector<EditKey> unmatched;
  const UserEdits less = to_edits(document, {scene_, names_, nullptr, table}, {}, &unmatched);
  EXPECT_EQ(unmatched, std::vector<EditKey>{key(0, "chair")});
  ASSERT_EQ(less.materials.size(), 2u);
  EXPECT_EQ(less.materials.at(4).metallic, 4);
  EXPECT_EQ(less.materials.at(6).metallic, 7);
  // Older programs would take them for the file's.
  const std::string text = overlay_text(document, "twins.glb");
  EXPECT_NE(text.find("\"version\": 2"), std::string::npos) << text;
  EXPECT_NE(text.find("{\"material\":\"steel\",\"of\":\"table\",\"occurrence\":1,"), std::string::npos)
      << text;
}

// Instances, and unnamed roots of the file and of added ones, have no path.
TEST_F(Editing, PathlessNodesHaveOwnKeys) {
  const auto add = [&](uint32_t parent) {
    scene_.nodes.emplace_back().parent = parent;
    return static_cast<uint32_t>(scene_.nodes.size() - 1);
  };
  const uint32_t of_second_hand = add(2), of_arm = add(0), root = add(scene::kNone), of_root = add(root),
                 also_of_arm = add(0), unnamed_of_lamp = add(3), below_it = add(unnamed_of_lamp);
  const NodeNames names(scene_);
  const EditTargets targets{scene_, names};
  UserEdits edits;
  edits.hidden = {of_second_hand, of_arm, root, of_root, also_of_arm, unnamed_of_lamp, below_it};
  edits.transforms[also_of_arm] = transform();
  const EditDocument document = to_document(edits, targets);
  const auto key = [](const char* path, uint32_t occurrence, std::optional<uint32_t> instance) {
    return EditKey{EditedObject::node, path, occurrence, EditedProperty::visible, {}, instance};
  };
  EXPECT_EQ(document.size(), 8u);
  EXPECT_TRUE(document.contains(key("arm/hand", 1, 0)));
  EXPECT_TRUE(document.contains(key("arm", 0, 1)));
  EXPECT_TRUE(document.contains(key("", 0, std::nullopt)));
  EXPECT_TRUE(document.contains(key("", 0, 0)));
  EXPECT_TRUE(document.contains(key("lamp", 0, 1)));
  EXPECT_EQ(to_edits(document, targets, {}), edits);
  EXPECT_EQ(find_target(key("arm", 0, 2), targets), scene::kNone);
  EXPECT_EQ(find_target(key("", 1, std::nullopt), targets), scene::kNone);
  EXPECT_EQ(find_target(key("nobody", 0, 0), targets), scene::kNone);
  EXPECT_EQ(describe(key("arm", 0, 1)), "the visibility of instance 1 of node \"arm\"");
  const std::string text = overlay_text(document, "twins.glb");
  EXPECT_NE(text.find("\"version\": 2"), std::string::npos) << text;
  EXPECT_NE(text.find("{\"node\":\"arm\",\"instance\":1,\"visible\":false,\"translation\""),
            std::string::npos)
      << text;
  EXPECT_EQ(parse_overlay(std::as_bytes(std::span(text))).value(), document);
}

TEST_F(Editing, VariantIsChosenByItsName) {
  UserEdits edits;
  edits.variant = 1;
  const EditDocument document = to_document(edits, targets_);
  EXPECT_EQ(document, (EditDocument{{variant_key(), VariantName("night")}}));
  const std::string text = overlay_text(document, "twins.glb");
  EXPECT_NE(text.find("{\"variant\":\"night\"}"), std::string::npos) << text;
  EXPECT_EQ(parse_overlay(std::as_bytes(std::span(text))).value(), document);
  std::swap(scene_.variants[0], scene_.variants[1]);
  EXPECT_EQ(to_edits(document, targets_, {}).variant, 0u);
  scene_.variants = {"day"};
  std::vector<EditKey> unmatched;
  EXPECT_EQ(to_edits(document, targets_, {}, &unmatched).variant, scene::kNone);
  ASSERT_EQ(unmatched.size(), 1u);
  EXPECT_EQ(describe(unmatched[0]), "the material variant \"night\"");
}

TEST_F(Editing, MatricesSplitAndRejoin) {
  for (int i = 0; i < 1000; ++i) {
    const glm::mat4 matrix = parent_from_node(transform());
    const NodeTransform parts = to_transform(matrix);
    ASSERT_FALSE(parts.has_shear);
    const glm::mat4 again = parent_from_node(parts);
    for (int column = 0; column < 4; ++column)
      ASSERT_LT(glm::length(again[column] - matrix[column]), 1e-4f) << "column " << column;
    EXPECT_TRUE(is_valid(parts));
  }
  glm::mat4 sheared(1);
  sheared[1][0] = 0.3f;
  EXPECT_TRUE(to_transform(sheared).has_shear);
  EXPECT_EQ(parent_from_node(to_transform(sheared)), sheared);
  EXPECT_FALSE(is_valid(to_transform(glm::mat4(0))));
}

TEST_F(Editing, ChildrenFollowMovedNode) {
  scene_.nodes[1].parent_from_node[3] = {0, 2, 0, 1};
  RestPose pose = rest_pose(scene_);
  NodeTransform moved;
  moved.translation = {1, 0, 0};
  moved.scale = {2, 2, 2};
  apply_transforms({{0, moved}, {77, moved}}, scene_, pose);
  EXPECT_EQ(glm::vec3(pose.world_from_node[1][3]), glm::vec3(1, 4, 0));
  EXPECT_EQ(glm::vec3(pose.world_from_node[3][3]), glm::vec3(0));  // not below it
}

TEST_F(Editing, AnOverlayFileKeepsEveryBit) {
  UserEdits edits;
  for (int i = 0; i < 300; ++i) edit(edits);
  edits.transforms[1] =
      to_transform(glm::mat4(1, 0.25f, 0, 0, 0.5f, 1, 0, 0, 0, 0, 0.1f, 0, 1e-20f, 3, 1e6f, 1));
  ASSERT_TRUE(edits.transforms[1].has_shear);
  edits.lights[3].outer_cone_rad = 1.5707964f;
  edits.lights[3].casts_shadow = false;
  edits.materials[0].metallic = 0.1f;
  EditDocument document = to_document(edits, targets_);
  document[{EditedObject::joint, "elbow \"left\"", 0, EditedProperty::position}] = JointPosition{0.1, -1e-9};
  document[{EditedObject::node, "h\xc3\xa4nd\n\x01", 0, EditedProperty::visible}] = false;
  const std::string text = overlay_text(document, "twins.glb");
  const Result<EditDocument> read = parse_overlay(std::as_bytes(std::span(text)));
  ASSERT_TRUE(read.ok()) << read.error().message << "\n" << text;
  EXPECT_EQ(*read, document);
  EXPECT_EQ(overlay_text(*read, "twins.glb"), text);
  EXPECT_NE(text.find("\"scene\": \"twins.glb\""), std::string::npos);
  EXPECT_NE(text.find("\"metallic\":0.1,"), std::string::npos) << text;
}

Addition copy_of(const std::string& path, const std::string& parent = {}) {
  Addition addition;
  addition.parent = parent;
  addition.content = CopiedNode{path};
  return addition;
}

TEST_F(Editing, AdditionsAreSteps) {
  UserEdits edits;
  EditHistory history;
  edits.additions["arm.1"] = copy_of("arm");
  ASSERT_TRUE(history.record(to_document(edits, targets_)));
  EXPECT_EQ(history.undo_text(), "the addition of node \"arm.1\"");
  std::vector<EditKey> unmatched;
  EXPECT_EQ(to_edits(history.document(), targets_, {}, &unmatched), edits);
  EXPECT_TRUE(unmatched.empty());
  ASSERT_TRUE(history.undo());
  EXPECT_TRUE(to_edits(history.document(), targets_, {}).additions.empty());
}

// A removed addition leaves nothing behind, neither edits of its nodes nor additions below it; a removed node
// of the file stays in the document.
TEST(DocumentAdditions, ARemovedAdditionIsWithdrawn) {
  EditDocument document;
  const auto edit = [&](const char* path, EditedProperty property) {
    document[{EditedObject::node, path, 0, property}] = property == EditedProperty::removed;
  };
  document[key_of_addition("arm.1")] = copy_of("cell/arm", "cell");
  document[key_of_addition("arm.10")] = copy_of("cell/arm", "cell");
  document[key_of_addition("lamp")] = copy_of("cell/lamp", "cell/arm.1/hand");
  edit("cell/arm.1/hand", EditedProperty::visible);
  edit("cell/arm.10/hand", EditedProperty::visible);
  edit("cell/arm", EditedProperty::removed);
  EditDocument before = document;
  const Paths shown{"cell/arm.1", "cell/arm.10", "cell/arm.1/hand/lamp"};
  EXPECT_FALSE(withdraw_removed_additions(document, shown));
  EXPECT_EQ(document, before);
  const auto hide_instance = [&](EditedProperty property) {
    document[{EditedObject::node, "cell/arm.1", 0, property, {}, 0}] = property == EditedProperty::removed;
  };
  const auto edit_material = [&](const char* owner) {
    document[{EditedObject::material, "steel", 0, EditedProperty::factors, owner}] = scene::MaterialFactors{};
  };
  hide_instance(EditedProperty::removed);
  EXPECT_FALSE(withdraw_removed_additions(document, shown)) << "an instance is not the addition";
  edit_material("");
  edit_material("arm.10");
  before = document;
  before.erase({EditedObject::node, "cell/arm.1", 0, EditedProperty::removed, {}, 0});
  edit_material("lamp");
  edit("cell/arm.1", EditedProperty::removed);
  EditDocument refused = document;
  EXPECT_FALSE(withdraw_removed_additions(refused, {"cell/arm.10"})) << "a node of the file has its path";
  EXPECT_EQ(refused, document);
  EXPECT_TRUE(withdraw_removed_additions(document, shown));
  before.erase(key_of_addition("arm.1"));
  before.erase(key_of_addition("lamp"));
  before.erase({EditedObject::node, "cell/arm.1/hand", 0, EditedProperty::visible});
  EXPECT_EQ(document, before);
}

TEST(DocumentAdditions, CopyKeepsEdits) {
  EditDocument document;
  const auto hide = [&](EditDocument& in, const char* path, uint32_t occurrence = 0) {
    in[{EditedObject::node, path, occurrence, EditedProperty::visible}] = false;
  };
  document[{EditedObject::node, "arm", 0, EditedProperty::transform}] = NodeTransform{};
  document[{EditedObject::node, "arm", 0, EditedProperty::light}] = scene::Light{};
  hide(document, "arm/hand", 2);
  hide(document, "armature");
  hide(document, "arm/lamp/bulb");
  document[key_of_addition("lamp")] = copy_of("x", "arm");
  EditDocument expected;
  expected[{EditedObject::node, "b/arm.1", 0, EditedProperty::light}] = scene::Light{};
  hide(expected, "b/arm.1/hand", 2);
  const EditKey instance{EditedObject::node, "arm", 0, EditedProperty::transform, {}, 1};
  document[instance] = NodeTransform{};
  expected[{EditedObject::node, "b/arm.1", 0, EditedProperty::transform, {}, 1}] = NodeTransform{};
  EXPECT_EQ(edits_of_copy(document, "arm", "b/arm.1"), expected);
}

// Each addition of a file has materials of its own.
TEST(DocumentAdditions, CopiedFileKeepsMaterialEdits) {
  const auto key = [](const char* owner, uint32_t occurrence) {
    return EditKey{EditedObject::material, "steel", occurrence, EditedProperty::factors, owner};
  };
  EditDocument document, expected;
  for (const char* const owner : {"", "chair", "table"}) document[key(owner, 0)] = scene::MaterialFactors{};
  document[key("chair", 2)] = scene::MaterialFactors{};
  for (const uint32_t occurrence : {0, 2}) expected[key("chair.1", occurrence)] = scene::MaterialFactors{};
  EXPECT_EQ(material_edits_of_copy(document, "chair", "chair.1"), expected);
}

TEST(DocumentAdditions, NamesAreCounted) {
  const std::set<std::string> taken{"arm.1", "arm.2", "v1.5"};
  const auto is_taken = [&](const std::string& name) { return taken.contains(name); };
  EXPECT_EQ(next_name("arm", is_taken), "arm.3");
  EXPECT_EQ(next_name("arm.1", is_taken), "arm.3");
  EXPECT_EQ(next_name("arm.x", is_taken), "arm.x.1");
  EXPECT_EQ(next_name("arm.", is_taken), "arm..1");
}

}  // namespace
}  // namespace fire3dv::state
