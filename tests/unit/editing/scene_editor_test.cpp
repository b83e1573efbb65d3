// Test of the editor of a window's scene: steps per interaction, undo and redo by keys, scene replacement,
// and the overlay file.
#include <gtest/gtest.h>

#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <initializer_list>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/plural.h"
#include "protocol/robot/robot_file.h"
#include "renderer/app/window/editing/scene_editor.h"
#include "renderer/app/window/viewer_control.h"
#include "renderer/scene/model/loaded_scene.h"
#include "renderer/state/editing/overlay_file.h"
#include "tests/unit/geometry/boxes_scene.h"

namespace fire3dv::app {
namespace {

namespace fs = std::filesystem;

class Editors : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(::testing::TempDir()) /
        ("fire3dv_editor_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  state::EditTargets targets() const { return {scene_, names_}; }
  void update(SceneEditor& editor, bool is_interacting = false) {
    editor.update(viewer_, targets(), is_interacting);
  }
  void press(char letter, bool shift = false) {
    sinks::WindowInput input;
    sinks::InputEvent event;
    event.kind = sinks::InputEvent::Kind::key;
    event.key = sinks::letter(letter);
    event.modifiers.control = true;
    event.modifiers.shift = shift;
    event.down = true;
    input.events.push_back(event);
    const CameraMoves moves = keys_.take(input, {}, viewer_);
    EXPECT_EQ(moves.fly, glm::vec3(0)) << "Ctrl does not fly";
  }
  static std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  OverlayFile file(bool was_named = true) const {
    return {folder_ / "boxes.overlay.json", "boxes.glb", was_named};
  }

  fs::path folder_;
  scene::Scene scene_ = boxes_at({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  state::NodeNames names_{scene_};
  gui::Viewer viewer_;
  ViewerInput keys_;
};

TEST_F(Editors, ADragIsOneStepAndKeysUndoIt) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 0u);
  for (int i = 1; i <= 20; ++i) {
    viewer_.transforms[1].translation.x = static_cast<float>(i);
    update(editor, true);
  }
  press('z');  // waits for the end of the drag
  update(editor, true);
  EXPECT_EQ(viewer_.transforms.at(1).translation.x, 20);
  viewer_.commands.undo = false;
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  viewer_.hidden = {2};
  update(editor);
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.hidden.empty());
  EXPECT_TRUE(viewer_.transforms.contains(1));
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.transforms.empty());
  press('z', true);
  update(editor);
  press('y');
  update(editor);
  EXPECT_EQ(viewer_.transforms.at(1).translation.x, 20);
  EXPECT_EQ(viewer_.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.facts().redo, "");
  EXPECT_NE(editor.facts().undo.find("visibility"), std::string::npos);
}

TEST_F(Editors, WhatIsSavedIsOpenedAgain) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  viewer_.transforms[2].scale = {1, 2, 3};
  viewer_.hidden = {3};
  viewer_.materials[0] = scene_.materials.empty() ? scene::Material() : scene_.materials[0];
  update(editor);
  EXPECT_FALSE(editor.facts().is_saved);
  press('s');
  update(editor);
  EXPECT_TRUE(editor.facts().is_saved);
  const std::string text = bytes_of(file().path);

  Options options;
  options.headless = true;
  options.overlay = file().path;
  Result<state::EditDocument> document = load_overlay(options);
  ASSERT_TRUE(document.ok()) << document.error().message;
  SceneEditor again(file(), *document);
  gui::Viewer reopened;
  again.begin(reopened, targets());
  EXPECT_EQ(again.take_log_messages().at(0),
            counted(document->size(), "edit") + " of " + file().path.string() + " applied");
  EXPECT_EQ(edits_of(reopened), edits_of(viewer_));
  EXPECT_TRUE(again.facts().is_saved);
  EXPECT_EQ(again.facts().undo, "");
  reopened.commands.save_overlay = true;
  again.update(reopened, targets(), false);
  EXPECT_EQ(bytes_of(file().path), text);
}

TEST_F(Editors, AFileThatWasNotOpenedIsReplacedOnlyWhenAskedTwice) {
  std::ofstream(file().path) << "of yesterday";
  SceneEditor editor(file(false), {});
  editor.begin(viewer_, targets());
  EXPECT_NE(editor.take_log_messages().at(0).find("is not applied: --overlay"), std::string::npos);
  viewer_.hidden = {1};
  viewer_.commands.save_overlay = true;
  update(editor);
  EXPECT_EQ(bytes_of(file().path), "of yesterday");
  ASSERT_EQ(editor.take_log_messages().size(), 1u);
  viewer_.commands.save_overlay = true;
  update(editor);
  EXPECT_NE(bytes_of(file().path), "of yesterday");
  EXPECT_EQ(editor.take_log_messages().at(0),
            "1 edit saved to " + file().path.string() + "; open it with --overlay " + file().path.string());
  // Where nothing can be written the edits stay, with an error.
  SceneEditor lost({folder_ / "no such folder" / "a.json", "a", true}, {});
  viewer_.commands.save_overlay = true;
  update(lost);
  EXPECT_NE(lost.take_log_messages().at(0).find("no such folder"), std::string::npos);
  SceneEditor nowhere({}, {});
  viewer_.commands.save_overlay = true;
  update(nowhere);
  EXPECT_NE(nowhere.take_log_messages().at(0).find("--overlay"), std::string::npos);
}

// A node that a scene lacks keeps its edits for a scene that has it.
TEST_F(Editors, EditsOfMissingNodesWaitAndAreReported) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  viewer_.hidden = {1, 3};
  viewer_.selected = 3;
  update(editor);
  scene::Scene less = scene_;
  less.nodes.erase(less.nodes.begin() + 3);
  editor.replace_scene(viewer_, scene_, less, nullptr);
  EXPECT_EQ(viewer_.hidden, std::set<uint32_t>{1});
  EXPECT_EQ(viewer_.selected, scene::kNone);
  editor.update(viewer_, {less, state::NodeNames(less)}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a replaced scene is no step";
  EXPECT_EQ(editor.history().document().size(), 2u);
  editor.replace_scene(viewer_, less, scene_, nullptr);
  EXPECT_EQ(viewer_.hidden, (std::set<uint32_t>{1, 3}));
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  viewer_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(viewer_.hidden.empty());

  state::EditDocument document;
  document[{state::EditedObject::node, "nobody", 0, state::EditedProperty::visible}] = false;
  SceneEditor opened(file(), document);
  gui::Viewer viewer;
  opened.begin(viewer, targets());
  EXPECT_NE(opened.take_log_messages().at(0).find("nobody"), std::string::npos);
  EXPECT_TRUE(viewer.hidden.empty());
}

TEST_F(Editors, JointsKeepTheirPositionsByNameWhenTheFileIsReloaded) {
  const auto robot_with = [](const char* joints) {
    const std::string file =
        R"({"nodes": [{"name": "world", "extras": {"fire3dv": {"robot": {"version": 1,
            "bodies": [{"node": "world"}], "joints": [)" +
        std::string(joints) + R"(], "poses": []}}}}]})";
    return state::RobotPose(robot::read_robot(std::as_bytes(std::span(file)), true).value());
  };
  const std::string lift = R"({"name": "lift", "type": "prismatic", "node": "world", "axis": [0, 1, 0]})";
  const std::string swing = R"({"name": "swing", "type": "revolute", "node": "world", "axis": [0, 0, 1]})";
  const state::RobotPose before = robot_with((lift + "," + swing).c_str());
  const state::RobotPose after = robot_with((swing + "," + lift).c_str());
  const state::RobotPose without = robot_with(swing.c_str());
  SceneEditor editor(file(), {});
  editor.begin(viewer_, {scene_, names_, &before});
  viewer_.joints[0] = {0.5};
  editor.update(viewer_, {scene_, names_, &before}, false);
  ASSERT_EQ(editor.history().undo_steps(), 1u);

  editor.replace_robot(viewer_, scene_, &before, &after);
  EXPECT_EQ(viewer_.joints, (state::JointPositions{{1, {0.5}}}));
  editor.update(viewer_, {scene_, names_, &after}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a reload is no step";

  editor.replace_robot(viewer_, scene_, &after, &without);
  EXPECT_TRUE(viewer_.joints.empty());
  editor.update(viewer_, {scene_, names_, &without}, false);
  editor.replace_robot(viewer_, scene_, &without, &before);
  EXPECT_EQ(viewer_.joints, (state::JointPositions{{0, {0.5}}})) << "an edit without its joint waits";
}

// Scenes after their build: the nodes of these paths behind the others.
scene::Scene with_nodes(scene::Scene scene, std::initializer_list<const char*> names) {
  for (const char* const name : names) (void)scene::add_node(scene, name, scene::kNone, glm::mat4(1));
  return scene;
}

TEST_F(Editors, WhatIsAddedIsSelectedAndUndone) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  ViewPlace place;
  place.focus_m = {1, 2, 3};
  place.world_from_camera =
      glm::translate(glm::mat4(1), {1, 2, 7}) * glm::mat4_cast(glm::angleAxis(0.5f, glm::vec3(0, 1, 0)));
  place.camera.vertical_fov_rad = 0.4f;
  const auto add = [&](gui::ObjectKind kind) {
    viewer_.commands.add = kind;
    editor.update(viewer_, targets(), false, place);
  };
  add(gui::ObjectKind::point_light);
  add(gui::ObjectKind::spot_light);
  add(gui::ObjectKind::camera);
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.facts().undo, "the addition of node \"camera\"");
  const auto light = [&](const char* name) {
    return std::get<scene::Light>(viewer_.additions.at(name).content);
  };
  EXPECT_EQ(light("spot light").type, scene::LightType::spot);
  EXPECT_GT(light("point light").intensity, 0);
  EXPECT_EQ(viewer_.additions.at("point light").transform.translation, place.focus_m);
  const state::Addition& camera = viewer_.additions.at("camera");
  EXPECT_EQ(std::get<scene::Camera>(camera.content).vertical_fov_rad, 0.4f);
  EXPECT_LT(glm::length(glm::vec4(state::parent_from_node(camera.transform)[2] - place.world_from_camera[2])),
            1e-6f);
  EXPECT_EQ(camera.transform.translation, glm::vec3(1, 2, 7));

  const scene::Scene built = with_nodes(scene_, {"camera", "point light", "spot light"});
  editor.replace_scene(viewer_, scene_, built, nullptr);
  EXPECT_EQ(built.nodes.at(viewer_.selected).name, "camera") << "the newest one";
  viewer_.selected = static_cast<uint32_t>(built.nodes.size() - 2);
  viewer_.commands.duplicate = true;
  const state::NodeNames names(built);
  editor.update(viewer_, {built, names}, false, place);
  EXPECT_EQ(light("point light.1").type, scene::LightType::point) << "not a copy of an addition";
  for (int i = 0; i < 4; ++i) {
    viewer_.commands.undo = true;
    editor.update(viewer_, {built, names}, false);
  }
  EXPECT_TRUE(viewer_.additions.empty());
  viewer_.commands.redo = true;
  editor.update(viewer_, {built, names}, false);
  EXPECT_TRUE(viewer_.additions.contains("point light"));
}

TEST_F(Editors, ADuplicateHasThePlaceAndTheEditsOfItsNode) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  const std::string source = scene_.nodes[2].path;
  viewer_.transforms[2].translation = {7, 0, 0};
  viewer_.hidden = {2};
  update(editor);
  press('d');
  update(editor);
  EXPECT_TRUE(viewer_.additions.empty()) << "nothing is selected";
  viewer_.selected = 2;
  press('d');
  update(editor);
  press('d');
  update(editor);
  ASSERT_EQ(viewer_.additions.size(), 2u);
  const auto& [name, copy] = *viewer_.additions.begin();
  EXPECT_EQ(name, scene_.nodes[2].name + ".1");
  EXPECT_EQ(copy.transform.translation, glm::vec3(7, 0, 0));
  EXPECT_EQ(std::get<state::CopiedNode>(copy.content).path, source);
  EXPECT_TRUE(editor.history().document().contains(
      {state::EditedObject::node, state::path_of(name, copy), 0, state::EditedProperty::visible}));
  // Removal of an addition leaves nothing of it, and comes back as one step.
  const state::EditDocument with = editor.history().document();
  scene::Scene built = scene_;
  for (const auto& [of, addition] : viewer_.additions) {
    const uint32_t parent = scene_.nodes[2].parent;
    (void)scene::add_node(built, of, parent, glm::mat4(1));
  }
  editor.replace_scene(viewer_, scene_, built, nullptr);
  const state::NodeNames names(built);
  const auto first = static_cast<uint32_t>(scene_.nodes.size());
  EXPECT_EQ(viewer_.selected, first + 1);
  EXPECT_TRUE(viewer_.hidden.contains(first)) << "the copy of a hidden node is hidden";
  viewer_.removed = {first};
  const std::vector<ShownAddition> shown{{built.nodes[first].name, first, {}}};
  editor.set_shown_additions([&] { return std::span(shown); });
  editor.update(viewer_, {built, names}, false);
  EXPECT_EQ(viewer_.additions.size(), 1u);
  EXPECT_TRUE(viewer_.removed.empty());
  EXPECT_EQ(editor.history().document().size(), with.size() - 2);
  viewer_.commands.undo = true;
  editor.update(viewer_, {built, names}, false);
  EXPECT_EQ(editor.history().document(), with);
  EXPECT_EQ(viewer_.additions.size(), 2u);
  // Several nodes of one path cannot be told apart.
  scene::Scene twins = scene_;
  twins.nodes[1].path = twins.nodes[2].path;
  twins.nodes[1].name = twins.nodes[2].name;
  viewer_.selected = 2;
  viewer_.commands.duplicate = true;
  editor.update(viewer_, {twins, state::NodeNames(twins)}, false);
  EXPECT_NE(editor.take_log_messages().back().find("several nodes"), std::string::npos);
}

TEST_F(Editors, AnExportReportsAdditionsThatAreNotDisplayedAndAChangedFile) {
  const fs::path gltf = folder_ / "boxes.gltf";
  const auto write = [&](const std::string& name) {
    std::ofstream(gltf) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                              "nodes": [{"name": ")" +
                               name + R"("}]})";
  };
  scene::Scene built = scene_;
  const uint32_t lamp = scene::add_node(built, "lamp", 0, glm::mat4(1));
  const uint32_t part = scene::add_node(built, "part", 0, glm::mat4(1));
  (void)scene::add_node(built, "", part, glm::mat4(1));  // of the file
  const state::NodeNames names(built);
  const fs::path of_part = folder_ / "part.gltf";
  std::ofstream(of_part) << R"({"asset": {"version": "2.0"}, "nodes": [{"name": "inside"}]})";
  const std::vector<ShownAddition> shown{{"lamp", lamp, {}}, {"part", part, {}, {of_part, 1, 1, 1}}};
  viewer_.additions["part"] = state::Addition{"top", {}, state::AddedAsset{"part.gltf"}};
  for (const char* const name : {"lamp", "waiting"})
    viewer_.additions[name] = state::Addition{"top", {}, scene::Light()};
  SceneEditor editor(file(), {});
  editor.set_export({[&] { return gltf; }, folder_ / "boxes.glb"});
  editor.set_shown_additions([&] { return std::span(shown); });
  const auto exported = [&] {
    viewer_.commands.export_glb = true;
    editor.update(viewer_, {built, names}, false);
    std::string text;
    for (const std::string& message : editor.finish()) text += message + "\n";
    return text;
  };
  write("top");
  const std::string text = exported();
  EXPECT_NE(text.find("\"waiting\" is left out"), std::string::npos) << text;
  EXPECT_EQ(text.find("\"lamp\" is left out"), std::string::npos) << text;
  EXPECT_EQ(text.find("\"part\" is left out"), std::string::npos) << text;
  EXPECT_NE(text.find("boxes.edited.glb"), std::string::npos) << text;
  fs::remove(of_part);
  EXPECT_NE(exported().find("\"part\" is left out"), std::string::npos);
  write("other");  // the parent of the lamp
  EXPECT_NE(exported().find("has changed"), std::string::npos);
}

// Added files are merged in the order of their names, so that materials get other numbers.
TEST_F(Editors, EditsOfMaterialsStayWithTheirFileWhenOthersComeAndGo) {
  const auto with_files = [&](std::initializer_list<const char*> files) {
    scene::Scene scene = scene_;
    for (const char* const name : files) {
      const uint32_t node = scene::add_node(scene, name, scene::kNone, glm::mat4(1));
      scene::Primitive primitive = scene.primitives[0];
      primitive.material = static_cast<uint32_t>(scene.materials.size());
      scene.materials.emplace_back().name = "wood";
      scene.nodes[node].mesh = static_cast<uint32_t>(scene.meshes.size());
      scene.meshes.push_back({name, static_cast<uint32_t>(scene.primitives.size()), 1, 0});
      scene.primitives.push_back(primitive);
    }
    return scene;
  };
  const scene::Scene table = with_files({"table"}), both = with_files({"apple", "table"});
  const scene::Scene apple = with_files({"apple"});
  const auto key = [](uint32_t occurrence) {
    return state::EditKey{state::EditedObject::material, "wood", occurrence, state::EditedProperty::factors};
  };
  SceneEditor editor(file(), {});
  editor.begin(viewer_, {table, state::NodeNames(table)});
  const auto replace = [&](const scene::Scene& before, const scene::Scene& after) {
    editor.replace_scene(viewer_, before, after, nullptr);
    editor.update(viewer_, {after, state::NodeNames(after)}, false);
    EXPECT_EQ(editor.history().undo_steps(), 1u) << "a replaced scene is no step";
  };
  viewer_.materials[1] = table.materials[1];
  viewer_.materials[1].roughness = 0.25f;
  editor.update(viewer_, {table, state::NodeNames(table)}, false);
  ASSERT_TRUE(editor.history().document().contains(key(0)));

  replace(table, both);
  ASSERT_EQ(viewer_.materials.size(), 1u);
  EXPECT_EQ(viewer_.materials.at(2).roughness, 0.25f);
  EXPECT_EQ(editor.history().document().size(), 1u);
  EXPECT_TRUE(editor.history().document().contains(key(1)));
  replace(both, table);
  EXPECT_TRUE(viewer_.materials.contains(1));
  EXPECT_TRUE(editor.history().document().contains(key(0)));
  replace(table, scene_);
  EXPECT_TRUE(viewer_.materials.empty());
  EXPECT_TRUE(editor.history().document().contains(key(0))) << "it waits for the file";
  replace(scene_, table);
  EXPECT_EQ(viewer_.materials.at(1).roughness, 0.25f);
  replace(table, both);
  replace(both, apple);
  EXPECT_TRUE(viewer_.materials.empty()) << "the material of another file";
}

// An added file brings its materials with its build.
TEST_F(Editors, EditsOfAdditionsAreReportedWhenTheirBuildIsShown) {
  state::EditDocument document;
  document[state::key_of_addition("table")] = state::Addition{{}, {}, state::AddedAsset{"table.glb"}};
  for (const char* const material : {"wood", "glass"})
    document[{state::EditedObject::material, material, 0, state::EditedProperty::factors}] =
        scene::MaterialFactors{};
  SceneEditor editor(file(), document);
  editor.begin(viewer_, targets());
  EXPECT_TRUE(editor.take_log_messages().empty());
  scene::Scene built = with_nodes(scene_, {"table"});
  built.materials.emplace_back().name = "wood";
  editor.replace_scene(viewer_, scene_, built, nullptr);
  editor.report_start({built, state::NodeNames(built)});
  const std::vector<std::string> notes = editor.take_log_messages();
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_NE(notes[0].find("\"glass\" has no effect"), std::string::npos) << notes[0];
  EXPECT_EQ(notes[1], "2 edits of " + file().path.string() + " applied");
  EXPECT_TRUE(viewer_.materials.contains(1));
  editor.report_start({built, state::NodeNames(built)});
  EXPECT_TRUE(editor.take_log_messages().empty()) << "once";
}

TEST_F(Editors, AssetsBesideTheOverlayFileAreOffered) {
  fs::create_directories(folder_ / "parts" / "deep");
  for (const char* name : {"b.glb", "parts/a 1%.gltf", "parts/deep/c.glb", "note.txt"})
    std::ofstream(folder_ / name) << "x";
  SceneEditor editor(file(), {});
  EXPECT_EQ(editor.facts().assets, (std::vector<std::string>{"b.glb", "parts/a 1%25.gltf"}));
  editor.begin(viewer_, targets());
  viewer_.commands.add_asset = "parts/a 1%25.gltf";
  ViewPlace place;
  place.focus_m = {0, 1, 0};
  editor.update(viewer_, targets(), false, place);
  const auto& [name, asset] = *viewer_.additions.begin();
  EXPECT_EQ(name, "a 1%");
  EXPECT_EQ(std::get<state::AddedAsset>(asset.content).uri, "parts/a 1%25.gltf");
  EXPECT_EQ(asset.transform.translation, place.focus_m);
}

TEST_F(Editors, AVariantIsAStepAndKeepsItsName) {
  scene_.variants = {"day", "night"};
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  update(editor);
  viewer_.variant = 0;
  update(editor);
  viewer_.variant = 1;
  update(editor);
  ASSERT_EQ(editor.history().undo_steps(), 2u);
  EXPECT_EQ(editor.facts().undo, "the material variant");
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.variant, 0u);
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.variant, scene::kNone);
  press('y');
  update(editor);
  EXPECT_EQ(viewer_.variant, 0u);

  // The same variant of another scene has another number; one that is missing waits.
  scene::Scene other = scene_, less = scene_;
  other.variants = {"dusk", "night", "day"};
  less.variants = {"dusk"};
  editor.replace_scene(viewer_, scene_, other, nullptr);
  EXPECT_EQ(viewer_.variant, 2u);
  editor.replace_scene(viewer_, other, less, nullptr);
  EXPECT_EQ(viewer_.variant, scene::kNone);
  editor.update(viewer_, {less, names_}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a reload is no step";
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("day"));
  editor.replace_scene(viewer_, less, scene_, nullptr);
  EXPECT_EQ(viewer_.variant, 0u);
  // Another choice takes the place of a missing one.
  editor.replace_scene(viewer_, scene_, less, nullptr);
  viewer_.variant = 0;
  editor.update(viewer_, {less, names_}, false);
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("dusk"));
  press('s');
  editor.update(viewer_, {less, names_}, false);

  Options options;
  options.overlay = file().path;
  Result<state::EditDocument> saved = load_overlay(options);
  ASSERT_TRUE(saved.ok()) << saved.error().message;
  SceneEditor reopened(file(), *saved);
  gui::Viewer viewer;
  reopened.begin(viewer, targets());
  EXPECT_EQ(viewer.variant, scene::kNone);
  const std::vector<std::string> notes = reopened.take_log_messages();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("the material variant \"dusk\" has no effect"), std::string::npos) << notes[0];
  // --variant replaces that of the file.
  options.variant = "night";
  saved = load_overlay(options);
  ASSERT_TRUE(saved.ok());
  SceneEditor named(file(), *saved);
  named.begin(viewer, targets());
  EXPECT_EQ(viewer.variant, 1u);
  EXPECT_EQ(named.facts().undo, "");
  // It is no edit of a file.
  options.overlay.clear();
  options.scene = folder_ / "boxes.glb";
  SceneEditor without(overlay_file(options, true), *load_overlay(options));
  without.begin(viewer, targets());
  EXPECT_EQ(viewer.variant, 1u);
  EXPECT_TRUE(without.take_log_messages().empty());
  options.overlay = folder_ / "new.json";
  SceneEditor missing(overlay_file(options, true), *load_overlay(options));
  missing.begin(viewer, targets());
  EXPECT_TRUE(missing.take_log_messages().empty());
}

TEST_F(Editors, ARefusedVariantIsNoStepAndBlocksNoUndo) {
  scene_.variants = {"day", "night"};
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  update(editor);
  viewer_.hidden = {1};
  update(editor);
  viewer_.variant = 0;
  update(editor);
  viewer_.variant = 1;
  update(editor);
  const auto refuse = [&] {  // the scene stays in the variant "day"
    viewer_.variant = 0;
    editor.take_shown_variant(viewer_, targets());
    update(editor);
  };
  refuse();
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("day"));
  for (const uint32_t variant : {0u, scene::kNone}) {
    press('z');
    update(editor);
    EXPECT_EQ(viewer_.variant, variant);
  }
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.hidden.empty());
  EXPECT_EQ(editor.history().redo_steps(), 3u);
  for (int i = 0; i < 3; ++i) {
    press('y');
    update(editor);
  }
  EXPECT_EQ(viewer_.variant, 1u) << "it is requested again";
  refuse();
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  press('z');
  update(editor);
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.variant, scene::kNone);
  EXPECT_EQ(viewer_.hidden, (std::set<uint32_t>{1}));
}

// Edits and render settings are steps of one history; only edits are saved.
TEST_F(Editors, RenderSettingsAreStepsAmongEdits) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  const auto frame = [&](bool is_interacting = false) {
    update(editor, is_interacting);
    editor.record_settings(viewer_, is_interacting);
  };
  const auto key = [&](char letter) {
    press(letter);
    frame();
  };
  const float exposure = viewer_.draw.post.exposure;
  frame();
  for (int i = 1; i <= 10; ++i) {  // a drag of a slider
    viewer_.draw.post.exposure = exposure + static_cast<float>(i);
    frame(true);
  }
  frame();
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  EXPECT_EQ(editor.facts().undo, "the render settings");
  EXPECT_TRUE(editor.facts().is_saved) << "the file has none of them";
  viewer_.hidden = {2};
  frame();
  viewer_.draw.shadows.method = passes::ShadowMethod::off;
  viewer_.draw.path = viewer_.paths;
  viewer_.paths.bounces = 3;
  frame();
  frame();
  ASSERT_EQ(editor.history().undo_steps(), 3u);
  key('z');
  EXPECT_NE(viewer_.draw.shadows.method, passes::ShadowMethod::off);
  EXPECT_FALSE(viewer_.draw.path);
  EXPECT_NE(viewer_.paths.bounces, 3u);
  EXPECT_EQ(viewer_.hidden, std::set<uint32_t>{2});
  key('z');
  EXPECT_TRUE(viewer_.hidden.empty());
  EXPECT_EQ(viewer_.draw.post.exposure, exposure + 10);
  key('z');
  EXPECT_EQ(viewer_.draw.post.exposure, exposure);
  for (int i = 0; i < 3; ++i) key('y');
  EXPECT_EQ(viewer_.draw.shadows.method, passes::ShadowMethod::off);
  EXPECT_TRUE(viewer_.draw.path);
  EXPECT_EQ(viewer_.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.history().redo_steps(), 0u);

  // A new step ends redo, and has its own values.
  for (int i = 0; i < 3; ++i) key('z');
  viewer_.draw.samples = 1;
  frame();
  EXPECT_EQ(editor.history().redo_steps(), 0u);
  key('z');
  EXPECT_EQ(viewer_.draw.samples, 4u);
  key('y');
  EXPECT_EQ(viewer_.draw.samples, 1u);
  EXPECT_EQ(viewer_.draw.post.exposure, exposure);
  // What the renderer resets after undo is no step: undo would never come further.
  key('z');
  press('y');
  update(editor);
  viewer_.draw.samples = 4;
  editor.record_settings(viewer_, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  EXPECT_EQ(editor.history().redo_steps(), 0u);
  // What another part of the program changes stays when an edit is undone.
  viewer_.hidden = {1};
  frame();
  viewer_.draw.post.tone_map = passes::ToneMap::aces;
  press('z');
  frame();
  EXPECT_EQ(viewer_.draw.post.tone_map, passes::ToneMap::aces);
  EXPECT_TRUE(viewer_.hidden.empty());
}

TEST_F(Editors, ManyRenderSettingsAreUndoneToTheOldestStep) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  for (int i = 0; i <= 250; ++i) {
    viewer_.draw.post.exposure = static_cast<float>(1 + i);
    update(editor);
    editor.record_settings(viewer_, false);
  }
  EXPECT_EQ(editor.history().undo_steps(), state::EditHistory::kMaxSteps);
  for (int i = 249; i >= 50; --i) {
    press('z');
    update(editor);
    editor.record_settings(viewer_, false);
    ASSERT_EQ(viewer_.draw.post.exposure, static_cast<float>(1 + i));
  }
  EXPECT_EQ(editor.history().undo_steps(), 0u);
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.draw.post.exposure, 51);
}

TEST_F(Editors, TheOverlayFileIsBesideTheSceneUnlessNamed) {
  Options options;
  options.scene = folder_ / "demo.glb";
  EXPECT_EQ(overlay_file(options, true).path, folder_ / "demo.glb.overlay.json");
  EXPECT_TRUE(overlay_file(options, false).path.empty());
  options.overlay = folder_ / "mine.json";
  EXPECT_EQ(overlay_file(options, false).path, options.overlay);
  EXPECT_TRUE(load_overlay(options).ok()) << "a window saves it";
  options.headless = true;
  EXPECT_FALSE(load_overlay(options).ok());
  std::ofstream(options.overlay) << R"({"fire3dv_overlay": {"version": 1, "edits": [{"node": "a"}]}})";
  const Result<state::EditDocument> bad = load_overlay(options);
  ASSERT_FALSE(bad.ok());
  EXPECT_NE(bad.error().message.find("mine.json: edits[0]"), std::string::npos) << bad.error().message;
}

}  // namespace
}  // namespace fire3dv::app
