// Test of the AMBF camera file reader: poses, parents and lenses.
#include "adapters/ambf/nodes.h"

#include <gtest/gtest.h>

#include "tests/support/gltf_builder.h"

namespace fire3dv::ambf {
namespace {

class AmbfCameras : public testing::Test {
 protected:
  CameraDefinitions read(const char* world, const char* model = "bodies: []\n") {
    Launch launch;
    launch.world = scratch_.write("world.yaml", std::string_view(world));
    launch.models = {scratch_.write("model.yaml", std::string_view(model))};
    launch.name_space = name_space_;
    return read_cameras(launch);
  }
  test::ScratchFolder scratch_;
  std::string name_space_;
};

TEST_F(AmbfCameras, FilesResolveAnchorsNamespacesDefaults) {
  const auto found = read(R"(
namespace: /ambf//env/
cameras: [main camera, side]
common: &lens 1.2
main camera:
  namespace: cameras/
  name: the camera
  location: {x: 2.0, y: 0.0, z: 0.5}
  look at: {x: 0.0, y: 0.0, z: 0.5}
  up: {x: 0, y: 0, z: 1}
  clipping plane: {near: 0.001, far: 20.0}
  field view angle: *lens
  parent: BODY Head
side:
  name: side
  location: {x: 0, y: 3, z: 0}
  orthographic view width: 2
unlisted: {location: {x: 1, y: 1, z: 1}}
)",
                          R"(
namespace: /robot/
cameras: [eye, eye]
eye: {namespace: /absolute/, name: eye, location: {x: 0, y: 0, z: 1}, look at: {x: 1, y: 0, z: 1},
      stereo: {mode: PASSIVE, eye separation: 0.1, focal length: 1}}
)");
  EXPECT_TRUE(found.warnings.empty());
  ASSERT_EQ(found.cameras.size(), 4u);
  const CameraDefinition& camera = found.cameras[0];
  EXPECT_EQ(camera.key, "/ambf/env/cameras/main camera");
  EXPECT_EQ(camera.name, "/ambf/env/cameras/thecamera");
  EXPECT_EQ(camera.parent, "BODY Head");
  EXPECT_EQ(camera.intrinsics, (Intrinsics{1.2, 0.001, 20, false}));
  // An AMBF camera looks along its -X: here the world's -X.
  const Transform expected{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {2, 0, 0.5, 1}}};
  for (size_t column = 0; column < 4; ++column) {
    for (size_t row = 0; row < 3; ++row)
      EXPECT_DOUBLE_EQ(camera.parent_from_camera.m[column][row], expected.m[column][row]);
  }
  EXPECT_EQ(found.cameras[1].intrinsics, std::nullopt);
  EXPECT_EQ(found.cameras[2].key, "/absolute/eye");
  EXPECT_EQ(found.cameras[3].key, "/absolute/eye1") << "as AMBF distinguishes the two";
  EXPECT_EQ(found.cameras[2].intrinsics, (Intrinsics{0.7, 0.1, 10, true}));
  EXPECT_DOUBLE_EQ(found.cameras[2].parent_from_camera.m[0][0], -1) << "it looks along +X";
}

TEST_F(AmbfCameras, WorldCamerasAreNamespaced) {
  scratch_.write("floor.yaml",
                 std::string_view("namespace: /f/\ncameras: [c]\nc: {location: {x: 1, y: 0, z: 0}}\n"));
  name_space_ = "/pre";
  const auto found = read("environment: floor.yaml\ncameras: [d]\nd: {location: {x: 1, y: 0, z: 0}}\n");
  ASSERT_EQ(found.cameras.size(), 2u);
  EXPECT_EQ(found.cameras[0].key, "/pre/f/c");
  EXPECT_EQ(found.cameras[1].key, "/pred") << "as AMBF joins them";
}

TEST_F(AmbfCameras, ListedCamerasKeepOrder) {
  scratch_.write("floor.yaml", std::string_view("bodies: [BODY a]\nBODY a: {name: a}\n"));
  const auto found = read(R"(
environment: floor.yaml
cameras: [c]
lights: [l]
c: {location: {x: 1, y: 0, z: 0}}
l: {location: {x: 1, y: 0, z: 0}}
)",
                          R"(
namespace: /m/
cameras: [c]
soft bodies: [s]
ghost objects: [g]
bodies: [b, b, missing, [no name]]
b: {namespace: n/, name: b}
s: {name: s}
g: {name: g}
c: {location: {x: 1, y: 0, z: 0}}
)");
  std::vector<std::string> keys;
  for (const Listed& listed : found.listed) keys.push_back(listed.key);
  EXPECT_EQ(keys,
            (std::vector<std::string>{"BODY a", "l", "c", "/m/n/b", "/m/n/b1", "/m/s", "/m/g", "/m/c"}));
  EXPECT_TRUE(found.warnings.empty());
}

TEST_F(AmbfCameras, BrokenOneCostsItselfAlone) {
  const auto found = read(R"(
cameras: [none, bad, good]
bad: {location: {x: here, y: 0, z: 0}}
good: {location: {x: 1, y: 0, z: 0}}
)",
                          "cameras: [a\nb: }");
  ASSERT_EQ(found.cameras.size(), 1u);
  EXPECT_EQ(found.cameras[0].key, "good");
  ASSERT_EQ(found.warnings.size(), 2u);
  EXPECT_NE(found.warnings[0].find("camera bad"), std::string::npos);
  EXPECT_NE(found.warnings[1].find("model.yaml"), std::string::npos);
}

TEST(AmbfNodes, ParentMatchesKeyOrPart) {
  const std::vector<Object> objects{{Kind::rigid_body, "/a/BODY Head lamp", ""},
                                    {Kind::rigid_body, "/a/BODY Head", ""},
                                    {Kind::soft_body, "/a/SOFT Hat", ""},
                                    {Kind::ghost_object, "/a/GHOST Hat", ""},
                                    {Kind::camera, "eye", ""}};
  const std::vector<size_t> eye_last{0, 1, 2, 3, 4}, eye_first{4, 3, 1, 0, 2}, eye_between{0, 1, 4, 3, 2};
  const auto parent = [&](const std::vector<size_t>& added, const std::string& name) {
    return find_parent(objects, added, 4, name);
  };
  EXPECT_EQ(parent(eye_last, "/a/BODY Head"), 1u) << "the whole name, though another has it in its own";
  EXPECT_EQ(parent(eye_last, "BODY Head"), std::nullopt) << "a part of two names";
  EXPECT_EQ(parent(eye_last, "lamp"), 0u);
  EXPECT_EQ(parent(eye_last, "SOFT"), 2u);
  EXPECT_EQ(parent(eye_last, "Hat"), std::nullopt) << "two kinds answer";
  EXPECT_EQ(parent(eye_first, "BODY Head"), 1u) << "the first that is added later";
  EXPECT_EQ(parent(eye_first, "Hat"), 3u);
  EXPECT_EQ(parent(eye_between, "Head"), std::nullopt);
  EXPECT_EQ(parent(eye_between, "a/"), 3u) << "two before it are no answer, so what comes after is";
  EXPECT_EQ(parent(eye_last, "eye"), std::nullopt) << "nobody is their own";
  EXPECT_EQ(parent(eye_last, "BODY Foot"), std::nullopt);
  EXPECT_EQ(parent(eye_last, ""), std::nullopt);
}

TEST(AmbfNodes, InvalidNamesAreSkipped) {
  const std::vector<Object> objects{{Kind::rigid_body, "/a/BODY one", "/a/same"},
                                    {Kind::ghost_object, "/a/BODY one", "/a/other"},
                                    {Kind::rigid_body, "/a/\x1b[2J", "/a/same"},
                                    {Kind::light, "", "/a/light"},
                                    {Kind::camera, std::string(5000, 'x'), "/a/camera"}};
  const NodeTable by_key(objects, Options::Names::key);
  EXPECT_EQ(by_key.names(), std::vector<std::string>{"/a/BODY one"});
  EXPECT_EQ(by_key.warnings().size(), 4u);
  EXPECT_EQ(by_key.node_of(0), 0u);
  EXPECT_EQ(by_key.node_of(4), std::nullopt);
  const NodeTable by_name(objects, Options::Names::name);
  EXPECT_EQ(by_name.names(), (std::vector<std::string>{"/a/same", "/a/other", "/a/light", "/a/camera"}));
  EXPECT_EQ(by_name.node_of(4), 3u);
}

}  // namespace
}  // namespace fire3dv::ambf
