// Render test of scenes that streams change while they are drawn: added nodes with assets, replaced vertices.
// The result equals a scene built that way, drawing continues during builds, and no GPU objects leak.
#include "renderer/live_scene/live_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <glm/gtc/matrix_transform.hpp>
#include <thread>

#include "renderer/app/device_uploader.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/model/bounds.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/support/gltf_builder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{160, 120};
const std::vector<glm::vec3> kSail{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};  // the triangle of triangle_file()

struct Way {
  const char* name;
  settings::RasterPath raster;
  settings::ShadowSettings shadows;
};
const Way kConfigurations[] = {
    {"hybrid",
     settings::RasterPath::visibility,
     {settings::ShadowMethod::ray, true, settings::RayBackEnd::query}},
    {"forward", settings::RasterPath::forward, {settings::ShadowMethod::ray}},
    {"maps", settings::RasterPath::visibility, {settings::ShadowMethod::map}},
};

settings::DrawSettings settings_of(const Way& way) {
  settings::DrawSettings settings;
  settings.raster = way.raster;
  settings.shadows = way.shadows;
  settings.post.fxaa = false;
  return settings;
}

// sail: transform of a triangle with the default material, if present. block: transform of the block's
// vertices. is_red: the block has the material that it has in the variant "red".
scene::Scene harbour(const std::optional<glm::mat4>& sail, const glm::mat4& block = glm::mat4(1),
                     bool is_red = false) {
  SceneBuilder builder;
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.7f, 0.7f, 0.7f})), 20), glm::mat4(1));
  const uint32_t blue = builder.material(matte({0.3f, 0.5f, 0.8f}));
  const uint32_t red = builder.material(matte({0.8f, 0.1f, 0.1f}));
  const uint32_t box = builder.box(is_red ? red : blue, {0.4f, 0.3f, 0.4f});
  builder.mesh_node("block", box, at({-1, 0.3f, 0}));
  builder.mesh_node("pier", builder.box(builder.material(matte({0.6f, 0.4f, 0.3f})), {0.3f, 0.2f, 0.6f}),
                    at({1, 0.2f, -0.5f}));
  if (sail) builder.mesh_node("sail", builder.triangles(0, kSail, {0, 1, 2}), *sail);
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.5f, -1, -0.6f}));
  builder.camera_node("camera", {0.5f, 1.8f, 4}, {0, 0.5f, 0});
  scene::Scene scene = builder.build();
  scene::Primitive& moved = scene.primitives[scene.meshes[box].first_primitive];
  scene.variants = {"red"};
  scene.variant_materials = {blue, red};
  moved.first_variant_material = 0;
  scene::Box around;
  for (uint32_t v = moved.first_vertex; v < moved.first_vertex + moved.vertex_count; ++v) {
    scene.positions[v] = glm::vec3(block * glm::vec4(scene.positions[v], 1));
    around.add(scene.positions[v]);
  }
  moved.bounds_min = around.low;
  moved.bounds_max = around.high;
  scene::find_world_bounds(scene);
  return scene;
}

wire::Affine3x4 affine(const glm::mat4& matrix) {
  wire::Affine3x4 result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      result.m[static_cast<size_t>(4 * row + column)] = matrix[column][row];
  }
  return result;
}

// A renderer, and a stream that edits its scene.
class ViewerDocument {
 public:
  explicit ViewerDocument(const Way& way)
      : base_(whole(harbour({}))),
        bench_(base_.scene, kExtent, settings_of(way)),
        poses_(base_.scene),
        camera_(*app::CameraRig::create(base_.scene)),
        uploader_(bench_.renderer()),
        live_(base_, poses_, uploader_, {}) {
    camera_.set_edits(live_.edits());
    live_.on_scene_replaced(
        [this](const scene::Scene&, const scene::Scene& after) { camera_.set_scene(after); });
  }

  void join(std::vector<std::string> names) {
    wire::StreamDescription description;
    description.epoch = ++epoch_;
    description.node_names = std::move(names);
    stream_ = poses_.add_stream(description);
    version_ = 0;
  }
  void leave() { poses_.remove_stream(stream_); }
  void edit(const std::string& node, wire::Property property, wire::EditValue value) {
    poses_.apply(stream_, {epoch_, ++version_, node, property, std::move(value)});
  }
  // Publishes a frame that depends on all edits so far. Returns true if it is shown immediately.
  bool publish(const glm::mat4& pose, uint64_t sequence) {
    const std::vector<wire::Affine3x4> poses{affine(pose)};
    wire::PoseFrameView frame;
    frame.header.epoch = epoch_;
    frame.header.sequence = sequence;
    frame.header.scene_version = version_;
    frame.node_count = 1;
    frame.poses = poses;
    return poses_.push(stream_, frame);
  }
  // Draws until the scene is replaced once more. Returns the number of images that showed a pose frame.
  uint64_t wait_for_scene() {
    const uint64_t before = live_.replaced();
    uint64_t shown = 0;
    while (live_.replaced() == before) {
      shown += live_.follow() ? 1 : 0;
      (void)draw();
    }
    return shown;
  }
  sinks::FrameImage draw() {
    return bench_.draw(poses_, camera_.view(poses_, static_cast<float>(kExtent.width) / kExtent.height));
  }
  app::LiveScene& live() { return live_; }
  state::PoseState& poses() { return poses_; }

 private:
  static scene::LoadedScene whole(scene::Scene scene) {
    scene::Derived derived = scene::derive(scene);
    return {std::move(scene), std::move(derived)};
  }

  const scene::LoadedScene base_;
  RenderBench bench_;
  state::PoseState poses_;
  app::CameraRig camera_;
  app::DeviceUploader uploader_;
  app::LiveScene live_;
  uint64_t epoch_ = 0, version_ = 0;
  state::StreamId stream_ = state::kNone;
};

class LiveScenes : public ValidationIsSilent, public ::testing::WithParamInterface<Way> {
 protected:
  static sinks::FrameImage made_so(const scene::Scene& scene) {
    RenderBench bench(scene, kExtent, settings_of(GetParam()));
    return bench.draw_at_rest();
  }
  static std::string file(const char* what) { return std::string("live_") + GetParam().name + "_" + what; }
};

wire::NodeAdded sail_at(const glm::mat4& parent_from_node) {
  wire::NodeAdded sail;
  sail.parent_from_node = affine(parent_from_node);
  sail.asset_glb = triangle_file().glb();
  return sail;
}

class UsersLights : public ValidationIsSilent {};

// The user can change existing lights; a withdrawn light of a stream stays withdrawn.
TEST_F(UsersLights, OneLightPerKindCounts) {
  ViewerDocument show(kConfigurations[1]);
  const uint32_t block = show.poses().names().find("block");
  ASSERT_NE(block, scene::kNone);
  scene::Light bulb;
  bulb.intensity = 7;
  show.live().set_user_edits({{}, scene::kNone, {{block, bulb}}, {}});
  const auto shines = [&] {
    show.live().follow();
    const scene::NodeEdits& edits = show.live().edits().nodes();
    const auto edit = edits.find(block);
    return edit != edits.end() && edit->second.light ? edit->second.light->intensity : 0.0f;
  };
  EXPECT_EQ(shines(), 0);
  show.join({"block"});
  wire::Light of_stream;
  of_stream.kind = wire::LightKind::point;
  of_stream.intensity = 3;
  show.edit("block", wire::Property::light, of_stream);
  EXPECT_EQ(shines(), 7);
  of_stream.kind = wire::LightKind::spot;
  show.edit("block", wire::Property::light, of_stream);
  EXPECT_EQ(shines(), 3);
  show.edit("block", wire::Property::light, wire::Cleared{});
  EXPECT_EQ(shines(), 0);
}

TEST_P(LiveScenes, NodeIsAddedMovedRemoved) {
  ViewerDocument show(GetParam());
  const sinks::FrameImage before = show.draw();
  show.join({"sail"});
  EXPECT_EQ(show.poses().streams()[0].unmatched_names.size(), 1u);
  show.edit("sail", wire::Property::node, sail_at(at({-0.3f, 0.2f, 0.6f})));
  EXPECT_FALSE(show.publish(at({0.3f, 0.1f, 0.8f}), 1)) << "it waits for the node";
  show.live().follow();
  EXPECT_TRUE(matches_image(show.draw(), before, file("meanwhile"), Tolerance::exact()));
  EXPECT_EQ(show.wait_for_scene(), 1u);
  EXPECT_TRUE(show.poses().streams()[0].unmatched_names.empty());
  EXPECT_TRUE(matches_image(show.draw(), made_so(harbour(at({0.3f, 0.1f, 0.8f}))), file("sail"),
                            Tolerance::colour()));

  show.edit("sail", wire::Property::node, wire::NodeRemoved{});
  show.live().follow();  // the build of the next scene is still running
  EXPECT_TRUE(matches_image(show.draw(), before, file("removed"), Tolerance::colour()));
  show.wait_for_scene();
  EXPECT_TRUE(matches_image(show.draw(), before, file("gone"), Tolerance::exact()));
  EXPECT_EQ(show.live().faults().refused, 0u);
  EXPECT_EQ(show.live().faults().unmatched, 0u);
}

class UsersNodes : public ValidationIsSilent {};

// A copy of the pier and a lamp, as a scene that has them; undone, nothing is left.
TEST_F(UsersNodes, AreAddedAndTakenBack) {
  const Way& way = kConfigurations[0];
  ViewerDocument show(way);
  const sinks::FrameImage before = show.draw();
  app::UserEdits edits;
  state::Addition& copy = edits.additions["pier.1"];
  copy.content = state::CopiedNode{"pier"};
  copy.transform.translation = {-0.2f, 0.2f, 1};
  scene::Light bulb;
  bulb.intensity = 2;
  bulb.color = {1, 0.3f, 0.2f};
  state::Addition& lamp = edits.additions["lamp"];
  lamp.content = bulb;
  lamp.transform.translation = {0.4f, 0.8f, 1};
  edits.additions["lost"].content = state::CopiedNode{"nobody"};
  show.live().set_user_edits(edits);
  EXPECT_FALSE(show.live().settled());
  show.live().await_additions();
  ASSERT_EQ(show.live().shown_additions().size(), 2u);
  const std::vector<std::string> messages = show.live().take_log_messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("\"lost\""), std::string::npos) << messages[0];
  scene::Scene with = harbour({});
  scene::Node pier = *std::ranges::find(with.nodes, "pier", &scene::Node::name);
  pier.parent_from_node = pier.world_from_node = at({-0.2f, 0.2f, 1});
  scene::Node lit;
  lit.parent_from_node = lit.world_from_node = at({0.4f, 0.8f, 1});
  lit.light = static_cast<uint32_t>(with.lights.size());
  with.lights.push_back(bulb);
  with.nodes.push_back(lit);
  with.nodes.push_back(pier);
  scene::find_world_bounds(with);
  RenderBench bench(with, kExtent, settings_of(way));
  const sinks::FrameImage made = bench.draw_at_rest();
  EXPECT_TRUE(matches_image(show.draw(), made, "live_user", Tolerance::exact()));
  const uint64_t builds = show.live().builds_begun();
  show.live().follow();
  EXPECT_EQ(show.live().builds_begun(), builds) << "what is refused is not tried with every image";

  show.live().set_user_edits({});
  show.live().follow();  // the build of the next scene is still running
  EXPECT_TRUE(matches_image(show.draw(), before, "live_user_undone", Tolerance::colour()));
  show.wait_for_scene();
  EXPECT_TRUE(matches_image(show.draw(), before, "live_user_gone", Tolerance::exact()));
}

// The user's node keeps its name against that of a stream.
TEST_F(UsersNodes, KeepTheirNames) {
  ViewerDocument show(kConfigurations[1]);
  app::UserEdits edits;
  edits.additions["sail"].content = scene::Light();
  show.live().set_user_edits(edits);
  show.join({"sail"});
  show.edit("sail", wire::Property::node, sail_at(at({-0.3f, 0.2f, 0.6f})));
  show.wait_for_scene();
  EXPECT_EQ(show.live().faults().refused, 1u);
  const uint32_t sail = show.poses().names().find("sail");
  ASSERT_NE(sail, scene::kNone);
  EXPECT_NE(show.live().scene().nodes[sail].light, scene::kNone);
  show.publish(at({3, 0, 0}), 1);
  (void)show.poses().advance(0);
  EXPECT_EQ(show.poses().world_from_node(sail)[3][0], 3) << "streams may move it";
}

TEST_P(LiveScenes, VariantAppliesToAddedNodes) {
  ViewerDocument show(GetParam());
  const sinks::FrameImage before = show.draw();
  const glm::mat4 place = at({0.3f, 0.1f, 0.8f});
  show.join({"sail"});
  show.edit("sail", wire::Property::node, sail_at(glm::mat4(1)));
  show.publish(place, 1);
  show.live().request_variant(0);  // once no build is running
  show.wait_for_scene();
  while (show.live().variant() != 0 || !show.live().settled() || show.live().scene().nodes.size() < 6) {
    show.live().follow();
    (void)show.draw();
  }
  EXPECT_TRUE(matches_image(show.draw(), made_so(harbour(place, glm::mat4(1), true)), file("red_with_sail"),
                            Tolerance::colour()));
  const std::vector<state::AddedMaterials>& added = show.live().added_materials();
  ASSERT_EQ(added.size(), 1u);
  EXPECT_EQ(added[0].owner, "sail");
  EXPECT_EQ(added[0].first + added[0].count, show.live().scene().materials.size());
  show.leave();
  show.live().follow();
  show.wait_for_scene();
  EXPECT_TRUE(
      matches_image(show.draw(), made_so(harbour({}, glm::mat4(1), true)), file("red"), Tolerance::colour()));
  EXPECT_TRUE(added.empty());
  show.live().request_variant(7);  // none: a message, and the variant stays
  show.live().follow();
  EXPECT_EQ(show.live().variant(), 0u);
  EXPECT_EQ(show.live().take_log_messages().size(), 1u);
  show.live().request_variant(scene::kNone);
  show.live().follow();
  EXPECT_TRUE(matches_image(show.draw(), before, file("blue_again"), Tolerance::exact()));
}

TEST_P(LiveScenes, ReplacedVerticesAreRestored) {
  ViewerDocument show(GetParam());
  const sinks::FrameImage before = show.draw();
  const scene::Scene base = harbour({});
  const scene::Primitive& block = base.primitives[base.meshes[base.nodes[1].mesh].first_primitive];
  const auto replaced = [&](const glm::mat4& by) {
    wire::Vertices vertices;
    for (uint32_t v = block.first_vertex; v < block.first_vertex + block.vertex_count; ++v) {
      const glm::vec4 p = by * glm::vec4(base.positions[v], 1);
      vertices.positions.push_back({p.x, p.y, p.z});
    }
    return vertices;
  };
  const glm::mat4 taller = glm::translate(glm::mat4(1), {0.2f, 0.5f, 0}) *
                           glm::scale(glm::mat4(1), glm::vec3(1.2f, 2.5f, 0.8f)),
                  wider = glm::scale(glm::mat4(1), glm::vec3(2, 0.6f, 1.4f));
  show.join({"block"});
  show.edit("block", wire::Property::vertices, replaced(taller));
  show.wait_for_scene();
  EXPECT_TRUE(matches_image(show.draw(), made_so(harbour({}, taller)), file("taller"), Tolerance::colour()));
  const uint64_t scenes = show.live().replaced();
  show.edit("block", wire::Property::vertices, replaced(wider));
  EXPECT_FALSE(show.publish(at({-1, 0.3f, 0}), 1)) << "before anybody looks at the edit";
  EXPECT_TRUE(show.live().follow()) << "at once: the node has its vertices to itself by now";
  EXPECT_TRUE(matches_image(show.draw(), made_so(harbour({}, wider)), file("wider"), Tolerance::colour()));
  EXPECT_EQ(show.live().replaced(), scenes);
  show.leave();
  show.live().follow();
  EXPECT_TRUE(matches_image(show.draw(), before, file("own_shape"), Tolerance::colour()));
  show.wait_for_scene();
  EXPECT_TRUE(matches_image(show.draw(), before, file("own_shape_again"), Tolerance::exact()));
}

INSTANTIATE_TEST_SUITE_P(Ways, LiveScenes, ::testing::ValuesIn(kConfigurations),
                         [](const auto& way) { return std::string(way.param.name); });

class LiveScenesOnce : public ValidationIsSilent {};

TEST_F(LiveScenesOnce, NothingIsLeftBehind) {
  ViewerDocument show(kConfigurations[0]);
  const auto settled = [&] {
    for (int frame = 0; frame < 3; ++frame) (void)show.draw();
    device().retire_all_now();
    return device().live_objects();
  };
  const gpu::LiveObjects before = settled();
  for (int i = 0; i < 3; ++i) {
    show.join({"sail"});
    show.edit("sail", wire::Property::node, sail_at(glm::mat4(1)));
    show.edit("mast", wire::Property::node, wire::NodeAdded{});
    show.edit("nowhere", wire::Property::node, wire::NodeAdded{"nobody", {}, "", {}});
    show.wait_for_scene();
    show.leave();
    show.wait_for_scene();
  }
  EXPECT_EQ(settled(), before);
  EXPECT_EQ(show.live().faults().refused, 3u);
  EXPECT_GT(show.live().take_log_messages().size(), 0u);
}

// Images of the scene before are shared, not uploaded again; changed pixels are other ones.
TEST_F(LiveScenesOnce, ImagesStayOnDevice) {
  SceneBuilder builder;
  scene::Material checked = matte({1, 1, 1});
  checked.base_color_texture.texture = builder.texture(16, 16, true, [](float u, float v) {
    return glm::vec4((u < 0.5f) == (v < 0.5f) ? 0.2f : 0.9f, 0.4f, 0.6f, 1);
  });
  builder.mesh_node("ground", builder.quad(builder.material(checked), 20), glm::mat4(1));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.5f, -1, -0.6f}));
  builder.camera_node("camera", {0.5f, 1.8f, 4}, {0, 0.5f, 0});
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, kExtent, settings_of(kConfigurations[0]));
  const sinks::FrameImage before = bench.draw_at_rest();
  const auto image = [&] { return bench.renderer().gpu_scene().scene_textures.images.at(0).image; };
  const std::shared_ptr<gpu::Image> first = image();
  const scene::Scene copy = scene;
  bench.renderer().set_scene(copy);
  EXPECT_EQ(image(), first);
  EXPECT_EQ(bench.draw_at_rest().rgba8, before.rgba8);
  scene::Scene changed = scene;
  for (uint8_t& value : changed.images[0].rgba8.edit()) value = 255;
  bench.renderer().set_scene(changed);
  EXPECT_NE(image(), first);
  EXPECT_NE(bench.draw_at_rest().rgba8, before.rgba8);
}

// The device has no memory for what one stream adds: the node is refused, the image stays as it was, and what
// comes later is shown.
TEST_F(LiveScenesOnce, OutOfMemoryKeepsImage) {
  ViewerDocument show(kConfigurations[0]);
  show.join({"sail"});
  show.edit("mast", wire::Property::node, sail_at(at({1, 0.5f, 0})));
  show.wait_for_scene();
  const sinks::FrameImage before = show.draw();
  const uint64_t scenes = show.live().replaced();
  show.edit("sail", wire::Property::node, sail_at(at({-0.3f, 0.2f, 0.6f})));
  while (show.live().builds_begun() < 2) show.live().follow();
  device().fail_allocation_after(5);
  while (!show.live().settled() || !device().has_failed_allocation()) {
    ASSERT_EQ(show.live().replaced(), scenes);
    show.live().follow();
  }
  device().fail_allocation_after(UINT64_MAX - 1);
  show.live().follow();
  EXPECT_EQ(show.live().replaced(), scenes);
  EXPECT_EQ(show.live().faults().refused, 1u);
  const std::vector<std::string> notes = show.live().take_log_messages();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("\"sail\""), std::string::npos);
  EXPECT_NE(notes[0].find("memory"), std::string::npos);
  EXPECT_EQ(show.draw().rgba8, before.rgba8);
  show.edit("flag", wire::Property::node, sail_at(at({0, 1, 0})));
  show.wait_for_scene();
  EXPECT_NE(show.draw().rgba8, before.rgba8);
  EXPECT_EQ(show.live().faults().refused, 1u);
}

// Each node's parent is in the asset of the other stream, so the node whose asset is loaded first waits for
// the next turn. When both streams have left, that asset is released although no scene is built any more.
TEST_F(LiveScenesOnce, WaitingAssetEndsWithStream) {
  ViewerDocument show(kConfigurations[1]);
  const std::shared_ptr<BudgetPool> pool = BudgetPool::create();
  const auto add_stream = [&](uint64_t epoch, const std::string& node, const std::string& parent) {
    wire::StreamDescription description;
    description.epoch = epoch;
    const state::StreamId stream = show.poses().add_stream(description, pool->add_peer(node));
    wire::NodeAdded added = sail_at(glm::mat4(1));
    added.parent = parent;
    show.poses().apply(stream, {epoch, 1, node, wire::Property::node, std::move(added)});
    return stream;
  };
  const state::StreamId left = add_stream(1, "left", "right/triangle"),
                        right = add_stream(2, "right", "left/triangle");
  show.live().follow();
  ASSERT_EQ(show.live().builds_begun(), 1u);
  while (pool->used(Resource::asset_bytes) == 0) std::this_thread::yield();
  show.poses().remove_stream(left);
  show.poses().remove_stream(right);
  // The outcome is the same however long the build takes: no second one begins, and nothing stays charged.
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (pool->used(Resource::asset_bytes) > 0) {
    ASSERT_LT(std::chrono::steady_clock::now(), give_up) << pool->used(Resource::asset_bytes) << " bytes";
    show.live().follow();
  }
  EXPECT_EQ(show.live().builds_begun(), 1u);
  EXPECT_EQ(show.live().replaced(), 0u);
}

// Hiding and showing one of many added nodes builds no scene and does not rebuild the list of added nodes.
TEST_F(LiveScenesOnce, AddedVisibilityBuildsNothing) {
  ViewerDocument show(kConfigurations[1]);
  show.join({"sail"});
  for (int i = 0; i < 500; ++i)
    show.edit("empty" + std::to_string(i), wire::Property::node, wire::NodeAdded{});
  show.wait_for_scene();
  while (!show.live().settled()) show.live().follow();
  const uint64_t builds = show.live().builds_begun(), lists = show.live().request_lists_made();
  for (int i = 0; i < 20; ++i) {
    show.edit("empty7", wire::Property::visible, wire::Visible{i % 2 == 1});
    show.live().follow();
    const uint32_t node = show.poses().names().find("empty7");
    EXPECT_EQ(show.live().edits().is_hidden(node), i % 2 == 0);
  }
  EXPECT_EQ(show.live().builds_begun(), builds);
  EXPECT_EQ(show.live().request_lists_made(), lists);
}

}  // namespace
}  // namespace fire3dv::test
