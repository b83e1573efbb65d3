// Test of scene edits and partial frames through the client library: edits arrive, and invalid ones are
// refused with a message.
#include "fire3dv/scene.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

#include "fire3dv/client.hpp"
#include "fire3dv/markers.h"
#include "tests/unit/adapters/generic/client_fixture.h"

namespace fire3dv::test {
namespace {

using namespace std::chrono_literals;

struct SceneRenderer {
  std::unique_ptr<transport::ListenerLink> link;
  wire::Decoder decoder;
  std::map<std::pair<std::string, wire::Property>, wire::SceneEdit> edits;
  uint64_t epoch = 0, scene_version = 0, sequence = 0;
  size_t partial_frames = 0;

  explicit SceneRenderer(const std::string& uri) { link = std::move(*transport::open_listener(uri)); }
  void poll() {
    link->wait(1ms);
    link->poll([this](const transport::LinkEvent& event) {
      using Kind = transport::LinkEvent::Kind;
      if (event.kind != Kind::pose && event.kind != Kind::control) return;
      auto message = decoder.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* m = std::get_if<wire::StreamDescription>(&*message)) {
        epoch = m->epoch;
        edits.clear();
      }
      if (auto* m = std::get_if<wire::SceneEdit>(&*message)) {
        EXPECT_EQ(m->epoch, epoch);
        edits[{m->node, m->property}] = *m;
      }
      if (const auto* m = std::get_if<wire::PoseFrameView>(&*message)) {
        scene_version = m->header.scene_version;
        sequence = m->header.sequence;
        partial_frames += !m->node_indices.empty();
      }
    });
  }
  const wire::EditValue& at(const std::string& node, wire::Property property) {
    return edits.at({node, property}).value;
  }
};

class ClientScene : public testing::TestWithParam<const char*> {};

TEST_P(ClientScene, CarriesEachKindOfEdit) {
  SceneRenderer renderer(listener_uri(GetParam()));
  Stream stream(renderer.link->uri());
  stream.set_visible("early", false);
  stream.describe({"a", "b"});
  stream.set_visible("n", false);
  stream.set_base_color("n", {0.25f, 0.5f, 1, 0.75f});
  fire3dv_light light{};
  light.kind = FIRE3DV_LIGHT_DIRECTIONAL;
  light.color_rgb[0] = 1;
  light.intensity = 3;
  light.casts_shadow = 1;
  stream.set_light("n", light);
  fire3dv_camera camera{};
  camera.vertical_fov_rad = 1;
  camera.near_m = 0.5f;
  camera.far_m = 50;
  camera.exposure = 2;
  stream.set_camera("n", camera);
  camera.f_number = 2.8f;
  camera.focus_distance_m = 1.5f;
  stream.set_camera("lens", camera);
  camera.struct_size = offsetof(fire3dv_camera, f_number);  // of programs built before the lens was appended
  EXPECT_EQ(fire3dv_set_camera(stream.get(), "older", &camera), FIRE3DV_OK) << fire3dv_last_error();
  fire3dv_node added{};
  const float parent_from_node[12] = {1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7};
  added.parent = "base";
  added.parent_from_node = parent_from_node;
  added.asset_uri = "part.glb";
  added.variant = "night";
  stream.add_node("n", added);
  added.struct_size = offsetof(fire3dv_node, variant);  // of programs built before `variant` was appended
  EXPECT_EQ(fire3dv_add_node(stream.get(), "older", &added), FIRE3DV_OK);
  stream.remove_node("gone");
  stream.set_vertices("n", {{1, 2, 3}, {4, 5, 6}}, {{0, 0, 1}, {0, 1, 0}});
  stream.clear("other", FIRE3DV_PROPERTY_LIGHT);
  ASSERT_TRUE(repeat_until([&] {
    stream.publish(0ns, std::vector<Pose>(2));
    renderer.poll();
    return renderer.scene_version == 12 && renderer.edits.size() == 12;
  }));
  using P = wire::Property;
  EXPECT_EQ(renderer.at("early", P::visible), wire::EditValue(wire::Visible{false}));
  EXPECT_EQ(renderer.at("n", P::visible), wire::EditValue(wire::Visible{false}));
  EXPECT_EQ(renderer.at("n", P::base_color), wire::EditValue(wire::BaseColor{{0.25f, 0.5f, 1, 0.75f}}));
  EXPECT_EQ(renderer.at("n", P::light),
            wire::EditValue(wire::Light{wire::LightKind::directional, {1, 0, 0}, 3, 0, 0, 0, true}));
  EXPECT_EQ(renderer.at("n", P::camera), wire::EditValue(wire::Camera{1, 0.5f, 50, 2}));
  EXPECT_EQ(renderer.at("lens", P::camera), wire::EditValue(wire::Camera{1, 0.5f, 50, 2, 2.8f, 1.5f}));
  EXPECT_EQ(renderer.at("older", P::camera), wire::EditValue(wire::Camera{1, 0.5f, 50, 2}));
  EXPECT_EQ(renderer.at("n", P::node),
            wire::EditValue(
                wire::NodeAdded{"base", {{1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7}}, "part.glb", {}, "night"}));
  EXPECT_EQ(std::get<wire::NodeAdded>(renderer.at("older", P::node)).variant, "");
  EXPECT_EQ(renderer.at("gone", P::node), wire::EditValue(wire::NodeRemoved{}));
  EXPECT_EQ(renderer.at("n", P::vertices),
            wire::EditValue(wire::Vertices{{{1, 2, 3}, {4, 5, 6}}, {{0, 0, 1}, {0, 1, 0}}}));
  EXPECT_EQ(renderer.at("other", P::light), wire::EditValue(wire::Cleared{}));

  // A new description starts a new epoch, which clears the edits.
  stream.describe({"a"});
  ASSERT_TRUE(repeat_until([&] {
    stream.publish(0ns, std::vector<Pose>(1));
    renderer.poll();
    return renderer.epoch == stream.poll().epoch && renderer.edits.size() == 12;
  }));
}

TEST_P(ClientScene, CarriesMarkers) {
  SceneRenderer renderer(listener_uri(GetParam()));
  Stream stream(renderer.link->uri());
  stream.describe({"a"});
  stream.publish(5s, std::vector<Pose>(1));
  const float positions[] = {0, 0, 0, 1, 2, 3}, rotation[] = {0, 0, 1, 0}, size[] = {1, 2, 4};
  const float parent_from_marker[] = {1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7};
  const uint8_t colors[] = {255, 128, 0, 64, 1, 2, 3, 4};
  fire3dv_marker marker{};
  marker.struct_size = sizeof marker;
  marker.kind = FIRE3DV_MARKER_BOXES;
  marker.width_unit = FIRE3DV_MARKER_LENGTHS;
  marker.width = 0.5f;
  marker.flags = FIRE3DV_MARKER_OVERLAID;
  marker.lifetime_ns = 250;
  marker.parent = "hand";
  marker.parent_from_marker = parent_from_marker;
  marker.positions = positions;
  marker.position_count = 2;
  marker.rotations = rotation;
  marker.rotation_count = 1;
  marker.sizes = size;
  marker.size_count = 1;
  marker.colors = colors;
  marker.color_count = 2;
  ASSERT_EQ(fire3dv_set_marker(stream.get(), "grasp/boxes", &marker), FIRE3DV_OK) << fire3dv_last_error();
  fire3dv_marker nothing{};
  nothing.struct_size = sizeof nothing;
  ASSERT_EQ(fire3dv_set_marker(stream.get(), "empty", &nothing), FIRE3DV_OK) << fire3dv_last_error();
  const char* const labels[] = {"left\nfoot", "K\u00f6rper"};
  fire3dv_marker texts = nothing;
  texts.kind = FIRE3DV_MARKER_TEXTS;
  texts.width = 12;
  texts.positions = positions;
  texts.position_count = texts.text_count = 2;
  texts.texts = labels;
  ASSERT_EQ(fire3dv_set_marker(stream.get(), "labels", &texts), FIRE3DV_OK) << fire3dv_last_error();
  ASSERT_EQ(fire3dv_set_marker(stream.get(), "gone", &nothing), FIRE3DV_OK);
  ASSERT_EQ(fire3dv_clear_marker(stream.get(), "gone"), FIRE3DV_OK) << fire3dv_last_error();
  ASSERT_TRUE(repeat_until([&] {
    stream.publish(6s, std::vector<Pose>(1));
    renderer.poll();
    return renderer.scene_version == 5 && renderer.edits.size() == 4;
  }));
  wire::Marker expected;
  expected.kind = wire::MarkerKind::boxes;
  expected.width_unit = wire::MarkerUnit::lengths;
  expected.width = 0.5f;
  expected.flags = wire::kMarkerOverlaid;
  expected.lifetime_ns = 250;
  expected.sim_time_ns = 5'000'000'000;
  expected.parent = "hand";
  expected.parent_from_marker = {{1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7}};
  expected.positions = {{0, 0, 0}, {1, 2, 3}};
  expected.rotations = {{0, 0, 1, 0}};
  expected.sizes = {{1, 2, 4}};
  expected.colors = {0x400080ff, 0x04030201};
  using P = wire::Property;
  EXPECT_EQ(renderer.at("grasp/boxes", P::marker), wire::EditValue(expected));
  EXPECT_TRUE(std::get<wire::Marker>(renderer.at("empty", P::marker)).positions.empty());
  const auto& received = std::get<wire::Marker>(renderer.at("labels", P::marker));
  EXPECT_EQ(received.kind, wire::MarkerKind::texts);
  EXPECT_EQ(received.texts, (std::vector<std::string>{"left\nfoot", "K\u00f6rper"}));
  EXPECT_EQ(renderer.at("gone", P::marker), wire::EditValue(wire::Cleared{}));
}

TEST_P(ClientScene, PartialFrameMovesSomeNodes) {
  const std::string scheme = GetParam();
  SceneRenderer renderer(listener_uri(scheme));
  Stream stream(renderer.link->uri());
  stream.describe({"a", "b", "c"});
  stream.publish_some(0ns, {0, 1, 2}, std::vector<Pose>(3));
  ASSERT_TRUE(repeat_until([&] {
    stream.publish_some(1ns, {1}, std::vector<Pose>(1));
    renderer.poll();
    return scheme == "shm" ? renderer.sequence >= 3 : renderer.partial_frames >= 3;
  }));
  if (scheme == "shm") {
    EXPECT_EQ(renderer.partial_frames, 0u) << "who attaches must see one whole frame";
  }
}

INSTANTIATE_TEST_SUITE_P(Links, ClientScene, testing::Values("shm", "tcp", "udp"),
                         [](const auto& test) { return std::string(test.param); });

template <typename Call>
void expect_thrown(int code, const std::string& text, Call call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown, expected: " << text;
  } catch (const ClientError& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(ClientSceneErrors, ErrorsNameTheArgument) {
  Stream stream(unique_shm_uri(), "test", {}, 100'000);
  constexpr int kArgument = FIRE3DV_ERROR_ARGUMENT;
  expect_thrown(kArgument, "rgba[2]", [&] { stream.set_base_color("n", {0, 0, 2, 1}); });
  expect_thrown(kArgument, "node is empty", [&] { stream.set_visible("", true); });
  expect_thrown(kArgument, "holds a NUL", [&] { stream.set_visible(std::string("a\0b", 3), true); });
  expect_thrown(kArgument, "control character", [&] { stream.remove_node("a\nb"); });
  expect_thrown(kArgument, "light.kind is 7", [&] {
    fire3dv_light light{};
    light.kind = 7;
    stream.set_light("n", light);
  });
  expect_thrown(kArgument, "vertical_fov_rad", [&] { stream.set_camera("n", {}); });
  expect_thrown(kArgument, "asset_glb_bytes", [&] {
    fire3dv_node node{};
    node.asset_glb_bytes = 7;
    stream.add_node("n", node);
  });
  expect_thrown(kArgument, "positions", [&] { stream.set_vertices("n", {}); });
  expect_thrown(kArgument, "normals", [&] { stream.set_vertices("n", {{0, 0, 0}}, {{0, 0, 1}, {0, 0, 1}}); });
  expect_thrown(kArgument, "property", [&] { stream.clear("n", 7); });
  stream.set_vertices("n", std::vector<std::array<float, 3>>(5000));
  expect_thrown(FIRE3DV_ERROR_BUDGET, "budget is 100000",
                [&] { stream.set_vertices("m", std::vector<std::array<float, 3>>(5000)); });
  expect_thrown(kArgument, "scene_budget_bytes",
                [] { Stream(unique_shm_uri(), "test", {}, size_t{257} << 20); });

  expect_thrown(FIRE3DV_ERROR_STATE, "fire3dv_describe", [&] { stream.publish_some(0ns, {0}, {Pose{}}); });
  stream.describe({"a", "b"});
  expect_thrown(FIRE3DV_ERROR_STATE, "must name all nodes", [&] { stream.publish_some(0ns, {0}, {Pose{}}); });
  expect_thrown(kArgument, "pose_count is 0", [&] {
    fire3dv::Stream& s = stream;
    s.publish_some(0ns, {}, {});
  });
  expect_thrown(kArgument, "node_indices[1]", [&] { stream.publish_some(0ns, {1, 1}, {Pose{}, Pose{}}); });
  expect_thrown(kArgument, "node_indices[1]", [&] { stream.publish_some(0ns, {0, 2}, {Pose{}, Pose{}}); });
  EXPECT_EQ(fire3dv_set_visible(nullptr, "n", 1), kArgument);
  EXPECT_EQ(fire3dv_set_visible(stream.get(), nullptr, 1), kArgument);
  EXPECT_EQ(fire3dv_set_base_color(stream.get(), "n", nullptr), kArgument);
  EXPECT_EQ(fire3dv_set_light(stream.get(), "n", nullptr), kArgument);
  fire3dv_camera camera{};
  EXPECT_EQ(fire3dv_set_camera(stream.get(), "n", &camera), kArgument) << "struct_size is not set";
}

TEST(ClientSceneErrors, MarkerErrorsAreNamed) {
  Stream stream(unique_shm_uri(), "test", {}, 100'000);
  const std::vector<float> positions(30'000);
  const auto expect_refused = [&](int code, const std::string& text, auto change) {
    fire3dv_marker marker{};
    marker.struct_size = sizeof marker;
    marker.positions = positions.data();
    marker.position_count = 2;
    change(marker);
    EXPECT_EQ(fire3dv_set_marker(stream.get(), "m", &marker), code) << text;
    EXPECT_NE(std::string(fire3dv_last_error()).find(text), std::string::npos) << fire3dv_last_error();
  };
  constexpr int kArgument = FIRE3DV_ERROR_ARGUMENT;
  expect_refused(kArgument, "struct_size", [](fire3dv_marker& m) { m.struct_size = 8; });
  expect_refused(kArgument, "marker.kind is 12", [](fire3dv_marker& m) { m.kind = 12; });
  expect_refused(kArgument, "marker.kind is -1", [](fire3dv_marker& m) { m.kind = -1; });
  expect_refused(kArgument, "marker.width_unit is 2", [](fire3dv_marker& m) { m.width_unit = 2; });
  expect_refused(kArgument, "marker.flags is 2", [](fire3dv_marker& m) { m.flags = 2; });
  expect_refused(kArgument, "width is nan", [](fire3dv_marker& m) { m.width = NAN; });
  expect_refused(kArgument, "marker.colors and its count", [](fire3dv_marker& m) { m.color_count = 2; });
  expect_refused(kArgument, "marker.positions and its count",
                 [](fire3dv_marker& m) { m.position_count = 0; });
  expect_refused(kArgument, "triples", [](fire3dv_marker& m) { m.kind = FIRE3DV_MARKER_TRIANGLES; });
  expect_refused(FIRE3DV_ERROR_BUDGET, "no budget is above 256 MiB",
                 [](fire3dv_marker& m) { m.position_count = SIZE_MAX / 2; });
  expect_refused(FIRE3DV_ERROR_BUDGET, "budget is 100000",
                 [](fire3dv_marker& m) { m.position_count = 10'000; });
  const auto expect_text_refused = [&](const std::string& reason, const char* second, size_t count = 2) {
    const char* const texts[] = {"good", second};
    expect_refused(kArgument, reason, [&](fire3dv_marker& m) {
      m.kind = FIRE3DV_MARKER_TEXTS;
      m.texts = texts;
      m.text_count = count;
    });
  };
  expect_text_refused("marker.texts[1] is NULL", nullptr);
  expect_text_refused("texts[1] has a control character at byte 2", "ab\033[2J");
  expect_text_refused("texts[1] is not valid UTF-8 at byte 1", "a\xff");
  expect_text_refused("texts[1] has 1025 bytes", std::string(5000, 'x').c_str());
  expect_text_refused("texts has 1 element for 2 positions", "", 1);
  expect_refused(kArgument, "texts has 0 elements", [](fire3dv_marker& m) { m.kind = FIRE3DV_MARKER_TEXTS; });
  expect_refused(kArgument, "marker.texts and its count", [](fire3dv_marker& m) { m.text_count = 2; });
  const std::string longest(1024, 'x');
  const std::vector<const char*> many(1025, longest.c_str());
  expect_refused(kArgument, "texts has more than 1048576 bytes", [&](fire3dv_marker& m) {
    m.kind = FIRE3DV_MARKER_TEXTS;
    m.position_count = m.text_count = many.size();
    m.texts = many.data();
  });
  const char* const text = "text";
  expect_refused(kArgument, "points have no texts", [&](fire3dv_marker& m) {
    m.texts = &text;
    m.text_count = 1;
  });
  expect_refused(FIRE3DV_ERROR_BUDGET, "at most 65536", [&](fire3dv_marker& m) {
    m.texts = &text;
    m.text_count = SIZE_MAX;
  });
  const uint8_t pixels[24] = {};
  const float sizes[] = {1, 1, 0};
  const auto expect_image_refused = [&](const std::string& reason, auto change) {
    expect_refused(kArgument, reason, [&](fire3dv_marker& m) {
      m.kind = FIRE3DV_MARKER_IMAGES;
      m.sizes = sizes;
      m.size_count = 1;
      m.image_pixels = pixels;
      m.image_width = 3;
      m.image_height = 2;
      m.image_channels = 4;
      change(m);
    });
  };
  expect_image_refused("must be given together", [](fire3dv_marker& m) { m.image_pixels = nullptr; });
  expect_image_refused("must be given together",
                       [](fire3dv_marker& m) { m.image_width = m.image_height = m.image_channels = 0; });
  // Refused before a pixel is read.
  expect_image_refused("image has 1025 x 2 pixels", [](fire3dv_marker& m) { m.image_width = 1025; });
  expect_image_refused("image has 3 x 4294967295 pixels",
                       [](fire3dv_marker& m) { m.image_height = UINT32_MAX; });
  expect_image_refused("image has 0 x 2 pixels", [](fire3dv_marker& m) { m.image_width = 0; });
  expect_image_refused("image_channels is 2", [](fire3dv_marker& m) { m.image_channels = 2; });
  expect_image_refused("image_channels is 260", [](fire3dv_marker& m) { m.image_channels = 260; });
  expect_image_refused("points have no image", [](fire3dv_marker& m) {
    m.kind = FIRE3DV_MARKER_POINTS;
    m.size_count = 0;
    m.sizes = nullptr;
  });
  expect_image_refused("sizes has 0 elements", [](fire3dv_marker& m) {
    m.size_count = 0;
    m.sizes = nullptr;
  });
  expect_refused(kArgument, "image has 0 x 0 pixels", [&](fire3dv_marker& m) {
    m.kind = FIRE3DV_MARKER_IMAGES;
    m.sizes = sizes;
    m.size_count = 1;
  });
  fire3dv_marker marker{};
  marker.struct_size = sizeof marker;
  EXPECT_EQ(fire3dv_set_marker(stream.get(), "", &marker), kArgument);
  EXPECT_NE(std::string(fire3dv_last_error()).find("marker's name"), std::string::npos)
      << fire3dv_last_error();
  EXPECT_EQ(fire3dv_set_marker(stream.get(), nullptr, &marker), kArgument);
  EXPECT_EQ(fire3dv_set_marker(stream.get(), "m", nullptr), kArgument);
  EXPECT_EQ(fire3dv_set_marker(nullptr, "m", &marker), kArgument);
  EXPECT_EQ(fire3dv_clear_marker(stream.get(), nullptr), kArgument);
  EXPECT_EQ(fire3dv_clear_marker(nullptr, "m"), kArgument);
}

}  // namespace
}  // namespace fire3dv::test
