// Test of markers in Foxglove's channels of recordings. Positions are checked against hand calculation:
// stream frames are Z up in millimetres, as is Foxglove's root in metres.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>

#include "point_cloud_generated.h"
#include "protocol/record/channels.h"
#include "protocol/record/foxglove_markers.h"
#include "scene_update_generated.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

using record::FoxgloveMarkers;
using record::FoxgloveMessage;
using wire::Marker;
using wire::MarkerKind;

constexpr uint64_t kNow_ns = 5'000'000'007;

wire::StreamDescription z_up_in_millimetres_markers() {
  wire::StreamDescription result;
  result.epoch = 7;
  result.adapter_name = "arm";
  result.node_names = {"base", "world", "hand"};
  result.world_from_stream.m = {0.001, 0, 0, 0, 0, 0, 0.001, 0, 0, -0.001, 0, 0};
  return result;
}

FoxgloveMarkers described(const wire::StreamDescription& description = z_up_in_millimetres_markers()) {
  FoxgloveMarkers markers;
  markers.describe(description);
  return markers;
}

Marker marker(MarkerKind kind, std::vector<std::array<float, 3>> positions) {
  Marker result;
  result.kind = kind;
  result.positions = std::move(positions);
  if (wire::has_sizes(kind)) result.sizes = {{100, 200, 300}};
  return result;
}

const foxglove::SceneUpdate* scene_in(const wire::Bytes& bytes) {
  flatbuffers::Verifier verifier(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), 64,
                                 10'000'000);
  EXPECT_TRUE(verifier.VerifyBuffer<foxglove::SceneUpdate>());
  return flatbuffers::GetRoot<foxglove::SceneUpdate>(bytes.data());
}

const foxglove::PointCloud* cloud_in(const wire::Bytes& bytes) {
  flatbuffers::Verifier verifier(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  EXPECT_TRUE(verifier.VerifyBuffer<foxglove::PointCloud>());
  return flatbuffers::GetRoot<foxglove::PointCloud>(bytes.data());
}

template <typename Point>
void expect_at(const Point* point, double x, double y, double z) {
  EXPECT_NEAR(point->x(), x, 1e-6);
  EXPECT_NEAR(point->y(), y, 1e-6);
  EXPECT_NEAR(point->z(), z, 1e-6);
}

// The image of a vector under a pose's rotation.
std::array<double, 3> rotated(const foxglove::Quaternion& q, std::array<double, 3> v) {
  const double t[3] = {2 * (q.y() * v[2] - q.z() * v[1]), 2 * (q.z() * v[0] - q.x() * v[2]),
                       2 * (q.x() * v[1] - q.y() * v[0])};
  return {v[0] + q.w() * t[0] + q.y() * t[2] - q.z() * t[1],
          v[1] + q.w() * t[1] + q.z() * t[0] - q.x() * t[2],
          v[2] + q.w() * t[2] + q.x() * t[1] - q.y() * t[0]};
}

TEST(FoxgloveMarkers, PointsArePackedClouds) {
  FoxgloveMarkers markers = described();
  Marker points = marker(MarkerKind::points, {{1000, 2000, 3000}, {0, 0, -500}});
  points.colors = {0x80332211, 0xffffffff};
  const auto messages = markers.set("scan", points, kNow_ns);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].cloud, "scan");
  const auto* cloud = cloud_in(messages[0].data);
  EXPECT_EQ(cloud->frame_id()->str(), "world");
  EXPECT_EQ(cloud->timestamp()->sec(), 5u);
  EXPECT_EQ(cloud->point_stride(), 16u);
  ASSERT_EQ(cloud->fields()->size(), 7u);
  std::map<std::string, uint32_t> offsets;
  for (const auto* field : *cloud->fields()) {
    offsets[field->name()->str()] = field->offset();
    EXPECT_EQ(field->type(),
              field->offset() < 12 ? foxglove::NumericType::FLOAT32 : foxglove::NumericType::UINT8);
  }
  ASSERT_EQ(cloud->data()->size(), 32u);
  const auto number = [&](size_t point, const char* name) {
    float value = 0;
    std::memcpy(&value, cloud->data()->data() + point * 16 + offsets.at(name), sizeof value);
    return value;
  };
  EXPECT_NEAR(number(0, "x"), 1, 1e-6);
  EXPECT_NEAR(number(0, "y"), 2, 1e-6);
  EXPECT_NEAR(number(0, "z"), 3, 1e-6);
  EXPECT_NEAR(number(1, "z"), -0.5, 1e-6);
  EXPECT_EQ(cloud->data()->Get(offsets.at("red")), 0x11);
  EXPECT_EQ(cloud->data()->Get(offsets.at("green")), 0x22);
  EXPECT_EQ(cloud->data()->Get(offsets.at("blue")), 0x33);
  EXPECT_EQ(cloud->data()->Get(offsets.at("alpha")), 0x80);
  // A cloud is cleared by an empty one.
  const auto cleared = markers.clear("scan", kNow_ns);
  ASSERT_EQ(cleared.size(), 1u);
  EXPECT_EQ(cloud_in(cleared[0].data)->data()->size(), 0u);
  EXPECT_TRUE(markers.clear("scan", kNow_ns).empty());
}

TEST(FoxgloveMarkers, LinesKeepWidths) {
  FoxgloveMarkers markers = described();
  Marker lines = marker(MarkerKind::lines, {{0, 0, 0}, {1000, 0, 0}});
  lines.width = 3;
  lines.colors = {0xff0000ff, 0xff00ff00};
  const auto in_pixels = markers.set("a", lines, kNow_ns);
  const auto* entity = scene_in(in_pixels[0].data)->entities()->Get(0);
  EXPECT_EQ(entity->id()->str(), "a");
  EXPECT_EQ(entity->lifetime()->sec(), 0);
  const auto* line = entity->lines()->Get(0);
  EXPECT_EQ(line->type(), foxglove::LineType::LINE_LIST);
  EXPECT_TRUE(line->scale_invariant());
  EXPECT_EQ(line->thickness(), 3);
  expect_at(line->points()->Get(1), 1, 0, 0);
  EXPECT_EQ(line->colors()->Get(0)->r(), 1);
  EXPECT_EQ(line->colors()->Get(0)->g(), 0);
  EXPECT_EQ(line->colors()->Get(1)->g(), 1);
  lines.kind = MarkerKind::line_strip;
  lines.width_unit = wire::MarkerUnit::lengths;
  const auto in_lengths = markers.set("a", lines, kNow_ns);
  line = scene_in(in_lengths[0].data)->entities()->Get(0)->lines()->Get(0);
  EXPECT_EQ(line->type(), foxglove::LineType::LINE_STRIP);
  EXPECT_FALSE(line->scale_invariant());
  EXPECT_NEAR(line->thickness(), 0.003, 1e-9);
}

TEST(FoxgloveMarkers, ArrowsPointToTip) {
  FoxgloveMarkers markers = described();
  // The fifth points along -x, where the shortest rotation from +x is not unique; the last has no length.
  Marker arrows =
      marker(MarkerKind::arrows, {{0, 0, 0}, {0, 0, 1000}, {1, 1, 1}, {-999, 1, 1}, {5, 5, 5}, {5, 5, 5}});
  arrows.width = 10;
  arrows.width_unit = wire::MarkerUnit::lengths;
  const auto messages = markers.set("forces", arrows, kNow_ns);
  const auto* list = scene_in(messages[0].data)->entities()->Get(0)->arrows();
  ASSERT_EQ(list->size(), 2u);
  const std::array<std::array<double, 3>, 2> along{{{0, 0, 1}, {-1, 0, 0}}};
  for (uint32_t i = 0; i < 2; ++i) {
    const auto* arrow = list->Get(i);
    const auto direction = rotated(*arrow->pose()->orientation(), {1, 0, 0});
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(direction[k], along[i][k], 1e-6);
    EXPECT_NEAR(arrow->shaft_length() + arrow->head_length(), 1, 1e-6);
    EXPECT_NEAR(arrow->shaft_diameter(), 0.01, 1e-9);
    EXPECT_GT(arrow->head_diameter(), arrow->shaft_diameter());
  }
}

TEST(FoxgloveMarkers, AxesAreColouredArrows) {
  FoxgloveMarkers markers = described();
  Marker axes = marker(MarkerKind::axes, {{0, 0, 0}});
  axes.rotations = {{0, 0, 2, 2}};  // a left turn about z, not of length 1
  const auto messages = markers.set("frame", axes, kNow_ns);
  const auto* list = scene_in(messages[0].data)->entities()->Get(0)->arrows();
  ASSERT_EQ(list->size(), 3u);
  const std::array<std::array<double, 3>, 3> along{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
  const std::array<double, 3> lengths{0.1, 0.2, 0.3};
  for (uint32_t i = 0; i < 3; ++i) {
    const auto direction = rotated(*list->Get(i)->pose()->orientation(), {1, 0, 0});
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(direction[k], along[i][k], 1e-6);
    EXPECT_NEAR(list->Get(i)->shaft_length() + list->Get(i)->head_length(), lengths[i], 1e-6);
    EXPECT_EQ(list->Get(i)->color()->r(), i == 0);
    EXPECT_EQ(list->Get(i)->color()->g(), i == 1);
    EXPECT_EQ(list->Get(i)->color()->b(), i == 2);
  }
}

TEST(FoxgloveMarkers, SolidsHaveMetresAndColour) {
  FoxgloveMarkers markers = described();
  for (const MarkerKind kind :
       {MarkerKind::boxes, MarkerKind::spheres, MarkerKind::cylinders, MarkerKind::capsules}) {
    Marker solid = marker(kind, {{0, 0, 1000}, {0, 0, 2000}});
    solid.rotations = {{0, 0, 0, 1}, {1, 0, 0, 1}};
    solid.colors = {0xff0000ff, 0xffff0000};
    const auto messages = markers.set("solid", solid, kNow_ns);
    const auto* entity = scene_in(messages[0].data)->entities()->Get(0);
    const auto expect = [&](const auto* list, size_t stride, size_t first) {
      ASSERT_EQ(list->size(), 2 * stride);
      const auto* second = list->Get(static_cast<uint32_t>(first + stride));
      expect_at(second->size(), 0.1, 0.2, kind == MarkerKind::capsules && stride == 2 ? 0.15 : 0.3);
      EXPECT_EQ(second->color()->b(), 1);
      EXPECT_EQ(second->color()->r(), 0);
      const auto z = rotated(*second->pose()->orientation(), {0, 0, 1});  // a quarter about x
      EXPECT_NEAR(z[1], -1, 1e-6);
    };
    if (kind == MarkerKind::boxes) expect(entity->cubes(), 1, 0);
    if (kind == MarkerKind::spheres) expect(entity->spheres(), 1, 0);
    if (kind == MarkerKind::cylinders || kind == MarkerKind::capsules) expect(entity->cylinders(), 1, 0);
    if (kind == MarkerKind::capsules) {
      expect(entity->spheres(), 2, 0);
      expect_at(entity->spheres()->Get(1)->pose()->position(), 0, 0, 1.15);
      expect_at(entity->spheres()->Get(3)->pose()->position(), 0, -0.15, 2);
    }
  }
}

TEST(FoxgloveMarkers, MirroredSolidsKeepAxes) {
  wire::StreamDescription description = z_up_in_millimetres_markers();
  description.world_from_stream = {};
  FoxgloveMarkers markers = described(description);
  Marker box = marker(MarkerKind::boxes, {{0, 0, 0}});
  box.sizes = {{1, 1, 1}};
  box.parent_from_marker.m = {-2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0};
  const auto messages = markers.set("box", box, kNow_ns);
  const auto* cube = scene_in(messages[0].data)->entities()->Get(0)->cubes()->Get(0);
  expect_at(cube->size(), 2, 3, 4);
  const auto x = rotated(*cube->pose()->orientation(), {1, 0, 0});
  EXPECT_NEAR(std::abs(x[0]), 1, 1e-6);
  const auto y = rotated(*cube->pose()->orientation(), {0, 1, 0});  // Y up is Z up there
  EXPECT_NEAR(std::abs(y[2]), 1, 1e-6);
}

TEST(FoxgloveMarkers, TrianglesAndTextsAreKept) {
  FoxgloveMarkers markers = described();
  Marker triangles = marker(MarkerKind::triangles, {{0, 0, 0}, {1000, 0, 0}, {0, 1000, 0}});
  triangles.colors = {0x40ff0000};
  const auto first = markers.set("area", triangles, kNow_ns);
  const auto* list = scene_in(first[0].data)->entities()->Get(0)->triangles()->Get(0);
  ASSERT_EQ(list->points()->size(), 3u);
  expect_at(list->points()->Get(2), 0, 1, 0);
  EXPECT_EQ(list->colors()->size(), 0u);
  EXPECT_EQ(list->color()->b(), 1);
  EXPECT_NEAR(list->color()->a(), 64 / 255.0, 1e-9);
  Marker texts = marker(MarkerKind::texts, {{0, 0, 1000}});
  texts.texts = {"left\nfoot \xc3\xa9"};
  texts.width = 14;
  const auto second = markers.set("name", texts, kNow_ns);
  const auto* text = scene_in(second[0].data)->entities()->Get(0)->texts()->Get(0);
  EXPECT_EQ(text->text()->str(), texts.texts[0]);
  EXPECT_TRUE(text->billboard() && text->scale_invariant());
  EXPECT_EQ(text->font_size(), 14);
  expect_at(text->pose()->position(), 0, 0, 1);
}

TEST(FoxgloveMarkers, ParentFrameCarriesScale) {
  wire::StreamDescription description = z_up_in_millimetres_markers();
  description.body_from_node = {{{{2, 0, 0, 10, 0, 2, 0, 0, 0, 0, 2, 0}}}};
  FoxgloveMarkers markers = described(description);
  Marker line = marker(MarkerKind::lines, {{0, 0, 0}, {1000, 0, 0}});
  for (const auto& [parent, frame] :
       {std::pair<std::string, std::string>{"hand", "hand"}, {"world", "world/node_1"}, {"door", "door"}}) {
    line.parent = parent;
    const auto messages = markers.set("line", line, kNow_ns);
    const auto* entity = scene_in(messages[0].data)->entities()->Get(0);
    EXPECT_EQ(entity->frame_id()->str(), frame);
    EXPECT_TRUE(entity->frame_locked());
    const auto* end = entity->lines()->Get(0)->points()->Get(1);
    if (parent == "door")
      expect_at(end, 1000, 0, 0);  // no node of the stream: nothing is known of its scale
    else
      expect_at(end, 2.01, 0, 0);
  }
}

TEST(FoxgloveMarkers, ReplacementsDeleteEntities) {
  FoxgloveMarkers markers = described();
  (void)markers.set("a", marker(MarkerKind::points, {{0, 0, 0}}), kNow_ns);
  auto messages = markers.set("a", marker(MarkerKind::boxes, {{0, 0, 0}}), kNow_ns);
  ASSERT_EQ(messages.size(), 2u);  // the cloud goes, the box comes
  EXPECT_EQ(cloud_in(messages[0].data)->data()->size(), 0u);
  EXPECT_EQ(scene_in(messages[1].data)->entities()->size(), 1u);
  messages = markers.set("a", marker(MarkerKind::boxes, {}), kNow_ns);
  ASSERT_EQ(messages.size(), 1u);
  const auto* deletion = scene_in(messages[0].data)->deletions()->Get(0);
  EXPECT_EQ(deletion->type(), foxglove::SceneEntityDeletionType::MATCHING_ID);
  EXPECT_EQ(deletion->id()->str(), "a");
  (void)markers.set("a", marker(MarkerKind::boxes, {{0, 0, 0}}), kNow_ns);
  (void)markers.set("b", marker(MarkerKind::points, {{0, 0, 0}}), kNow_ns);
  Marker of_later_version;
  of_later_version.kind = static_cast<MarkerKind>(200);
  EXPECT_TRUE(markers.set("c", of_later_version, kNow_ns).empty());
  messages = markers.clear_all(kNow_ns);
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_EQ(messages[0].cloud, "b");
  EXPECT_EQ(scene_in(messages[1].data)->deletions()->Get(0)->type(), foxglove::SceneEntityDeletionType::ALL);
  EXPECT_TRUE(markers.clear_all(kNow_ns).empty());
}

TEST(FoxgloveMarkers, LifetimesEndWithFrames) {
  FoxgloveMarkers markers = described();
  Marker box = marker(MarkerKind::boxes, {{0, 0, 0}});
  box.sim_time_ns = 100;
  box.lifetime_ns = 50;
  (void)markers.set("a", box, kNow_ns);
  box.lifetime_ns = UINT64_MAX;  // the sum overflows
  (void)markers.set("b", box, kNow_ns);
  EXPECT_TRUE(markers.advance(150, kNow_ns).empty());
  const auto messages = markers.advance(151, kNow_ns);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(scene_in(messages[0].data)->deletions()->Get(0)->id()->str(), "a");
  EXPECT_TRUE(markers.advance(INT64_MAX, kNow_ns).empty());
  box.lifetime_ns = 50;
  EXPECT_TRUE(markers.set("late", box, kNow_ns).empty());
}

TEST(FoxgloveMarkers, HostileCountsAreSkipped) {
  FoxgloveMarkers markers = described();
  constexpr auto kKinds = static_cast<size_t>(MarkerKind::images);
  for (size_t kind = 0; kind < kKinds; ++kind) {
    const auto each = static_cast<MarkerKind>(kind);
    // As many positions as just fit have a message within the limit; twice as many do not.
    Marker large = marker(each, {});
    size_t count = 6;
    for (bool fits = true; fits; count *= 2) {
      large.positions.assign(count, {1, 2, 3});
      for (size_t i = 0; i < count; i += 2) large.positions[i][0] = -4;
      large.colors.assign(count, 0xff123456);
      if (wire::has_sizes(each)) {
        large.sizes.assign(count, {1, 2, 3});
        large.rotations.assign(count, {0.1f, 0.2f, 0.3f, 0.4f});
      }
      if (each == MarkerKind::texts) large.texts.assign(count, "text");
      const uint64_t before = markers.left_out();
      const auto messages = markers.set("large", large, kNow_ns);
      fits = markers.left_out() == before;
      if (fits) {
        EXPECT_LE(messages.back().data.size(), record::kMaxMarkerBytes) << wire::marker_kind_name(each);
      }
    }
    EXPECT_GT(count, 20'000u) << wire::marker_kind_name(each);
  }
  EXPECT_EQ(markers.left_out(), kKinds);
  Marker image = marker(MarkerKind::images, {{0, 0, 0}});
  image.image = {1, 1, 1, {0}};
  EXPECT_TRUE(markers.set("image", image, kNow_ns).empty());
  EXPECT_EQ(markers.left_out(), kKinds + 1);
}

// --- in files

Bytes marker_edit(uint64_t version, const std::string& name, wire::EditValue value) {
  return wire::encode(wire::SceneEdit{7, version, name, wire::Property::marker, std::move(value)});
}

struct Topics {
  std::map<std::string, std::vector<Bytes>> messages;
  std::map<std::string, std::string> schemas;
};

Topics topics_of(const Bytes& file) {
  Topics result;
  auto reader = record::Reader::open(source_of(file));
  EXPECT_TRUE(reader.ok());
  record::Message message;
  while (reader->next(message) == record::Reader::Step::message) {
    const record::Channel& channel = reader->index().channels.at(message.channel_id);
    result.messages[channel.topic].emplace_back(message.data.begin(), message.data.end());
    const record::Schema& schema = reader->index().schemas.at(channel.schema_id);
    result.schemas[channel.topic] = schema.name;
    if (schema.name == record::kPointCloudSchema) {
      EXPECT_TRUE(std::ranges::equal(schema.data, record::point_cloud_schema()));
    } else if (schema.name == record::kSceneUpdateSchema) {
      EXPECT_TRUE(std::ranges::equal(schema.data, record::scene_update_schema()));
    }
  }
  return result;
}

TEST(FoxgloveMarkers, EachFileHasCurrentMarkers) {
  record::LogOptions options;
  options.foxglove = true;
  options.split_ns = 50 * kMs;
  MemoryLog memory(options);
  ASSERT_TRUE(memory.take(description(7), 0));
  ASSERT_TRUE(memory.take(marker_edit(1, "box", marker(MarkerKind::boxes, {{0, 0, 0}})), 1));
  ASSERT_TRUE(memory.take(marker_edit(2, "scan", marker(MarkerKind::points, {{0, 0, 0}})), 2));
  ASSERT_TRUE(memory.take(marker_edit(3, "gone", marker(MarkerKind::boxes, {{0, 0, 0}})), 3));
  ASSERT_TRUE(memory.take(marker_edit(4, "gone", wire::Cleared{}), 4));
  ASSERT_TRUE(memory.take(marker_edit(4, "gone", wire::Cleared{}), 4));  // repeated by the link
  ASSERT_TRUE(memory.take(frame(7, 1), 5));
  ASSERT_TRUE(memory.take(frame(7, 2), 100));
  ASSERT_TRUE(memory.take(wire::encode(wire::Goodbye{7}), 101));
  ASSERT_TRUE(memory.log.finish().ok());
  ASSERT_EQ(memory.files.size(), 2u);
  Topics first = topics_of(*memory.files[0]), second = topics_of(*memory.files[1]);
  EXPECT_EQ(first.schemas["/arm/markers"], "foxglove.SceneUpdate");
  EXPECT_EQ(first.schemas["/arm/points/scan"], "foxglove.PointCloud");
  EXPECT_EQ(first.messages["/arm/markers"].size(), 3u);
  EXPECT_EQ(first.messages["/arm/points/scan"].size(), 1u);
  const auto& scenes = second.messages["/arm/markers"];
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scene_in(scenes[0])->entities()->Get(0)->id()->str(), "box");
  EXPECT_EQ(scene_in(scenes[1])->deletions()->Get(0)->type(), foxglove::SceneEntityDeletionType::ALL);
  const auto& clouds = second.messages["/arm/points/scan"];
  ASSERT_EQ(clouds.size(), 2u);
  EXPECT_EQ(cloud_in(clouds[0])->data()->size(), 16u);
  EXPECT_EQ(cloud_in(clouds[1])->data()->size(), 0u);  // the stream has ended
  EXPECT_EQ(memory.log.unconverted_markers(), 0u);
}

TEST(FoxgloveMarkers, CloudNamesAreBounded) {
  record::LogOptions options;
  options.foxglove = true;
  MemoryLog memory(options);
  ASSERT_TRUE(memory.take(description(7), 0));
  for (uint64_t i = 1; i <= 300; ++i)
    ASSERT_TRUE(
        memory.take(marker_edit(i, "scan/" + std::to_string(i), marker(MarkerKind::points, {{0, 0, 0}})), i));
  ASSERT_TRUE(memory.log.finish().ok());
  EXPECT_EQ(memory.log.unconverted_markers(), 300u - 256u);
  const Topics topics = topics_of(*memory.files[0]);
  EXPECT_EQ(topics.messages.at("/arm/control").size(), 301u);  // nothing of ours is lost by it
}

TEST(FoxgloveMarkers, NewRunBeginsWithoutMarkers) {
  record::LogOptions options;
  options.foxglove = true;
  MemoryLog memory(options);
  ASSERT_TRUE(memory.take(description(7), 0));
  ASSERT_TRUE(memory.take(marker_edit(1, "box", marker(MarkerKind::boxes, {{0, 0, 0}})), 1));
  ASSERT_TRUE(memory.take(description(8), 2));
  ASSERT_TRUE(memory.log.finish().ok());
  const Topics topics = topics_of(*memory.files[0]);
  const auto& scenes = topics.messages.at("/arm/markers");
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scene_in(scenes[1])->deletions()->Get(0)->type(), foxglove::SceneEntityDeletionType::ALL);
}

}  // namespace
}  // namespace fire3dv::record_test
