// Test of the AMBF plugin in a world of the API stub: messages over shared memory equal the world's state.
#include <cmath>
#include <thread>

#include "tests/unit/adapters/ambf/plugin_world.h"
#include "tests/unit/allocation_count.h"

namespace fire3dv::test {
namespace {

using Place = std::array<float, 3>;
Place place_of(const wire::Affine3x4& pose) {
  return {pose.m[3], pose.m[7], pose.m[11]};
}

class AmbfPlugin : public testing::Test {
 protected:
  AmbfPlugin() : uri_(ambf_uri()), renderer_(uri_), ambf_(uri_) {}
  void step() {
    ambf_.step();
    ASSERT_TRUE(renderer_.shows(ambf_.world.time_s));
  }
  std::string uri_;
  AmbfRenderer renderer_;
  AmbfWorld ambf_;
};

TEST_F(AmbfPlugin, PosesAreSentByKey) {
  auto* const one = ambf_.body("/ambf/env/BODY one");
  auto* const two = ambf_.body("/ambf/env/BODY two");
  one->local = odd_frame(1);
  two->local = odd_frame(-20);
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  step();
  ASSERT_EQ(renderer_.names(), (std::vector<std::string>{"/ambf/env/BODY one", "/ambf/env/BODY two"}));
  for (auto* const body : {one, two}) {
    const auto& pose = renderer_.pose(body == one ? "/ambf/env/BODY one" : "/ambf/env/BODY two");
    for (size_t row = 0; row < 3; ++row) {
      for (size_t column = 0; column < 4; ++column)
        EXPECT_EQ(pose.m[row * 4 + column], static_cast<float>(body->local.m[column][row]));
    }
  }
  EXPECT_TRUE(renderer_.descriptions.back().body_from_node.empty());
  // Z up to Y up: the Z axis of the stream maps to the Y axis of the world.
  const auto& basis = renderer_.descriptions.back().world_from_stream.m;
  EXPECT_EQ((std::array<double, 3>{basis[2], basis[6], basis[10]}), (std::array<double, 3>{0, 1, 0}));
}

TEST_F(AmbfPlugin, ChildPosesAreInWorld) {
  auto* const head = ambf_.body("head");
  auto* const ghost = ambf_.add<ambf::afGhostObject>(ambf_.world.ghosts, "ghost");
  auto* const light = ambf_.add<ambf::afLight>(ambf_.world.lights, "light");
  place(*head, 10, 0, 1);
  head->local.m[0][0] = head->local.m[1][1] = 0;
  head->local.m[0][1] = 1;
  head->local.m[1][0] = -1;
  place(*ghost, 2, 0, 0);
  ghost->parent = head;
  place(*light, 0, 0, 3);
  light->parent = ghost;
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  step();
  EXPECT_EQ(place_of(renderer_.pose("ghost")), (Place{10, 2, 1}));
  EXPECT_EQ(place_of(renderer_.pose("light")), (Place{10, 2, 4}));
  head->parent = light;  // a cycle of parents
  ASSERT_NO_FATAL_FAILURE(step());
}

TEST_F(AmbfPlugin, LensChangesAreSent) {
  ambf_.world.headless = false;
  auto* const camera = ambf_.add<ambf::afCamera>(ambf_.world.cameras, "eye");
  auto* const flat = ambf_.add<ambf::afCamera>(ambf_.world.cameras, "flat");
  flat->orthographic = true;
  camera->vertical_fov_rad = 1.2;
  camera->inner.near_m = 0.001;
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  step();
  const auto key = std::make_pair(std::string("eye#view"), wire::Property::camera);
  ASSERT_TRUE(renderer_.poll_until([&] { return renderer_.edits.count(key) == 1; }));
  EXPECT_EQ(std::get<wire::Camera>(renderer_.edits[key]), (wire::Camera{1.2f, 0.001f, 10, 0}));
  EXPECT_EQ(renderer_.edits.count({"eye#left", wire::Property::camera}), 0u);
  camera->vertical_fov_rad = 0.5;
  camera->m_stereoMode = chai3d::C_STEREO_PASSIVE_LEFT_RIGHT;
  step();
  EXPECT_TRUE(renderer_.poll_until(
      [&] { return std::get<wire::Camera>(renderer_.edits[key]).vertical_fov_rad == 0.5f; }));
  EXPECT_TRUE(renderer_.poll_until([&] { return renderer_.edits.count({"eye#right", key.second}) == 1; }));
  EXPECT_EQ(renderer_.edits.count({"flat#view", wire::Property::camera}), 0u) << "no lens is like its";
}

TEST_F(AmbfPlugin, VisibilityChangesAreSent) {
  auto* const body = ambf_.body("door");
  auto* const ghost = ambf_.add<ambf::afGhostObject>(ambf_.world.ghosts, "ghost");
  ambf_.body("bare")->m_visualMesh = nullptr;
  ghost->m_visualMesh->shown = false;
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  step();
  const auto visible = [&](const char* name) {
    const auto found = renderer_.edits.find({name, wire::Property::visible});
    return found == renderer_.edits.end() || std::get<wire::Visible>(found->second).visible;
  };
  EXPECT_TRUE(renderer_.poll_until([&] { return !visible("ghost"); }));
  EXPECT_EQ(renderer_.edits.size(), 1u) << "what is shown from the first is not worth an edit";
  body->m_visualMesh->shown = false;
  step();
  EXPECT_TRUE(renderer_.poll_until([&] { return !visible("door"); }));
  body->m_visualMesh->shown = true;
  step();
  EXPECT_TRUE(renderer_.poll_until([&] { return visible("door"); }));
}

TEST_F(AmbfPlugin, ModelChangesAreDescribedAgain) {
  ambf_.body("a");
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  step();
  ambf_.body("b")->local = odd_frame(3);
  step();
  ASSERT_TRUE(renderer_.poll_until([&] { return renderer_.descriptions.size() == 2; }));
  EXPECT_EQ(renderer_.names(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(renderer_.pose("b").m[0], 3.0f);
  EXPECT_NE(renderer_.descriptions[0].epoch, renderer_.descriptions[1].epoch);
  // The same number of bodies as before, with another one.
  ambf_.world.bodies.erase("a");
  ambf_.body("c");
  step();
  ASSERT_TRUE(renderer_.poll_until([&] { return renderer_.descriptions.size() == 3; }));
  EXPECT_EQ(renderer_.names(), (std::vector<std::string>{"b", "c"}));
}

TEST_F(AmbfPlugin, ReturningNodeIsRestored) {
  auto* const door = ambf_.body("door");
  ambf_.body("wall");
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  step();
  const auto visible = [&](const char* name) {
    const auto found = renderer_.edits.find({name, wire::Property::visible});
    return found == renderer_.edits.end() || std::get<wire::Visible>(found->second).visible;
  };
  door->m_visualMesh->shown = false;
  step();
  ASSERT_TRUE(renderer_.poll_until([&] { return !visible("door"); }));
  auto others = ambf_.world.bodies;
  ambf_.world.bodies.erase("door");
  ambf_.world.bodies.erase("wall");
  ambf_.body("new");
  others["new"] = ambf_.world.bodies["new"];
  step();
  ASSERT_TRUE(renderer_.poll_until([&] { return !visible("wall"); })) << "it is not in AMBF's window";
  EXPECT_TRUE(visible("new"));

  door->m_visualMesh->shown = true;
  ambf_.world.bodies = others;
  step();
  EXPECT_TRUE(renderer_.poll_until([&] { return visible("wall") && visible("door"); }))
      << "what hides them outlives a description";
}

TEST_F(AmbfPlugin, ResetIsDiscontinuity) {
  auto* const body = ambf_.body("a");
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  for (int i = 0; i < 3; ++i) step();
  EXPECT_EQ(renderer_.frames.back().flags & wire::kFrameDiscontinuity, 0u);
  ambf_.plugin()->reset();
  step();
  EXPECT_EQ(renderer_.frames.back().flags & wire::kFrameDiscontinuity, wire::kFrameDiscontinuity);
  step();
  EXPECT_EQ(renderer_.frames.back().flags & wire::kFrameDiscontinuity, 0u);

  const size_t before = renderer_.frames.size();
  ambf_.plugin()->graphicsUpdate();
  ambf_.world.paused = true;
  place(*body, 1, 2, 3);
  ambf_.plugin()->graphicsUpdate();
  ASSERT_TRUE(renderer_.poll_until([&] { return renderer_.frames.size() > before; }));
  renderer_.poll();
  EXPECT_EQ(renderer_.frames.size(), before + 1) << "the window's turn is a pause alone";
  EXPECT_EQ(place_of(renderer_.pose("a")), (Place{1, 2, 3}));
}

TEST_F(AmbfPlugin, SoftBodyVerticesFollow) {
  auto* const cloth = ambf_.add<ambf::afSoftBody>(ambf_.world.soft_bodies, "a/cloth");
  ambf_.body("a");
  btSoftBody soft;
  soft.m_nodes.items.resize(4);
  for (size_t i = 1; i < 4; ++i) soft.m_nodes.items[i].m_x.values[i - 1] = 1;
  auto* const n = soft.m_nodes.items.data();
  soft.m_faces.items = {{{n, n + 1, n + 2}}, {{n, n + 3, n + 1}}};
  cloth->m_bulletSoftBody = &soft;
  ASSERT_EQ(ambf_.init({"--fire3dv-vertex-rate=0"}), ambf::SUCCESS);
  step();
  n[3].m_x.values[2] = 7;
  step();
  const auto key = std::make_pair(std::string("a~1cloth (soft body)/vertices"), wire::Property::vertices);
  ASSERT_TRUE(renderer_.poll_until([&] {
    const auto found = renderer_.edits.find(key);
    return found != renderer_.edits.end() &&
           std::get<wire::Vertices>(found->second).positions[3] == std::array<float, 3>{0, 0, 7};
  }));
  EXPECT_TRUE(std::holds_alternative<wire::NodeRemoved>(renderer_.edits[{"a/cloth", wire::Property::node}]));
  const auto& added =
      std::get<wire::NodeAdded>(renderer_.edits[{"a/cloth (soft body)", wire::Property::node}]);
  EXPECT_FALSE(added.asset_glb.empty());
}

TEST_F(AmbfPlugin, MeshlessSoftBodySendsNothing) {
  auto* const cloth = ambf_.add<ambf::afSoftBody>(ambf_.world.soft_bodies, "cloth");
  auto* const points = ambf_.add<ambf::afSoftBody>(ambf_.world.soft_bodies, "points");
  ambf_.body("a");
  btSoftBody soft, no_surface;
  soft.m_nodes.items.resize(3);
  no_surface.m_nodes.items.resize(3);
  auto* const n = soft.m_nodes.items.data();
  n[1].m_x.values[0] = n[2].m_x.values[1] = 1;
  soft.m_faces.items = {{{n, n + 1, n + 2}}};
  cloth->m_bulletSoftBody = &soft;
  points->m_bulletSoftBody = &no_surface;
  ASSERT_EQ(ambf_.init({"--fire3dv-vertex-rate=0", "--fire3dv-names=name"}), ambf::SUCCESS);
  step();
  const std::string name = "cloth.name (soft body)", vertices = name + "/vertices";
  const auto has = [&]<typename Value>(const std::string& node, wire::Property property) {
    const auto found = renderer_.edits.find({node, property});
    return found != renderer_.edits.end() && std::holds_alternative<Value>(found->second);
  };
  using wire::Property;
  ASSERT_TRUE(
      renderer_.poll_until([&] { return has.operator()<wire::Vertices>(vertices, Property::vertices); }));
  EXPECT_TRUE(has.operator()<wire::NodeRemoved>("cloth.name", Property::node));
  EXPECT_TRUE(has.operator()<wire::NodeAdded>(name, Property::node));
  for (const auto& [key, value] : renderer_.edits)
    EXPECT_EQ(key.first.find("points"), std::string::npos) << key.first;

  ambf_.world.soft_bodies.erase("cloth");
  step();
  EXPECT_TRUE(renderer_.poll_until([&] { return has.operator()<wire::Cleared>(name, Property::node); }));
  EXPECT_TRUE(has.operator()<wire::Cleared>(vertices, Property::vertices));
  EXPECT_TRUE(has.operator()<wire::NodeRemoved>("cloth.name", Property::node)) << "AMBF does not show it";
}

TEST_F(AmbfPlugin, StartWithoutRendererReportsGaps) {
  ambf_.body("a");
  testing::internal::CaptureStderr();
  EXPECT_EQ(ambf_.init({"--fire3dv-rate=often"}), ambf::ERROR);
  std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("--fire3dv-rate is 'often'; it takes"), std::string::npos) << said;
  EXPECT_NE(said.find("AMBF continues without"), std::string::npos) << said;
  ambf_.plugin()->physicsUpdate(0.001);  // AMBF does not call it then; the call must have no effect
  ambf_.end();
  AmbfWorld nobody_listens("tcp://127.0.0.1:9");
  nobody_listens.body("a");
  testing::internal::CaptureStderr();
  const int begun = nobody_listens.init();
  said = testing::internal::GetCapturedStderr();
  ASSERT_EQ(begun, ambf::SUCCESS);
  EXPECT_NE(said.find("/nowhere/launch.yaml"), std::string::npos)
      << "the launch file cannot be read: " << said;
  EXPECT_NE(said.find("its options and cameras are left out"), std::string::npos) << said;
  for (int i = 0; i < 10; ++i) nobody_listens.step();
}

TEST_F(AmbfPlugin, IsLoadedOnceInProcess) {
  ambf_.body("a");
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  AmbfWorld again(ambf_uri());
  EXPECT_EQ(again.init(), ambf::ERROR);
  again.end();
  step();
  ambf_.end();
  EXPECT_EQ(ambf_.init(), ambf::SUCCESS) << "the end makes room";
}

TEST_F(AmbfPlugin, TopicNamesAreAccepted) {
  ambf_.body("/ambf/env/BODY one");
  ASSERT_EQ(ambf_.init({"--fire3dv-names", "name"}), ambf::SUCCESS);
  step();
  EXPECT_EQ(renderer_.names(), std::vector<std::string>{"/ambf/env/BODY one.name"});
}

TEST_F(AmbfPlugin, StepsAllocateNothing) {
  for (int i = 0; i < 100; ++i) ambf_.body("/ambf/env/BODY " + std::to_string(i));
  ASSERT_EQ(ambf_.init(), ambf::SUCCESS);
  for (int i = 0; i < 10; ++i) ambf_.step();
  // Once a second the plugin polls for log messages, which may allocate in one of these batches.
  uint64_t fewest = ~0ull;
  double fastest_us = 1e9;
  for (int batch = 0; batch < 5; ++batch) {
    const uint64_t before = allocations_of_this_thread();
    ASSERT_GT(before, 0u) << "the counter counts nothing";
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 200; ++i) ambf_.step();
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
    fewest = std::min(fewest, allocations_of_this_thread() - before);
    fastest_us = std::min(fastest_us, took.count() / 200);
  }
  EXPECT_EQ(fewest, 0u);
  RecordProperty("us_a_step_of_100_bodies", std::to_string(fastest_us));
}

}  // namespace
}  // namespace fire3dv::test
