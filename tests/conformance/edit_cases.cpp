// Golden messages of scene edits and partial frames (protocol 1.1): valid, of later versions, and invalid.
#include <cmath>

#include "later_generated.h"
#include "tests/conformance/cases.h"

namespace fire3dv::conformance {
namespace {

using namespace wire;

constexpr uint64_t kEditEpoch = 0x0123456789abcdef;

SceneEdit edit_case(Property property, EditValue value) {
  return {kEditEpoch, 7, "robot/link 1", property, std::move(value)};
}

constexpr Light kSpot{LightKind::spot, {1, 0.5f, 0.25f}, 800, 12.5f, 0.25f, 0.5f, false};
constexpr Camera kCamera{0.75f, 0.1f, 100, 2};

NodeAdded added() {
  NodeAdded node;
  node.parent = "base";
  node.parent_from_node.m[3] = 1.5f;
  return node;
}

Marker points_marker() {
  Marker marker;
  marker.width = 9;
  marker.positions = {{0, 0, 0}, {1, -2.5f, 1e6f}, {0.5f, 0, 3}};
  marker.colors = {0xff0000ff, 0xff00ff00, 0x80ff0000};  // red, green, half transparent blue
  return marker;
}

Marker boxes_marker() {
  Marker marker;
  marker.kind = MarkerKind::boxes;
  marker.width_unit = MarkerUnit::lengths;
  marker.flags = kMarkerOverlaid;
  marker.width = 0.5f;
  marker.lifetime_ns = 250'000'000;
  marker.sim_time_ns = -1'000'000'000;
  marker.parent = "robot/tool";
  marker.parent_from_marker.m[3] = 1.5f;
  marker.positions = {{0, 0, 0}, {1, 2, 3}};
  marker.rotations = {{0, 0, 0, 1}, {0, 0, 0.6f, 0.8f}};
  marker.sizes = {{0.1f, 0.2f, 0.3f}};
  marker.colors = {0xff4080c0};
  return marker;
}

Marker texts_marker() {
  Marker marker;
  marker.kind = MarkerKind::texts;
  marker.width = 18;
  marker.positions = {{0, 0, 1.5f}, {1, -2, 3}};
  marker.colors = {0xffffffff, 0xff00c0ff};
  marker.texts = {"pump 3\n2.5 bar", "K\u00f6rper \u2192 \u0394x"};
  return marker;
}

// 3 x 2 pixels: red, green, blue, and below white, black, half transparent grey.
Marker image_marker() {
  Marker marker;
  marker.kind = MarkerKind::images;
  marker.parent = "robot/camera";
  marker.positions = {{0, 0.25f, -1}};
  marker.rotations = {{0, 1, 0, 0}};
  marker.sizes = {{0.75f, 0.5f, 0}};
  marker.image = {3, 2, 4, {255, 0,   0,   255, 0, 255, 0, 255, 0,   0,   255, 255,
                            255, 255, 255, 255, 0, 0,   0, 255, 128, 128, 128, 128}};
  return marker;
}

SceneEdit marker_edit(Marker marker) {
  return {kEditEpoch, 9, "contacts/left foot", Property::marker, std::move(marker)};
}

PoseFrameView partial(std::span<const Affine3x4> poses, std::span<const uint32_t> indices) {
  return {{kEditEpoch, 2, 1000000, 2000000, 7, 0}, 100, 0, poses, indices};
}

}  // namespace

std::vector<Case> edit_cases() {
  std::vector<Case> result;
  const auto add = [&](std::string name, Bytes bytes) {
    result.push_back({std::move(name), std::move(bytes), true, {}});
  };
  add("scene_edit-cleared", encode(edit_case(Property::light, Cleared{})));
  add("scene_edit-hidden", encode(edit_case(Property::visible, Visible{false})));
  add("scene_edit-base_color", encode(edit_case(Property::base_color, BaseColor{{1, 0.5f, 0, 0.25f}})));
  add("scene_edit-light", encode(edit_case(Property::light, kSpot)));
  add("scene_edit-camera", encode(edit_case(Property::camera, kCamera)));
  Camera with_lens = kCamera;
  with_lens.f_number = 2.8f;
  with_lens.focus_distance_m = 1.5f;
  add("scene_edit-camera_lens", encode(edit_case(Property::camera, with_lens)));
  NodeAdded node = added();
  add("scene_edit-node_added_empty", encode(edit_case(Property::node, node)));
  node.asset_uri = "parts/K\u00f6rper.glb";
  add("scene_edit-node_added_by_uri", encode(edit_case(Property::node, node)));
  node.variant = "midnight blue";
  add("scene_edit-node_added_variant", encode(edit_case(Property::node, node)));
  node.variant.clear();
  node.asset_uri.clear();
  node.asset_glb = {std::byte{'g'}, std::byte{'l'}, std::byte{'T'}, std::byte{'F'}, std::byte{2}};
  add("scene_edit-node_added_embedded", encode(edit_case(Property::node, node)));
  add("scene_edit-node_removed", encode(edit_case(Property::node, NodeRemoved{})));
  Vertices vertices{{{0, 0, 0}, {1, 0, 0}, {0, -2.5f, 1e6f}}, {}};
  add("scene_edit-vertices", encode(edit_case(Property::vertices, vertices)));
  vertices.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  add("scene_edit-vertices_with_normals", encode(edit_case(Property::vertices, vertices)));
  add("scene_edit-marker_points", encode(marker_edit(points_marker())));
  add("scene_edit-marker_boxes", encode(marker_edit(boxes_marker())));
  add("scene_edit-marker_texts", encode(marker_edit(texts_marker())));
  add("scene_edit-marker_image", encode(marker_edit(image_marker())));
  Marker grey = image_marker();
  grey.image = {2, 1, 1, {0, 200}};
  add("scene_edit-marker_image_grey", encode(marker_edit(grey)));
  Marker marker;
  marker.kind = MarkerKind::arrows;
  add("scene_edit-marker_without_elements", encode(marker_edit(marker)));
  marker = points_marker();
  marker.kind = static_cast<MarkerKind>(200);
  add("scene_edit-marker_of_later_version", encode(marker_edit(marker)));
  add("scene_edit-marker_cleared",
      encode({kEditEpoch, 9, "contacts/left foot", Property::marker, Cleared{}}));
  const std::vector<Affine3x4> poses(2);
  const std::vector<uint32_t> indices{3, 99};
  add("pose_frame-partial", encode(partial(poses, indices)));
  StreamDescription description;
  description.adapter_name = "conformance";
  description.epoch = kEditEpoch;
  description.protocol_minor = 1;
  add("stream_description-minor_1", encode(description));
  return result;
}

std::vector<Case> later_edit_cases() {
  flatbuffers::FlatBufferBuilder builder;
  const auto wind = later::CreateWind(builder, 3);
  const auto node = builder.CreateString("robot");
  const auto body =
      later::CreateSceneEdit(builder, kEditEpoch, 8, node, 40, later::EditValue::Wind, wind.Union());
  builder.Finish(later::CreateMessage(builder, later::Body::SceneEdit, body.Union()),
                 later::MessageIdentifier());
  const auto* begin = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
  return {{"later-scene_edit_of_unknown_value", {begin, begin + builder.GetSize()}, false, {}}};
}

std::vector<Case> refused_edit_cases() {
  std::vector<Case> result;
  const auto add = [&](std::string name, const SceneEdit& bad, std::string refused) {
    result.push_back({"refused-scene_edit_" + std::move(name), encode(bad), false, "SceneEdit." + refused});
  };
  const auto add_light = [&](std::string name, std::string refused, auto change) {
    Light light = kSpot;
    change(light);
    add("light_" + std::move(name), edit_case(Property::light, light), std::move(refused));
  };
  const auto add_camera = [&](std::string name, std::string refused, auto change) {
    Camera camera = kCamera;
    change(camera);
    add("camera_" + std::move(name), edit_case(Property::camera, camera), std::move(refused));
  };
  SceneEdit bad = edit_case(Property::visible, Visible{});
  bad.epoch = 0;
  add("epoch_zero", bad, "epoch");
  bad = edit_case(Property::visible, Visible{});
  bad.version = 0;
  add("version_zero", bad, "version");
  bad = edit_case(Property::visible, Visible{});
  bad.node = "";
  add("node_empty", bad, "node");
  bad.node = "\x1b[2J";
  add("node_control_character", bad, "node");
  bad.node = std::string(1025, 'x');
  add("node_too_long", bad, "node");
  add("value_of_other_property", edit_case(Property::light, Visible{}), "value");
  add("color_nan", edit_case(Property::base_color, BaseColor{{0, NAN, 0, 1}}), "rgba[1]");
  add("color_above_one", edit_case(Property::base_color, BaseColor{{0, 0, 0, 1.5f}}), "rgba[3]");
  add_light("kind", "kind", [](Light& l) { l.kind = static_cast<LightKind>(3); });
  add_light("negative", "intensity", [](Light& l) { l.intensity = -1; });
  add_light("color_infinite", "color_rgb[2]", [](Light& l) { l.color_rgb[2] = INFINITY; });
  add_light("cones", "inner_cone_rad", [](Light& l) { l.inner_cone_rad = l.outer_cone_rad; });
  add_light("wide", "outer_cone_rad", [](Light& l) { l.outer_cone_rad = 2; });
  add_camera("fov_zero", "vertical_fov_rad", [](Camera& c) { c.vertical_fov_rad = 0; });
  add_camera("fov_nan", "vertical_fov_rad", [](Camera& c) { c.vertical_fov_rad = NAN; });
  add_camera("near_zero", "near_m", [](Camera& c) { c.near_m = 0; });
  add_camera("far_before_near", "far_m", [](Camera& c) { c.far_m = c.near_m; });
  add_camera("exposure_negative", "exposure", [](Camera& c) { c.exposure = -1; });
  const auto add_lens = [&](const std::string& name, std::string refused, float f_number, float focus_m) {
    add_camera("lens_" + name, std::move(refused), [&](Camera& c) {
      c.f_number = f_number;
      c.focus_distance_m = focus_m;
    });
  };
  add_lens("without_focus", "focus_distance_m", 2.8f, 0);
  add_lens("without_f_number", "f_number", 0, 2);
  add_lens("f_number_small", "f_number", 0.01f, 2);
  add_lens("f_number_large", "f_number", 1e9f, 2);
  add_lens("f_number_nan", "f_number", NAN, 2);
  add_lens("focus_negative", "focus_distance_m", 2.8f, -1);
  add_lens("focus_infinite", "focus_distance_m", 2.8f, INFINITY);
  NodeAdded node = added();
  node.parent = "a\nb";
  add("parent_newline", edit_case(Property::node, node), "parent");
  node = added();
  node.parent_from_node.m[0] = NAN;
  add("parent_from_node_nan", edit_case(Property::node, node), "parent_from_node");
  node = added();
  node.asset_uri = "a.glb";
  node.asset_glb = {std::byte{1}};
  add("asset_twice", edit_case(Property::node, node), "asset_uri");
  node = added();
  node.variant = "red";
  add("variant_without_asset", edit_case(Property::node, node), "variant");
  add("vertices_none", edit_case(Property::vertices, Vertices{}), "positions");
  add("vertices_nan", edit_case(Property::vertices, Vertices{{{0, 0, 0}, {0, NAN, 0}}, {}}),
      "positions[1][1]");
  add("normals_count", edit_case(Property::vertices, Vertices{{{0, 0, 0}}, {{0, 0, 1}, {0, 0, 1}}}),
      "normals");

  const auto add_marker = [&](std::string name, std::string refused, Marker marker, auto change) {
    change(marker);
    add("marker_" + std::move(name), marker_edit(std::move(marker)), std::move(refused));
  };
  const Marker points = points_marker(), boxes = boxes_marker();
  bad = marker_edit(points);
  bad.node = "";
  add("marker_name_empty", bad, "node");
  add("marker_of_other_property", edit_case(Property::vertices, points), "value");
  add_marker("unit", "width_unit", points, [](Marker& m) { m.width_unit = static_cast<MarkerUnit>(2); });
  add_marker("width_nan", "width", points, [](Marker& m) { m.width = NAN; });
  add_marker("width_negative", "width", points, [](Marker& m) { m.width = -1; });
  add_marker("parent_newline", "parent", points, [](Marker& m) { m.parent = "a\nb"; });
  add_marker("pose_infinite", "parent_from_marker", points,
             [](Marker& m) { m.parent_from_marker.m[11] = INFINITY; });
  add_marker("positions_nan", "positions[1][2]", points, [](Marker& m) { m.positions[1][2] = NAN; });
  add_marker("positions_odd", "positions of lines", points, [](Marker& m) { m.kind = MarkerKind::lines; });
  add_marker("positions_one", "positions of line_strip", points, [](Marker& m) {
    m.kind = MarkerKind::line_strip;
    m.positions.resize(1);
  });
  add_marker("positions_not_triples", "positions of triangles", points, [](Marker& m) {
    m.kind = MarkerKind::triangles;
    m.positions.resize(2);
  });
  add_marker("colors_count", "colors has 2", points, [](Marker& m) { m.colors.resize(2); });
  add_marker("sizes_of_points", "sizes", points, [](Marker& m) { m.sizes.resize(3); });
  add_marker("rotations_of_points", "rotations", points, [](Marker& m) { m.rotations = {{0, 0, 0, 1}}; });
  add_marker("sizes_none", "sizes has 0", boxes, [](Marker& m) { m.sizes.clear(); });
  add_marker("sizes_negative", "sizes[0][1]", boxes, [](Marker& m) { m.sizes[0][1] = -1; });
  add_marker("sizes_nan", "sizes[0][2]", boxes, [](Marker& m) { m.sizes[0][2] = NAN; });
  add_marker("rotations_count", "rotations has 3", boxes, [](Marker& m) {
    m.rotations.resize(3, {0, 0, 0, 1});
  });
  add_marker("rotation_zero", "rotations[1]", boxes, [](Marker& m) { m.rotations[1] = {}; });
  add_marker("rotation_nan", "rotations[0][3]", boxes, [](Marker& m) { m.rotations[0][3] = NAN; });
  add_marker("later_kind_rotation_nan", "rotations[0][3]", boxes, [](Marker& m) {
    m.kind = static_cast<MarkerKind>(200);
    m.rotations[0][3] = NAN;
  });

  const Marker texts = texts_marker();
  add_marker("texts_of_points", "texts is given", points, [](Marker& m) { m.texts = {"a", "b", "c"}; });
  add_marker("texts_count", "texts has 1 element", texts, [](Marker& m) { m.texts.pop_back(); });
  add_marker("texts_tab", "texts[1] has a control", texts, [](Marker& m) { m.texts[1] = "a\tb"; });
  add_marker("texts_right_to_left_override", "texts[0] has a control", texts,
             [](Marker& m) { m.texts[0] = "a\u202eb"; });
  add_marker("texts_invalid_utf8", "texts[0] is not valid UTF-8 at byte 1", texts,
             [](Marker& m) { m.texts[0] = "a\xc3"; });
  add_marker("texts_too_long", "texts[1] has 1025 bytes", texts,
             [](Marker& m) { m.texts[1] = std::string(1025, 'x'); });

  const Marker image = image_marker();
  add_marker("image_of_points", "image is given", points, [&](Marker& m) { m.image = image.image; });
  add_marker("image_none", "image has 0 x 0 pixels", image, [](Marker& m) { m.image = {}; });
  add_marker("image_too_wide", "image has 1025 x 1 pixels", image, [](Marker& m) {
    m.image = {1025, 1, 1, std::vector<uint8_t>(1025)};
  });
  add_marker("image_side_overflow", "image has 4294967295 x 4294967295 pixels", image, [](Marker& m) {
    m.image.width = m.image.height = UINT32_MAX;  // their product is 1 modulo 2^32
  });
  add_marker("image_channels", "image_channels is 2", image, [](Marker& m) { m.image = {1, 1, 2, {1, 2}}; });
  add_marker("image_pixels_few", "image_pixels has 23 bytes", image,
             [](Marker& m) { m.image.pixels.pop_back(); });
  add_marker("image_pixels_many", "image_pixels has 25 bytes", image,
             [](Marker& m) { m.image.pixels.push_back(0); });
  add_marker("image_colors", "colors is given", image, [](Marker& m) { m.colors = {1}; });
  add_marker("image_sizes_none", "sizes has 0", image, [](Marker& m) { m.sizes.clear(); });
  add_marker("image_sizes_nan", "sizes[0][1]", image, [](Marker& m) { m.sizes[0][1] = NAN; });

  const std::vector<Affine3x4> poses(2);
  const auto add_frame = [&](std::string name, const std::vector<uint32_t>& indices, std::string refused) {
    result.push_back({"refused-pose_frame_partial_" + std::move(name), encode(partial(poses, indices)), false,
                      "PoseFrame.node_indices" + refused});
  };
  add_frame("outside", {3, 100}, "[1]");
  add_frame("falling", {4, 3}, "[1]");
  add_frame("twice", {4, 4}, "[1]");
  add_frame("count", {4}, " names 1");
  return result;
}

}  // namespace fire3dv::conformance
