// Test of the plugin's session without AMBF: camera parents, non-finite poses, and meshes of soft bodies.
#include "adapters/ambf/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/unit/adapters/generic/client_fixture.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::ambf {
namespace {

Transform at(double x, double y, double z) {
  Transform frame;
  frame.m[3][0] = x;
  frame.m[3][1] = y;
  frame.m[3][2] = z;
  return frame;
}

CameraDefinition camera(const std::string& key, const std::string& parent,
                        const Transform& parent_from_camera) {
  return {key, key, parent, parent_from_camera, Intrinsics()};
}

class AmbfSession : public testing::Test {
 protected:
  AmbfSession() : uri_(test::unique_shm_uri()), renderer_(uri_) {}

  void start(std::vector<CameraDefinition> cameras, std::vector<Object> objects) {
    Options options;
    options.uris = {uri_};
    Links links;
    const auto opened = links.open(options);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    CameraDefinitions definitions;
    definitions.listed = std::move(listed_);
    definitions.cameras = std::move(cameras);
    session_ = std::make_unique<Session>(options, std::move(definitions), std::move(links));
    ASSERT_TRUE(session_->begin_turn(0));
    session_->describe(std::move(objects));
    session_->end_turn();
  }
  // Publishes the current frame and waits for it.
  void show() {
    ASSERT_TRUE(session_->begin_turn(0));
    session_->publish(1.5, 0);
    session_->end_turn();
    const uint64_t before = renderer_.sequence;
    ASSERT_TRUE(test::repeat_until([&] {
      renderer_.poll();
      return renderer_.sequence > before;
    }));
  }
  std::array<float, 3> place_of(size_t node) {
    const auto& m = renderer_.poses.at(node).m;
    return {m[3], m[7], m[11]};
  }

  std::string uri_;
  test::Renderer renderer_;
  std::vector<Listed> listed_;
  std::unique_ptr<Session> session_;
};

TEST_F(AmbfSession, CameraParentsAreResolved) {
  Transform quarter;  // about Z
  quarter.m[0][0] = quarter.m[1][1] = 0;
  quarter.m[0][1] = 1;
  quarter.m[1][0] = -1;
  const Transform world_from_head = at(10, 0, 0) * quarter;
  start({camera("on body", "Head", at(1, 0, 0)), camera("on camera", "on body", at(0, 0, 2)),
         camera("free", "", at(0, 0, 5)), camera("lost", "Nobody", at(0, 7, 0)),
         camera("ring", "ring ", at(1, 1, 1)), camera("ring 2", "ring 3", at(1, 0, 0)),
         camera("ring 3", "ring 2", at(0, 1, 0))},
        {{Kind::rigid_body, "BODY Head", "head"}});
  session_->set_pose(0, world_from_head);
  show();
  ASSERT_EQ(renderer_.descriptions.back().node_names.size(), 8u);
  using Place = std::array<float, 3>;
  EXPECT_EQ(place_of(0), (Place{10, 0, 0}));
  EXPECT_EQ(place_of(1), (Place{10, 1, 0}));
  EXPECT_EQ(place_of(2), (Place{10, 1, 2}));
  EXPECT_EQ(place_of(3), (Place{0, 0, 5}));
  EXPECT_EQ(place_of(4), (Place{0, 7, 0}));
}

TEST_F(AmbfSession, WorldCameraUsesNextBody) {
  listed_ = {{Kind::camera, "eye"}, {Kind::soft_body, "z tool"}, {Kind::rigid_body, "a tool"}};
  start({camera("eye", "tool", at(0, 0, 1))},
        {{Kind::rigid_body, "a tool", ""}, {Kind::soft_body, "z tool", ""}});
  session_->set_pose(0, at(1, 0, 0));
  session_->set_pose(1, at(2, 0, 0));
  show();
  ASSERT_EQ(renderer_.descriptions.back().node_names, (std::vector<std::string>{"a tool", "eye"}));
  EXPECT_EQ(place_of(1), (std::array<float, 3>{2, 0, 1})) << "soft bodies count, and are no nodes";
}

TEST_F(AmbfSession, InvalidPoseKeepsLastPose) {
  start({}, {{Kind::rigid_body, "a", "a"}, {Kind::rigid_body, "b", "b"}});
  session_->set_pose(0, at(1, 2, 3));
  session_->set_pose(1, at(4, 5, 6));
  show();
  session_->set_pose(0, at(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  session_->set_pose(1, at(7, 8, 9));
  show();
  EXPECT_EQ(place_of(0), (std::array<float, 3>{1, 2, 3}));
  EXPECT_EQ(place_of(1), (std::array<float, 3>{7, 8, 9}));
  session_->set_pose(0, at(1e300, 0, 0));
  show();
  EXPECT_EQ(place_of(0), (std::array<float, 3>{1, 2, 3}));
}

TEST_F(AmbfSession, TurnsAreExclusive) {
  start({}, {{Kind::rigid_body, "a", "a"}});
  show();
  ASSERT_TRUE(session_->begin_turn(0));
  std::thread([&] { EXPECT_FALSE(session_->begin_turn(0)); }).join();
  session_->end_turn();
  session_->close();
  EXPECT_FALSE(session_->begin_turn(0));
  ASSERT_TRUE(test::repeat_until([&] {
    renderer_.poll();
    return renderer_.ended;
  }));
}

TEST(AmbfLinks, AlternatingFailuresAreLoggedOnce) {
  const std::string uri = test::unique_shm_uri();
  Options options;
  options.uris = {uri};
  Links links;
  ASSERT_TRUE(links.open(options).ok());
  testing::internal::CaptureStderr();
  const auto fail_with = [&](int property) {
    links.edit([&](fire3dv_stream* stream) {
      return property < 0 ? fire3dv_clear(stream, "a", property) : fire3dv_clear(stream, "", property);
    });
  };
  for (int i = 0; i < 1000; ++i) fail_with(i % 2 == 0 ? -1 : 0);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 2) << said;
}

TEST(AmbfSoftMesh, GltfKeepsPhysicsVertexOrder) {
  SoftMesh mesh;
  mesh.name = "/a/\"BODY\" cloth";
  mesh.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 3};
  mesh.triangles = {0, 1, 2, 0, 1, 3};
  const std::vector<std::byte> glb = soft_mesh_glb(mesh);
  const test::ScratchFolder folder;
  const auto scene = scene::load_gltf(folder.write("soft.glb", std::span<const std::byte>(glb)));
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->nodes.size(), 1u);
  EXPECT_EQ(soft_vertices_path(mesh.name), "~1a~1\"BODY\" cloth (soft body)/" + scene->nodes[0].path);
  // AMBF's up axis (Z) maps to glTF's (Y).
  EXPECT_NEAR(scene->bounds_max.y, 3, 1e-5);
  EXPECT_NEAR(scene->bounds_min.z, -1, 1e-5);
}

TEST(AmbfSoftMesh, SurfacelessBodyHasNone) {
  SoftMesh mesh;
  EXPECT_TRUE(soft_mesh_glb(mesh).empty());
  mesh.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_TRUE(soft_mesh_glb(mesh).empty());
  mesh.triangles = {0, 1, 3};
  EXPECT_TRUE(soft_mesh_glb(mesh).empty()) << "there is no vertex 3";
  mesh.triangles = {0, 1, 2};
  EXPECT_FALSE(soft_mesh_glb(mesh).empty());
  mesh.positions[4] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(soft_mesh_glb(mesh).empty());
}

}  // namespace
}  // namespace fire3dv::ambf
