// Test of scene edits by several streams: precedence, undo, and reports of edits without effect. No GPU.
#include "renderer/state/edits/edit_registry.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace fire3dv::state {
namespace {

// A table with a cup on it and a lamp that the file has; ball: a mesh.
scene::Scene room() {
  scene::Scene scene;
  scene.meshes.emplace_back();
  scene::Light light;
  light.radius_m = 0.25f;
  light.name = "bulb";
  scene.lights.push_back(light);
  const auto add = [&](const char* name, uint32_t parent) {
    scene::Node& node = scene.nodes.emplace_back();
    node.name = node.path = name;
    node.parent = parent;
    return &node;
  };
  add("table", scene::kNone);
  add("cup", 0);
  add("lamp", 0)->light = 0;
  add("ball", scene::kNone)->mesh = 0;
  return scene;
}
enum : uint32_t { kTable, kCup, kLamp, kBall };

class EditRegistryTest : public testing::Test {
 protected:
  StreamId stream(uint64_t epoch, std::vector<std::string> drives = {"nothing"}) {
    wire::StreamDescription description;
    description.epoch = epoch;
    description.adapter_name = "stream " + std::to_string(epoch);
    description.node_names = std::move(drives);
    return poses_.add_stream(description);
  }
  void edit(StreamId id, const std::string& node, wire::Property property, wire::EditValue value) {
    poses_.apply(id, {poses_.streams()[id].epoch, ++version_, node, property, std::move(value)});
  }
  void hide(StreamId id, const std::string& node, bool visible = false) {
    edit(id, node, wire::Property::visible, wire::Visible{visible});
  }
  const scene::SceneEdits& resolved() {
    registry_.apply(poses_.take_scene_changes());
    edits_.set(scene_, registry_.resolve(scene_, poses_));
    return edits_;
  }

  const scene::Scene scene_ = room();
  PoseState poses_{scene_};
  EditRegistry registry_;
  scene::SceneEdits edits_;
  uint64_t version_ = 0;
};

TEST(EditRegistry, OpaqueAlphaIsReportedOnce) {
  scene::Scene scene = room();
  scene.nodes[kCup].mesh = 1;
  scene.meshes.emplace_back();
  for (uint32_t mesh = 0; mesh < 2; ++mesh) {
    scene.meshes[mesh].first_primitive = mesh;
    scene.meshes[mesh].primitive_count = 1;
    scene.primitives.emplace_back().material = mesh;
    scene.materials.emplace_back();
  }
  scene.materials[1].alpha_mode = scene::AlphaMode::blend;
  PoseState poses(scene);
  EditRegistry registry;
  wire::StreamDescription description;
  description.epoch = 1;
  description.adapter_name = "painter";
  description.node_names = {"nothing"};
  const StreamId id = poses.add_stream(description);
  uint64_t version = 0;
  const auto paint = [&](const char* node, float alpha) {
    poses.apply(id, {1, ++version, node, wire::Property::base_color, wire::BaseColor{{1, 0, 0, alpha}}});
    registry.apply(poses.take_scene_changes());
    (void)registry.resolve(scene, poses);
    return registry.take_log_messages();
  };
  EXPECT_TRUE(paint("ball", 1).empty());
  EXPECT_TRUE(paint("cup", 0.3f).empty()) << "its material blends";
  const std::vector<std::string> log = paint("ball", 0.3f);
  ASSERT_EQ(log.size(), 1u);
  EXPECT_TRUE(log[0].starts_with("warning: the node \"ball\" of stream \"painter\" stays opaque")) << log[0];
  EXPECT_NE(log[0].find("OPAQUE"), std::string::npos) << log[0];
  const auto ineffective = registry.take_ineffective();
  ASSERT_EQ(ineffective.size(), 1u);
  EXPECT_EQ(ineffective[0].stream, id);
  EXPECT_TRUE(ineffective[0].reason.starts_with("the node \"ball\" stays opaque")) << ineffective[0].reason;
  EXPECT_TRUE(paint("ball", 0.2f).empty()) << "once";
}

// The log names each cause once, the stream hears of each edit, up to a limit.
TEST_F(EditRegistryTest, StreamsHearOfEditsWithoutEffect) {
  const StreamId first = stream(1), second = stream(2);
  hide(first, "nope");
  hide(first, "nada");
  edit(second, "cup", wire::Property::base_color, wire::BaseColor{{1, 0, 0, 1}});
  hide(second, "cup");
  (void)resolved();
  EXPECT_EQ(registry_.take_log_messages().size(), 2u);
  const auto found = registry_.take_ineffective();
  std::map<std::string, StreamId> reasons;
  for (const EditRegistry::Ineffective& each : found) reasons[each.reason] = each.stream;
  EXPECT_EQ(reasons,
            (std::map<std::string, StreamId>{{"no scene node is called \"nope\"", first},
                                             {"no scene node is called \"nada\"", first},
                                             {"the node \"cup\" has no mesh to be coloured", second}}));
  EXPECT_TRUE(registry_.take_ineffective().empty());
  for (int i = 0; i < 100; ++i) hide(first, "wrong " + std::to_string(i));
  (void)resolved();
  EXPECT_EQ(registry_.take_ineffective().size(), 6u) << "eight of a stream";
}

TEST_F(EditRegistryTest, HiddenParentHidesChildren) {
  const StreamId id = stream(1);
  hide(id, "table");
  EXPECT_TRUE(resolved().is_hidden(kTable));
  EXPECT_TRUE(edits_.is_hidden(kCup));
  EXPECT_FALSE(edits_.is_hidden(kBall));
  EXPECT_EQ(edits_.revisions().visible, 1u);
  hide(id, "cup");  // hidden already
  EXPECT_EQ(resolved().revisions().visible, 1u);
  hide(id, "table", true);
  EXPECT_FALSE(resolved().is_hidden(kTable));
  EXPECT_TRUE(edits_.is_hidden(kCup));
  edit(id, "cup", wire::Property::visible, wire::Cleared{});
  EXPECT_FALSE(resolved().is_hidden(kCup));
  EXPECT_TRUE(edits_.hidden().empty());
  EXPECT_EQ(edits_.revisions(), (scene::EditRevisions{.visible = 3}));
}

TEST_F(EditRegistryTest, LightsMergeWireValues) {
  const StreamId id = stream(1);
  wire::Light light;
  light.kind = wire::LightKind::spot;
  light.color_rgb = {0.5f, 0.25f, 1};
  light.intensity = 7;
  light.range_m = 3;
  light.inner_cone_rad = 0.1f;
  light.outer_cone_rad = 0.2f;
  light.casts_shadow = false;
  edit(id, "lamp", wire::Property::light, light);
  edit(id, "cup", wire::Property::light, light);  // a new one
  const std::vector<scene::PlacedLight> lights = scene::lights_of(scene_, &resolved());
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_EQ(lights[0].node, kCup);
  EXPECT_EQ(lights[1].node, kLamp);
  EXPECT_EQ(lights[0].light.radius_m, 0);
  scene::Light expected;
  expected.name = "bulb";
  expected.type = scene::LightType::spot;
  expected.color = {0.5f, 0.25f, 1};
  expected.intensity = 7;
  expected.range_m = 3;
  expected.radius_m = 0.25f;
  expected.inner_cone_rad = 0.1f;
  expected.outer_cone_rad = 0.2f;
  expected.casts_shadow = false;
  EXPECT_EQ(lights[1].light, expected);
  EXPECT_EQ(scene::lights_of(scene_, nullptr).size(), 1u);
}

TEST_F(EditRegistryTest, RemovedNodeRemovesLights) {
  const StreamId id = stream(1);
  edit(id, "table", wire::Property::node, wire::NodeRemoved{});
  EXPECT_TRUE(resolved().is_hidden(kCup));
  EXPECT_TRUE(scene::lights_of(scene_, &edits_).empty());
  EXPECT_EQ(edits_.revisions().light, 1u);
  edit(id, "table", wire::Property::node, wire::Cleared{});
  EXPECT_FALSE(resolved().is_hidden(kCup));
  EXPECT_EQ(scene::lights_of(scene_, &edits_).size(), 1u);
}

TEST_F(EditRegistryTest, ColoursAndCamerasStayWithNode) {
  const StreamId id = stream(1);
  edit(id, "ball", wire::Property::base_color, wire::BaseColor{{0.1f, 0.2f, 0.3f, 0.4f}});
  edit(id, "cup", wire::Property::camera, wire::Camera{1.1f, 0.2f, 50, 2});
  resolved();
  EXPECT_EQ(edits_.nodes().at(kBall).base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  ASSERT_NE(edits_.camera_at(kCup), nullptr);
  EXPECT_EQ(edits_.camera_at(kCup)->vertical_fov_rad, 1.1f);
  EXPECT_EQ(edits_.camera_at(kCup)->near_m, 0.2f);
  EXPECT_EQ(edits_.camera_at(kCup)->far_m, 50);
  EXPECT_EQ(edits_.camera_at(kCup)->exposure, 2);
  EXPECT_EQ(edits_.camera_at(kCup)->lens, scene::ThinLens());
  edit(id, "cup", wire::Property::camera, wire::Camera{1.1f, 0.2f, 50, 2, 2.8f, 1.5f});
  resolved();
  EXPECT_EQ(edits_.camera_at(kCup)->lens, (scene::ThinLens{2.8f, 1.5f, true})) << "before the settings";
  EXPECT_EQ(edits_.camera_at(kLamp), nullptr);
  edit(id, "cup", wire::Property::base_color, wire::BaseColor{});
  resolved();
  EXPECT_EQ(registry_.faults().unfit, 1u) << "no mesh";
  EXPECT_EQ(edits_.revisions(), (scene::EditRevisions{.base_color = 1, .camera = 2}));
}

TEST_F(EditRegistryTest, OlderStreamKeepsNode) {
  const StreamId older = stream(1), younger = stream(2);
  hide(younger, "ball");
  EXPECT_TRUE(resolved().is_hidden(kBall));
  hide(older, "ball", true);
  EXPECT_FALSE(resolved().is_hidden(kBall));
  EXPECT_EQ(registry_.faults().conflicting, 1u);
  edit(younger, "ball", wire::Property::base_color, wire::BaseColor{});  // another property of the same node
  EXPECT_FALSE(resolved().nodes().at(kBall).base_color.has_value());
  EXPECT_EQ(registry_.faults().conflicting, 2u);
  resolved();
  EXPECT_EQ(registry_.faults().conflicting, 2u) << "each is counted once";
  EXPECT_EQ(registry_.take_log_messages().size(), 1u) << "and told once";
  poses_.remove_stream(older);
  EXPECT_TRUE(resolved().is_hidden(kBall));
  EXPECT_TRUE(edits_.nodes().at(kBall).base_color.has_value());
  poses_.remove_stream(younger);
  EXPECT_TRUE(resolved().nodes().empty());
  EXPECT_TRUE(registry_.empty());
}

TEST_F(EditRegistryTest, MovingStreamHearsToo) {
  const StreamId driver = stream(1, {"ball"}), other = stream(2);
  hide(other, "ball");
  EXPECT_FALSE(resolved().is_hidden(kBall));
  EXPECT_EQ(registry_.faults().conflicting, 1u);
  hide(driver, "ball");
  EXPECT_TRUE(resolved().is_hidden(kBall)) << "its own";
  poses_.remove_stream(driver);
  EXPECT_TRUE(resolved().is_hidden(kBall)) << "the other one's, now";
}

TEST_F(EditRegistryTest, YoungerStreamHidesNothingOlder) {
  const StreamId driver = stream(1, {"cup"}), editor = stream(2), younger = stream(3);
  hide(younger, "table");
  EXPECT_FALSE(resolved().is_hidden(kCup)) << "the cup is driven by an older stream";
  EXPECT_EQ(registry_.faults().conflicting, 1u);
  edit(younger, "table", wire::Property::node, wire::NodeRemoved{});
  EXPECT_FALSE(resolved().is_hidden(kCup));
  EXPECT_EQ(registry_.faults().conflicting, 2u);
  edit(younger, "table", wire::Property::camera, wire::Camera{});
  EXPECT_NE(resolved().camera_at(kTable), nullptr) << "takes nothing away";
  const std::vector<std::string> notes = registry_.take_log_messages();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("table"), std::string::npos) << notes[0];

  edit(editor, "lamp", wire::Property::light, wire::Light{});
  poses_.remove_stream(driver);
  EXPECT_FALSE(resolved().is_hidden(kLamp)) << "the lamp is edited by an older stream";
  poses_.remove_stream(editor);
  EXPECT_TRUE(resolved().is_hidden(kCup)) << "nobody else has anything there";
  const StreamId last = stream(4, {"cup"});
  hide(last, "cup", true);
  EXPECT_TRUE(resolved().is_hidden(kCup)) << "who comes later accepts what is hidden";
}

TEST_F(EditRegistryTest, OlderStreamHidesYounger) {
  const StreamId older = stream(1);
  stream(2, {"cup"});
  hide(older, "table");
  EXPECT_TRUE(resolved().is_hidden(kCup));
  EXPECT_EQ(registry_.faults().conflicting, 0u);
}

TEST_F(EditRegistryTest, NodesAreReservedForReturn) {
  const StreamId older = stream(1), younger = stream(2);
  hide(younger, "ball");
  hide(older, "ball", true);
  EXPECT_FALSE(resolved().is_hidden(kBall));
  const uint64_t place = poses_.suspend_stream(older, 5);
  EXPECT_FALSE(resolved().is_hidden(kBall)) << "the younger one's edit is without effect still";
  wire::StreamDescription description;
  description.epoch = 3;
  const StreamId back = poses_.add_stream(description, nullptr, place);
  EXPECT_FALSE(resolved().is_hidden(kBall)) << "though nothing was edited yet";
  edit(back, "ball", wire::Property::base_color, wire::BaseColor{});
  EXPECT_TRUE(resolved().nodes().at(kBall).base_color.has_value());
  poses_.advance(5);
  EXPECT_FALSE(resolved().is_hidden(kBall)) << "it has the node again";
  edit(back, "ball", wire::Property::base_color, wire::Cleared{});
  EXPECT_TRUE(resolved().is_hidden(kBall));
  poses_.suspend_stream(younger, 7);
  EXPECT_FALSE(resolved().is_hidden(kBall)) << "what it changed is undone at once";
  poses_.suspend_stream(back, 7);
  poses_.advance(7);
  resolved();
  EXPECT_TRUE(registry_.empty());
}

// The file has two feet below the table.
TEST_F(EditRegistryTest, AddedNodeKeepsFileNames) {
  scene::Scene file = room();
  for (int i = 0; i < 2; ++i) {
    scene::Node& foot = file.nodes.emplace_back();
    foot.name = "foot";
    foot.path = "table/foot";
    foot.parent = kTable;
  }
  PoseState poses(file);
  wire::StreamDescription description;
  description.epoch = 1;
  const StreamId older = poses.add_stream(description);
  description.epoch = 2;
  const StreamId younger = poses.add_stream(description);
  uint64_t version = 0;
  const auto add = [&](StreamId id, const std::string& name) {
    poses.apply(id, {poses.streams()[id].epoch, ++version, name, wire::Property::node, wire::NodeAdded{}});
    registry_.apply(poses.take_scene_changes(), &poses.names());
  };
  add(younger, "foot");  // no name that could be found, and no free one either
  add(younger, "table/foot");
  add(younger, "ball");
  EXPECT_TRUE(registry_.requested_nodes().empty());
  EXPECT_EQ(registry_.faults().refused, 3u);
  EXPECT_EQ(registry_.take_finished().size(), 3u);
  add(younger, "fork");
  EXPECT_EQ(registry_.requested_nodes().size(), 1u);
  add(older, "fork");
  ASSERT_EQ(registry_.requested_nodes().size(), 1u) << "the older stream's";
  EXPECT_EQ(registry_.requested_nodes()[0].age, poses.oldest_age());
  EXPECT_EQ(registry_.faults().refused, 4u);
  add(younger, "fork");
  EXPECT_EQ(registry_.requested_nodes().size(), 1u);
  EXPECT_EQ(registry_.faults().refused, 5u);
}

TEST_F(EditRegistryTest, EditsSurviveSceneReplacement) {
  const StreamId id = stream(1);
  scene::Scene with_fork = room(), with_forks = room();
  for (scene::Scene* scene : {&with_fork, &with_forks}) {
    for (const char* path : {"table/fork", "cup/fork"}) {
      if (scene == &with_fork && path[0] == 'c') continue;
      scene::Node& fork = scene->nodes.emplace_back();
      fork.name = "fork";
      fork.path = path;
    }
  }
  poses_.set_scene(with_fork);
  hide(id, "fork");
  registry_.apply(poses_.take_scene_changes());
  EXPECT_TRUE(registry_.resolve(with_fork, poses_).at(4).hidden);
  poses_.set_scene(with_forks);
  const scene::NodeEdits edits = registry_.resolve(with_forks, poses_);
  ASSERT_EQ(edits.count(4), 1u) << "another node of that name is there by now";
  EXPECT_TRUE(edits.at(4).hidden);
  EXPECT_EQ(registry_.faults().unmatched, 0u);
}

TEST_F(EditRegistryTest, NodelessEditsAreCounted) {
  const StreamId id = stream(1);
  hide(id, "nobody");
  hide(id, "ball");
  EXPECT_TRUE(resolved().is_hidden(kBall));
  EXPECT_EQ(registry_.faults().unmatched, 1u);
  const std::vector<std::string> notes = registry_.take_log_messages();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("nobody"), std::string::npos);
}

// A scene whose ball has the vertices of a triangle, and whether it has them to itself.
scene::Scene with_triangle(bool own) {
  scene::Scene scene = room();
  scene.materials.emplace_back();
  scene.positions.resize(3);
  scene.frames.resize(3);
  scene.uvs.resize(3);
  scene.indices = {0, 1, 2};
  scene::Primitive primitive;
  primitive.index_count = primitive.vertex_count = 3;
  scene.primitives.push_back(primitive);
  scene.meshes[0].primitive_count = 1;
  scene.nodes[kBall].has_instance_vertices = own;
  return scene;
}

TEST_F(EditRegistryTest, VerticesFinishWithNode) {
  const scene::Scene shared = with_triangle(false), own = with_triangle(true);
  poses_.set_scene(shared);
  const StreamId id = stream(1);
  wire::Vertices vertices;
  vertices.positions.assign(3, {1, 2, 3});
  edit(id, "ball", wire::Property::vertices, vertices);
  registry_.apply(poses_.take_scene_changes());
  scene::NodeEdits edits = registry_.resolve(shared, poses_);
  ASSERT_NE(edits.at(kBall).vertices, nullptr);
  EXPECT_EQ(edits.at(kBall).vertices->positions[2], glm::vec3(1, 2, 3));
  EXPECT_EQ(registry_.vertex_uses().names(), std::set<std::string>{"ball"});
  EXPECT_TRUE(registry_.take_finished().empty());
  poses_.set_scene(own);
  (void)registry_.resolve(own, poses_);
  std::vector<EditRegistry::Finished> finished = registry_.take_finished();
  ASSERT_EQ(finished.size(), 1u);
  EXPECT_EQ(finished[0].version, 1u);
  EXPECT_EQ(finished[0].epoch, 1u);

  vertices.positions.resize(4);
  edit(id, "ball", wire::Property::vertices, vertices);
  edit(id, "cup", wire::Property::vertices, vertices);
  registry_.apply(poses_.take_scene_changes());
  edits = registry_.resolve(own, poses_);
  EXPECT_EQ(registry_.faults().unfit, 2u) << "too many, and no mesh";
  EXPECT_EQ(registry_.take_finished().size(), 2u) << "no frame waits for what will never be";
  EXPECT_TRUE(registry_.vertex_uses().names().empty());

  vertices.positions.resize(3);
  edit(id, "ball", wire::Property::vertices, vertices);
  registry_.apply(poses_.take_scene_changes());
  poses_.set_scene(shared);
  registry_.set_built_vertex_nodes({"ball"});  // and had no room for them
  (void)registry_.resolve(shared, poses_);
  EXPECT_EQ(registry_.faults().unfit, 3u);
  EXPECT_EQ(registry_.take_finished().size(), 1u);
}

// A node that is added again, with a mesh of other vertices: the old mesh keeps its last vertices until then.
TEST_F(EditRegistryTest, ReplacedNodeStaysUntilTheNext) {
  const scene::Scene before = with_triangle(true);
  scene::Scene after = before;
  after.primitives[0].vertex_count = after.primitives[0].index_count = 4;
  poses_.set_scene(before);
  const StreamId id = stream(1);
  const auto apply = [&](const scene::Scene& scene) {
    registry_.apply(poses_.take_scene_changes());
    return registry_.resolve(scene, poses_);
  };
  edit(id, "tissue", wire::Property::node, wire::NodeAdded{});
  (void)apply(before);
  const std::vector<RequestedNode> first = registry_.requested_nodes();
  ASSERT_EQ(first.size(), 1u);
  EXPECT_TRUE(registry_.confirm_node(first[0]));
  wire::Vertices vertices;
  vertices.positions.assign(3, {1, 2, 3});
  edit(id, "ball", wire::Property::vertices, vertices);
  (void)apply(before);
  (void)registry_.take_finished();

  edit(id, "tissue", wire::Property::node, wire::NodeAdded{});
  vertices.positions.assign(4, {4, 5, 6});
  edit(id, "ball", wire::Property::vertices, vertices);
  scene::NodeEdits edits = apply(before);
  EXPECT_TRUE(registry_.take_withdrawn_nodes().empty()) << "there would be neither";
  EXPECT_TRUE(registry_.is_being_replaced(first[0]));
  EXPECT_EQ(registry_.faults().unfit, 0u);
  EXPECT_TRUE(registry_.take_finished().empty()) << "the frame would be shown without its mesh";
  ASSERT_NE(edits.at(kBall).vertices, nullptr);
  EXPECT_EQ(edits.at(kBall).vertices->positions[0], glm::vec3(1, 2, 3));
  EXPECT_EQ(registry_.vertex_uses().names(), std::set<std::string>{"ball"}) << "the next scene has them, too";

  EXPECT_TRUE(registry_.confirm_node(registry_.requested_nodes().at(0)));
  EXPECT_FALSE(registry_.is_being_replaced(first[0]));
  poses_.set_scene(after);
  edits = registry_.resolve(after, poses_);
  ASSERT_NE(edits.at(kBall).vertices, nullptr);
  EXPECT_EQ(edits.at(kBall).vertices->positions.size(), 4u);
  EXPECT_EQ(registry_.take_finished().size(), 2u);
  EXPECT_EQ(registry_.faults().unfit, 0u);

  edit(id, "tissue", wire::Property::node, wire::NodeAdded{});
  (void)apply(after);
  registry_.refuse_node(registry_.requested_nodes().at(0), "it is broken");
  EXPECT_EQ(registry_.take_withdrawn_nodes().size(), 1u) << "what a refused node replaces goes, too";
}

TEST_F(EditRegistryTest, WantedNodesExcludeRefused) {
  const StreamId older = stream(1), younger = stream(2);
  wire::NodeAdded node;
  node.parent = "table";
  edit(younger, "fork", wire::Property::node, node);
  edit(older, "knife", wire::Property::node, node);
  edit(older, "dish", wire::Property::node, node);
  hide(older, "dish");  // not there yet
  registry_.apply(poses_.take_scene_changes());
  (void)registry_.resolve(scene_, poses_, false);
  EXPECT_EQ(registry_.faults().unmatched, 0u);
  const std::vector<RequestedNode> wanted = registry_.requested_nodes();
  ASSERT_EQ(wanted.size(), 3u);
  EXPECT_EQ(wanted[0].name, "knife");
  EXPECT_EQ(wanted[1].name, "dish");
  EXPECT_EQ(wanted[2].name, "fork");
  EXPECT_EQ(wanted[2].added->parent, "table");
  EXPECT_TRUE(registry_.take_finished().empty());
  registry_.confirm_node(wanted[0]);
  registry_.refuse_node(wanted[1], "no reason");
  EXPECT_EQ(registry_.faults().refused, 1u);
  EXPECT_EQ(registry_.take_finished().size(), 2u);
  EXPECT_EQ(registry_.requested_nodes().size(), 2u);
  EXPECT_NE(registry_.take_log_messages().at(0).find("dish"), std::string::npos);

  edit(younger, "fork", wire::Property::node, wire::NodeRemoved{});  // before it was there
  registry_.apply(poses_.take_scene_changes());
  EXPECT_EQ(registry_.take_finished().size(), 1u);
  EXPECT_EQ(registry_.requested_nodes().size(), 1u);
  registry_.confirm_node(wanted[2]);  // too late
  EXPECT_TRUE(registry_.take_finished().empty());
  (void)registry_.resolve(scene_, poses_);
  EXPECT_EQ(registry_.faults().unmatched, 1u) << "to hide the dish that was refused; not to remove the fork";
}

// Ids are given out again.
TEST_F(EditRegistryTest, SuccessorStartsWithoutEdits) {
  const StreamId first = stream(1);
  hide(first, "ball");
  resolved();
  poses_.remove_stream(first);
  const StreamId second = stream(2);
  ASSERT_EQ(second, first);
  hide(second, "cup");
  EXPECT_FALSE(resolved().is_hidden(kBall));
  EXPECT_TRUE(edits_.is_hidden(kCup));
}

// The lamp has a light with a shadow in the file, which costs no more. Of the others one casts a shadow, and
// the last one is refused; a cleared one makes room.
TEST_F(EditRegistryTest, LightsAreLimited) {
  PeerLimits limits;
  ASSERT_TRUE(set_limit("lights=2", limits).ok());
  ASSERT_TRUE(set_limit("shadow-lights=1", limits).ok());
  const std::shared_ptr<BudgetPool> pool = BudgetPool::create(limits);
  const std::shared_ptr<PeerBudget> budget = pool->add_peer("peer");
  wire::StreamDescription description;
  description.epoch = 7;
  description.node_names = {"nothing"};
  const StreamId id = poses_.add_stream(description, budget);
  wire::Light light;
  light.kind = scene_.lights[0].type == scene::LightType::point ? wire::LightKind::point
                                                                : wire::LightKind::directional;
  for (const char* node : {"ball", "cup", "lamp", "table"}) edit(id, node, wire::Property::light, light);
  uint32_t lights = 0, shadows = 0;
  for (const auto& [node, edited] : resolved().nodes()) {
    lights += edited.light ? 1 : 0;
    shadows += edited.light && edited.light->casts_shadow ? 1 : 0;
  }
  EXPECT_EQ(lights, 3u);
  EXPECT_EQ(shadows, 2u);
  EXPECT_EQ(registry_.faults().refused, 1u);
  EXPECT_EQ(registry_.take_log_messages().size(), 2u) << "one for the light, one for the shadow";
  (void)resolved();
  EXPECT_EQ(registry_.faults().refused, 1u) << "counted once";
  EXPECT_EQ(budget->used(Resource::lights), 2u);
  EXPECT_EQ(budget->used(Resource::shadow_lights), 1u);
  edit(id, "ball", wire::Property::light, wire::Cleared{});
  (void)resolved();
  EXPECT_EQ(budget->used(Resource::lights), 1u);
  poses_.remove_stream(id);
  (void)resolved();
  EXPECT_EQ(budget->used(Resource::lights), 0u);
  EXPECT_EQ(budget->used(Resource::shadow_lights), 0u);
}

TEST_F(EditRegistryTest, WantedNodesChangeOnDemand) {
  const StreamId id = stream(1);
  edit(id, "added", wire::Property::node, wire::NodeAdded{});
  (void)resolved();
  const uint64_t revision = registry_.requested_revision();
  for (int i = 0; i < 10; ++i) hide(id, "cup", i % 2 == 0);
  (void)resolved();
  EXPECT_EQ(registry_.requested_revision(), revision);
  edit(id, "added", wire::Property::node, wire::NodeRemoved{});
  (void)resolved();
  EXPECT_GT(registry_.requested_revision(), revision);
}

}  // namespace
}  // namespace fire3dv::state
