// Test of objects that the editor adds: steps, selection, copies, edits of added files, export.
#include "renderer/editing/new_objects.h"
#include "renderer/scene/files.h"
#include "renderer/scene/model/math.h"
#include "tests/unit/renderer/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

// Scenes after their build: the nodes of these paths behind the others.
scene::Scene with_nodes(scene::Scene scene, std::initializer_list<const char*> names) {
  for (const char* const name : names) (void)scene::add_node(scene, name, scene::kNone, glm::mat4(1));
  return scene;
}

TEST_F(Editors, AdditionIsSelectedAndUndone) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  EditorView view;
  view.focus_m = {1, 2, 3};
  view.world_from_camera =
      glm::translate(glm::mat4(1), {1, 2, 7}) * glm::mat4_cast(glm::angleAxis(0.5f, glm::vec3(0, 1, 0)));
  view.camera.vertical_fov_rad = 0.4f;
  const auto add = [&](ObjectKind kind) {
    view_state_.commands.add = kind;
    editor.update(targets(), false, view);
  };
  add(ObjectKind::point_light);
  add(ObjectKind::spot_light);
  add(ObjectKind::camera);
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.facts().undo, "the addition of node \"camera\"");
  const auto light = [&](const char* name) {
    return std::get<scene::Light>(view_state_.edits.additions.at(name).content);
  };
  EXPECT_EQ(light("spot light").type, scene::LightType::spot);
  EXPECT_GT(light("point light").intensity, 0);
  EXPECT_EQ(view_state_.edits.additions.at("point light").transform.translation, view.focus_m);
  const state::Addition& camera = view_state_.edits.additions.at("camera");
  EXPECT_EQ(std::get<scene::Camera>(camera.content).vertical_fov_rad, 0.4f);
  EXPECT_LT(glm::length(glm::vec4(state::parent_from_node(camera.transform)[2] - view.world_from_camera[2])),
            1e-6f);
  EXPECT_EQ(camera.transform.translation, glm::vec3(1, 2, 7));

  const scene::Scene built = with_nodes(scene_, {"camera", "point light", "spot light"});
  editor.replace_scene(scene_, built, nullptr);
  EXPECT_EQ(built.nodes.at(view_state_.selected).name, "camera") << "the newest one";
  view_state_.selected = static_cast<uint32_t>(built.nodes.size() - 2);
  view_state_.commands.duplicate = true;
  const state::NodeNames names(built);
  editor.update({built, names}, false, view);
  EXPECT_EQ(light("point light.1").type, scene::LightType::point) << "not a copy of an addition";
  for (int i = 0; i < 4; ++i) {
    view_state_.commands.undo = true;
    editor.update({built, names}, false);
  }
  EXPECT_TRUE(view_state_.edits.additions.empty());
  view_state_.commands.redo = true;
  editor.update({built, names}, false);
  EXPECT_TRUE(view_state_.edits.additions.contains("point light"));
}

TEST_F(Editors, DuplicateKeepsPoseAndEdits) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  const std::string source = scene_.nodes[2].path;
  view_state_.edits.transforms[2].translation = {7, 0, 0};
  view_state_.edits.hidden = {2};
  update(editor);
  view_state_.commands.duplicate = true;
  update(editor);
  EXPECT_TRUE(view_state_.edits.additions.empty()) << "nothing is selected";
  view_state_.selected = 2;
  view_state_.commands.duplicate = true;
  update(editor);
  view_state_.commands.duplicate = true;
  update(editor);
  ASSERT_EQ(view_state_.edits.additions.size(), 2u);
  const auto& [name, copy] = *view_state_.edits.additions.begin();
  EXPECT_EQ(name, scene_.nodes[2].name + ".1");
  EXPECT_EQ(copy.transform.translation, glm::vec3(7, 0, 0));
  EXPECT_EQ(std::get<state::CopiedNode>(copy.content).path, source);
  EXPECT_TRUE(editor.history().document().contains(
      {state::EditedObject::node, state::path_of(name, copy), 0, state::EditedProperty::visible}));
  // Removal of an addition leaves nothing of it, and comes back as one step.
  const state::EditDocument with = editor.history().document();
  scene::Scene built = scene_;
  for (const auto& [of, addition] : view_state_.edits.additions) {
    const uint32_t parent = scene_.nodes[2].parent;
    (void)scene::add_node(built, of, parent, glm::mat4(1));
  }
  editor.replace_scene(scene_, built, nullptr);
  const state::NodeNames names(built);
  const auto first = static_cast<uint32_t>(scene_.nodes.size());
  EXPECT_EQ(view_state_.selected, first + 1);
  EXPECT_TRUE(view_state_.edits.hidden.contains(first)) << "the copy of a hidden node is hidden";
  view_state_.edits.removed = {first};
  const std::vector<ShownAddition> shown{{built.nodes[first].name, first, {}}};
  editor.set_shown_additions([&] { return std::span(shown); });
  editor.update({built, names}, false);
  EXPECT_EQ(view_state_.edits.additions.size(), 1u);
  EXPECT_TRUE(view_state_.edits.removed.empty());
  EXPECT_EQ(editor.history().document().size(), with.size() - 2);
  view_state_.commands.undo = true;
  editor.update({built, names}, false);
  EXPECT_EQ(editor.history().document(), with);
  EXPECT_EQ(view_state_.edits.additions.size(), 2u);
  // Several nodes of one path cannot be told apart.
  scene::Scene twins = scene_;
  twins.nodes[1].path = twins.nodes[2].path;
  twins.nodes[1].name = twins.nodes[2].name;
  view_state_.selected = 2;
  view_state_.commands.duplicate = true;
  editor.update({twins, state::NodeNames(twins)}, false);
  EXPECT_NE(editor.take_log_messages().back().find("several nodes"), std::string::npos);
}

TEST_F(Editors, ExportReportsWhatIsMissing) {
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
  view_state_.edits.additions["part"] = state::Addition{"top", {}, state::AddedAsset{"part.gltf"}};
  for (const char* const name : {"lamp", "waiting"})
    view_state_.edits.additions[name] = state::Addition{"top", {}, scene::Light()};
  EditSession editor(view_state_, file(), {});
  editor.set_export({[&] { return gltf; }, folder_ / "boxes.glb"});
  editor.set_shown_additions([&] { return std::span(shown); });
  const auto exported = [&] {
    view_state_.commands.export_glb = true;
    editor.update({built, names}, false);
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
TEST_F(Editors, MaterialEditsStayWithFile) {
  std::vector<state::AddedMaterials> added;
  const auto with_files = [&](std::initializer_list<const char*> files) {
    scene::Scene scene = scene_;
    added.clear();
    for (const char* const name : files) {
      (void)scene::add_node(scene, name, scene::kNone, glm::mat4(1));
      added.push_back({name, static_cast<uint32_t>(scene.materials.size()), 1});
      scene.materials.emplace_back().name = "wood";
    }
    return scene;
  };
  const auto key = [](const char* owner) {
    return state::EditKey{state::EditedObject::material, "wood", 0, state::EditedProperty::factors, owner};
  };
  EditSession editor(view_state_, file(), {});
  editor.set_shown_additions([] { return std::span<const ShownAddition>(); },
                             [&] { return std::span<const state::AddedMaterials>(added); });
  scene::Scene shown = scene_;
  const auto update_shown = [&] {
    const state::NodeNames names(shown);
    editor.update({shown, names, nullptr, added}, false);
  };
  size_t steps = 0;
  const auto show = [&](std::initializer_list<const char*> files) {
    const scene::Scene before = std::exchange(shown, with_files(files));
    editor.replace_scene(before, shown, nullptr);
    update_shown();
    EXPECT_EQ(editor.history().undo_steps(), steps) << "a replaced scene is no step";
  };
  editor.begin(targets());
  show({"table"});
  view_state_.edits.materials[1] = scene::factors_of(shown.materials[1]);
  view_state_.edits.materials[1].roughness = 0.25f;
  update_shown();
  ++steps;
  const state::EditDocument document = editor.history().document();
  ASSERT_EQ(document.size(), 1u);
  EXPECT_TRUE(document.contains(key("table")));

  show({"apple", "table"});
  ASSERT_EQ(view_state_.edits.materials.size(), 1u);
  EXPECT_EQ(view_state_.edits.materials.at(2).roughness, 0.25f);
  show({"apple"});
  EXPECT_TRUE(view_state_.edits.materials.empty()) << "the material of another file";
  show({});
  show({"table"});
  EXPECT_EQ(view_state_.edits.materials.at(1).roughness, 0.25f);
  EXPECT_EQ(editor.history().document(), document) << "it waits for its file";
  // A missing file's edit is not taken by another one's material.
  show({"apple", "table"});
  view_state_.edits.materials[1] = scene::factors_of(shown.materials[1]);
  view_state_.edits.materials[1].roughness = 0.75f;
  update_shown();
  ++steps;
  show({"table"});
  EXPECT_EQ(view_state_.edits.materials.at(1).roughness, 0.25f);
  show({"apple", "table"});
  EXPECT_EQ(view_state_.edits.materials.at(1).roughness, 0.75f);
  EXPECT_EQ(view_state_.edits.materials.at(2).roughness, 0.25f);
  EXPECT_TRUE(editor.history().document().contains(key("apple")));
  // Steps from before the other file came name the same material.
  for (int i = 0; i < 2; ++i) {
    view_state_.commands.undo = true;
    update_shown();
  }
  EXPECT_TRUE(view_state_.edits.materials.empty());
  EXPECT_TRUE(editor.history().document().empty());
  for (int i = 0; i < 2; ++i) {
    view_state_.commands.redo = true;
    update_shown();
  }
  EXPECT_EQ(view_state_.edits.materials.at(1).roughness, 0.75f);
  EXPECT_EQ(view_state_.edits.materials.at(2).roughness, 0.25f);
}

// An edit of an instance lives on after undo, a replaced scene and a restart.
TEST_F(Editors, EditsOfInstancesAreKept) {
  for (int i = 0; i < 2; ++i) scene_.nodes.emplace_back().parent = 1;
  const auto second = static_cast<uint32_t>(scene_.nodes.size() - 1);
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  view_state_.edits.hidden = {second};
  update(editor);
  view_state_.edits.hidden.insert(2);
  update(editor);
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{second});
  scene::Scene more = scene_;
  more.nodes.insert(more.nodes.begin() + 4, scene::Node{});
  more.nodes[4].path = more.nodes[4].name = "more";
  editor.replace_scene(scene_, more, nullptr);
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{second + 1});
  ViewState reopened;
  EditSession again(reopened, file(), editor.history().document());
  again.begin(targets());
  EXPECT_EQ(reopened.edits.hidden, std::set<uint32_t>{second});
  view_state_.selected = second;
  view_state_.commands.duplicate = true;
  update(editor);
  EXPECT_NE(editor.take_log_messages().back().find("it is an instance of"), std::string::npos);
  EXPECT_TRUE(view_state_.edits.additions.empty());
}

// The user's transform of a driven node waits for the end of the stream.
TEST_F(Editors, CopyOfDrivenNodeKeepsPose) {
  state::PoseState poses(scene_);
  wire::StreamDescription description;
  description.epoch = 7;
  description.node_names = {scene_.nodes[2].name};
  const state::StreamId stream = poses.add_stream(description);
  const std::vector<wire::Affine3x4> moved{scene::to_affine(glm::translate(glm::mat4(1), {0, 5, 0}))};
  wire::PoseFrameView frame;
  frame.header.epoch = 7;
  frame.header.sequence = 1;
  frame.node_count = 1;
  frame.poses = moved;
  poses.push(stream, frame);
  ASSERT_EQ(poses.world_from_node(2)[3].y, 5);
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  view_state_.edits.transforms[1].translation = view_state_.edits.transforms[2].translation = {7, 0, 0};
  update(editor);
  EditorView view;
  view.poses = &poses;
  const auto copied_to = [&](uint32_t node) {
    view_state_.selected = node;
    view_state_.commands.duplicate = true;
    editor.update(targets(), false, view);
    return view_state_.edits.additions.at(scene_.nodes[node].name + ".1").transform.translation;
  };
  EXPECT_EQ(copied_to(2), glm::vec3(0, 5, 0));
  EXPECT_EQ(copied_to(1), glm::vec3(7, 0, 0));
}

// Each addition of a file has materials of its own.
TEST_F(Editors, CopiedFileKeepsMaterialEdits) {
  scene::Scene built = with_nodes(scene_, {"chair"});
  built.materials.emplace_back().name = "wood";
  const std::vector<state::AddedMaterials> added{{"chair", 1, 1}};
  const state::NodeNames names(built);
  view_state_.edits.additions["chair"] = state::Addition{{}, {}, state::AddedAsset{"chair.glb"}};
  EditSession editor(view_state_, file(), {});
  editor.begin({built, names, nullptr, added});
  view_state_.edits.materials[0] = view_state_.edits.materials[1] = scene::factors_of(built.materials[1]);
  view_state_.edits.materials[1].roughness = 0.25f;
  view_state_.selected = static_cast<uint32_t>(built.nodes.size() - 1);
  view_state_.commands.duplicate = true;
  editor.update({built, names, nullptr, added}, false);
  ASSERT_TRUE(view_state_.edits.additions.contains("chair.1"));
  const state::EditDocument document = editor.history().document();
  EXPECT_EQ(document.size(), 5u) << "two additions, three materials";
  const auto of_copy =
      document.find({state::EditedObject::material, "wood", 0, state::EditedProperty::factors, "chair.1"});
  ASSERT_NE(of_copy, document.end());
  EXPECT_EQ(std::get<scene::MaterialFactors>(of_copy->second).roughness, 0.25f);
}

// An added file brings its materials with its build.
TEST_F(Editors, AdditionEditsAreReportedWhenShown) {
  state::EditDocument document;
  for (const char* const name : {"table", "refused"}) {
    document[state::key_of_addition(name)] = state::Addition{{}, {}, state::AddedAsset{"table.glb"}};
    for (const char* const material : {"wood", "glass"})
      document[{state::EditedObject::material, material, 0, state::EditedProperty::factors, name}] =
          scene::MaterialFactors{};
  }
  document[{state::EditedObject::node, "refused/leg", 0, state::EditedProperty::visible}] = false;
  document[{state::EditedObject::node, "table/leg", 0, state::EditedProperty::visible}] = false;
  EditSession editor(view_state_, file(), document);
  std::vector<state::AddedMaterials> added;
  std::vector<ShownAddition> shown;
  editor.set_shown_additions([&] { return std::span<const ShownAddition>(shown); },
                             [&] { return std::span<const state::AddedMaterials>(added); });
  editor.begin(targets());
  EXPECT_TRUE(editor.take_log_messages().empty());
  scene::Scene built = with_nodes(scene_, {"table"});
  built.materials.emplace_back().name = "wood";
  added = {{"table", 1, 1}};
  shown = {{"table", static_cast<uint32_t>(built.nodes.size() - 1), {}}};
  editor.replace_scene(scene_, built, nullptr);
  const state::NodeNames names(built);
  editor.report_start({built, names, nullptr, added});
  const std::vector<std::string> notes = editor.take_log_messages();
  ASSERT_EQ(notes.size(), 3u) << "those of the refused one have its warning";
  EXPECT_NE(notes[0].find("\"table/leg\" has no effect"), std::string::npos) << notes[0];
  EXPECT_NE(notes[1].find("\"glass\" of \"table\" have no effect"), std::string::npos) << notes[1];
  EXPECT_EQ(notes[2], "2 edits of " + file().path.string() + " applied");
  EXPECT_TRUE(view_state_.edits.materials.contains(1));
  editor.report_start({built, names, nullptr, added});
  EXPECT_TRUE(editor.take_log_messages().empty()) << "once";
}

TEST_F(Editors, AddedCameraIsSelected) {
  const scene::Scene built = with_nodes(scene_, {"table"});
  const std::vector<ShownAddition> shown{{"table", static_cast<uint32_t>(built.nodes.size() - 1), {}}};
  const size_t eye = find_added_camera("eye", built, shown).value();
  EXPECT_EQ(built.nodes[scene::camera_nodes(built).at(eye)].name, "eye");
  const auto fault = [&](const char* name) { return find_added_camera(name, built, shown).error().message; };
  EXPECT_NE(fault("table").find("has no camera"), std::string::npos) << fault("table");
  EXPECT_NE(fault("lost").find("is not displayed"), std::string::npos) << fault("lost");
}

TEST_F(Editors, NearbyAssetsAreOffered) {
  fs::create_directories(folder_ / "parts" / "deep");
  const fs::path elsewhere = folder_ / "parts" / "deep" / "elsewhere";
  fs::create_directories(elsewhere);
  for (const char* name : {"b.glb", "parts/a 1%.gltf", "parts/deep/c.glb", "note.txt"})
    std::ofstream(folder_ / name) << "x";
  EditSession editor(view_state_, file(), {});
  EXPECT_EQ(editor.facts().assets, (std::vector<std::string>{"b.glb", "parts/a 1%25.gltf"}));
  editor.begin(targets());
  view_state_.commands.add_asset = "parts/a 1%25.gltf";
  EditorView view;
  view.focus_m = {0, 1, 0};
  editor.update(targets(), false, view);
  const auto& [name, asset] = *view_state_.edits.additions.begin();
  EXPECT_EQ(name, "a 1%");
  EXPECT_EQ(std::get<state::AddedAsset>(asset.content).uri, "parts/a 1%25.gltf");
  EXPECT_EQ(asset.transform.translation, view.focus_m);

  OverlayFile with_assets = file();
  with_assets.assets = elsewhere;
  for (const char* of : {"b.glb", "d.glb"}) std::ofstream(elsewhere / of) << "x";
  EditSession other(view_state_, with_assets, {});
  const std::vector<std::string> both{"b.glb", "d.glb", "parts/a 1%25.gltf"};
  EXPECT_EQ(other.facts().assets, both);
  fs::remove(elsewhere / "d.glb");
  other.update(targets(), false);
  EXPECT_EQ(other.facts().assets, both) << "folders are read on demand";
  view_state_.commands.list_assets = true;
  other.update(targets(), false);
  EXPECT_EQ(other.facts().assets, (std::vector<std::string>{"b.glb", "parts/a 1%25.gltf"}));
}

// A file in centimetres may be around the camera, where nobody sees it.
TEST_F(Editors, SizeOfAdditionIsTold) {
  const auto size_of = [this](float scale) {
    EditSession editor(view_state_, file(), {});
    editor.begin(targets());
    view_state_.commands.add = ObjectKind::point_light;
    editor.update(targets(), false, {});
    scene::Scene built = with_nodes(scene_, {"point light"});
    scene::Node& added = built.nodes.back();
    added.mesh = static_cast<uint32_t>(built.meshes.size());
    scene::Primitive box;
    box.bounds_min = glm::vec3(-scale);
    box.bounds_max = glm::vec3(scale);
    built.meshes.push_back(
        {.first_primitive = static_cast<uint32_t>(built.primitives.size()), .primitive_count = 1});
    built.primitives.push_back(box);
    scene_.bounds_min = glm::vec3(-1);
    scene_.bounds_max = glm::vec3(1);
    (void)editor.take_log_messages();
    editor.replace_scene(scene_, built, nullptr);
    view_state_.edits.additions.clear();
    const std::vector<std::string> messages = editor.take_log_messages();
    return messages.empty() ? std::string() : messages.front();
  };
  EXPECT_EQ(size_of(0.5f), "added \"point light\", 1 x 1 x 1 m");
  EXPECT_EQ(size_of(100),
            "added \"point light\", 200 x 200 x 200 m; it is 100 times as large as the scene: if its file is "
            "not in metres, set Scale (centimetres: 0.01), then press F");
}

// They have no node that could be removed.
TEST_F(Editors, RefusedAdditionsLoseEdits) {
  state::EditDocument document;
  document[state::key_of_addition("lost")] = state::Addition{"nowhere", {}, scene::Light()};
  document[state::key_of_addition("below")] = state::Addition{"nowhere/lost", {}, scene::Light()};
  const std::string path = scene_.nodes[2].path;
  const state::EditKey of_lost{state::EditedObject::node, "nowhere/lost", 0, state::EditedProperty::visible};
  const state::EditKey of_scene{state::EditedObject::node, path, 0, state::EditedProperty::visible};
  document[of_lost] = false;
  document[of_scene] = false;
  // One whose path is that of a node of the file.
  const std::string taken = scene_.nodes[2].name;
  const std::string parent = path.substr(0, path.size() - std::min(path.size(), taken.size() + 1));
  document[state::key_of_addition(taken)] = state::Addition{parent, {}, scene::Light()};
  ASSERT_EQ(state::path_of(taken, state::Addition{parent, {}, scene::Light()}), path);
  EditSession editor(view_state_, file(), document);
  editor.begin(targets());
  view_state_.commands.remove_addition = "lost";
  update(editor);
  EXPECT_EQ(editor.history().document().size(), 2u);
  EXPECT_TRUE(editor.history().document().contains(of_scene));
  EXPECT_FALSE(view_state_.commands.remove_addition);
  view_state_.commands.remove_addition = taken;
  update(editor);
  EXPECT_EQ(editor.history().document().size(), 1u);
  EXPECT_TRUE(editor.history().document().contains(of_scene)) << "the file's node stays hidden";
  EXPECT_TRUE(view_state_.edits.hidden.contains(2));
  for (int i = 0; i < 2; ++i) {
    view_state_.commands.undo = true;
    update(editor);
  }
  EXPECT_EQ(editor.history().document(), document);
}

TEST_F(Editors, OnlyReadableFilesAreOffered) {
  const fs::path inside = folder_ / "inside";
  fs::create_directories(inside / "c:d");
  const std::string latin = std::string("t") + char(0xfc) + "r.glb";  // no UTF-8
  for (const std::string& name :
       {std::string("a:b.gltf"), std::string("c:d/e:f.glb"), std::string("g\\h.glb"), latin,
        std::string("tür%.glb"), std::string("line\nbreak.glb")})
    std::ofstream(inside / name) << "x";
  std::ofstream(folder_ / "secret.glb") << "x";
  fs::create_symlink("../secret.glb", inside / "out.glb");
  fs::create_symlink("a:b.gltf", inside / "in.glb");
  fs::create_symlink("nowhere", inside / "broken.glb");
  fs::create_directory(inside / "folder.glb");
  const std::vector<std::string> offered = offered_assets(inside / "s.overlay.json", {});
  EXPECT_EQ(offered, (std::vector<std::string>{"./a%3Ab.gltf", "./c%3Ad/e%3Af.glb", "in.glb",
                                               "line%0Abreak.glb", "t%FCr.glb", "tür%25.glb"}));
  for (const std::string& uri : offered) {
    const Result<fs::path> path = scene::AssetFolder(inside / "s.overlay.json").resolve(uri);
    EXPECT_TRUE(path && fs::is_regular_file(*path)) << uri;
  }
  const std::pair<const char*, const char*> names[] = {
      {"./a%3Ab.gltf", "a:b"}, {"./c%3Ad/e%3Af.glb", "e:f"},       {"t%FCr.glb", "t?r"},
      {"tür%25.glb", "tür%"},  {"line%0Abreak.glb", "line?break"}, {"odd%2.glb", "odd%2"}};
  for (const auto& [uri, name] : names) EXPECT_EQ(name_of_asset(uri), name);
}

}  // namespace
}  // namespace fire3dv::app
