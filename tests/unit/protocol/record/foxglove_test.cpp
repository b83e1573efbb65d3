// Test of Foxglove's channels in recordings, and of the frame count.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "frame_transforms_generated.h"
#include "protocol/record/channels.h"
#include "protocol/record/foxglove.h"
#include "protocol/record/frame_counter.h"
#include "scene_update_generated.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

using record::rigid_part;
using wire::Affine3x4d;

// Returns the rotation matrix of a quaternion, row by row.
std::array<double, 9> matrix_of(const std::array<double, 4>& q) {
  const auto [x, y, z, w] = q;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
}

double worst_difference(const Affine3x4d& map, const std::array<double, 4>& q, double scale = 1) {
  double worst = 0;
  const auto rotation = matrix_of(q);
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 3; ++column)
      worst = std::max(worst, std::abs(map.m[row * 4 + column] - scale * rotation[row * 3 + column]));
  return worst;
}

Affine3x4d rotation(double x, double y, double z, double angle, double scale) {
  const double length = std::sqrt(x * x + y * y + z * z), s = std::sin(angle / 2) / length;
  const auto r = matrix_of({x * s, y * s, z * s, std::cos(angle / 2)});
  return {{scale * r[0], scale * r[1], scale * r[2], 1, scale * r[3], scale * r[4], scale * r[5], 2,
           scale * r[6], scale * r[7], scale * r[8], 3}};
}

TEST(RigidPart, RotationsIgnoreScale) {
  for (double angle = -3.2; angle < 3.3; angle += 0.1)
    for (const double scale : {1e-6, 1.0, 1000.0}) {
      const Affine3x4d map = rotation(angle, 1, 0.3, angle, scale);
      const auto part = rigid_part(map);
      EXPECT_LT(worst_difference(map, part.rotation_xyzw, scale) / scale, 1e-12) << angle << " " << scale;
      EXPECT_GE(part.rotation_xyzw[3], 0);
      EXPECT_EQ(part.translation, (std::array<double, 3>{1, 2, 3}));
    }
  for (const auto axis : {0, 1, 2}) {  // half turns, where many formulas divide by zero
    const Affine3x4d map = rotation(axis == 0, axis == 1, axis == 2, M_PI, 1);
    EXPECT_LT(worst_difference(map, rigid_part(map).rotation_xyzw), 1e-12);
  }
}

TEST(RigidPart, NonRigidGivesNearestRotation) {
  const std::vector<Affine3x4d> maps{
      {{2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 5, 0}},       // non-uniform scale
      {{1, 0.7, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},     // sheared
      {{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},      // mirrored
      {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}},       // flat
      {{0.1, 2, -3, 0, 4, 5, -6, 0, 7, 8, 10, 0}},  // arbitrary
  };
  for (const Affine3x4d& map : maps) {
    const auto part = rigid_part(map);
    const auto distance = [&](const std::array<double, 4>& q) {
      double sum = 0;
      const auto r = matrix_of(q);
      for (size_t i = 0; i < 9; ++i) sum += std::pow(map.m[i / 3 * 4 + i % 3] - r[i], 2);
      return sum;
    };
    double length = 0;
    for (const double value : part.rotation_xyzw) length += value * value;
    EXPECT_NEAR(length, 1, 1e-12);
    // No rotation of a large sample is nearer.
    uint64_t random = 1;
    for (int i = 0; i < 20'000; ++i) {
      std::array<double, 4> q;
      double square = 0;
      for (double& value : q) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        value = static_cast<double>(random >> 11) * 0x1p-52 - 1;
        square += value * value;
      }
      if (square < 1e-3) continue;
      for (double& value : q) value /= std::sqrt(square);
      ASSERT_GE(distance(q), distance(part.rotation_xyzw) - 1e-9);
    }
  }
  EXPECT_EQ(rigid_part({{0, 0, 0, 4, 0, 0, 0, 5, 0, 0, 0, 6}}).rotation_xyzw,
            (std::array<double, 4>{0, 0, 0, 1}));
}

wire::StreamDescription zed_up_in_millimetres() {
  wire::StreamDescription result;
  result.epoch = 7;
  result.adapter_name = "arm";
  result.node_names = {"base", "world", "hand"};
  result.world_from_stream.m = {0.001, 0, 0, 0, 0, 0, 0.001, 0, 0, -0.001, 0, 0};
  return result;
}

const foxglove::FrameTransforms* transforms_in(std::span<const std::byte> bytes) {
  flatbuffers::Verifier verifier(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  EXPECT_TRUE(verifier.VerifyBuffer<foxglove::FrameTransforms>());
  return flatbuffers::GetRoot<foxglove::FrameTransforms>(bytes.data());
}

TEST(Foxglove, TransformsAreMetresZUp) {
  record::FoxgloveTransforms transforms;
  transforms.describe(zed_up_in_millimetres());
  std::vector<wire::Affine3x4> poses(3);
  for (size_t i = 0; i < 3; ++i) {
    poses[i].m = {0, -1, 0, 2000, 1, 0, 0, 3000, 0, 0, 1, static_cast<float>(1000 * (i + 1))};  // a left turn
  }
  wire::PoseFrameView frame;
  frame.node_count = 3;
  frame.poses = poses;
  const auto* message = transforms_in(transforms.encode(frame, 5'000'000'007));
  ASSERT_EQ(message->transforms()->size(), 3u);
  const std::vector<std::string> ids{"base", "world/node_1", "hand"};
  for (uint32_t i = 0; i < 3; ++i) {
    const auto* each = message->transforms()->Get(i);
    EXPECT_EQ(each->parent_frame_id()->str(), "world");
    EXPECT_EQ(each->child_frame_id()->str(), ids[i]);
    EXPECT_EQ(each->timestamp()->sec(), 5u);
    EXPECT_EQ(each->timestamp()->nsec(), 7u);
    // Equal to the stream, which is also Z up: converted to the Y-up scene and back.
    EXPECT_NEAR(each->translation()->x(), 2, 1e-12);
    EXPECT_NEAR(each->translation()->y(), 3, 1e-12);
    EXPECT_NEAR(each->translation()->z(), i + 1, 1e-12);
    EXPECT_NEAR(each->rotation()->x(), 0, 1e-12);
    EXPECT_NEAR(each->rotation()->y(), 0, 1e-12);
    EXPECT_NEAR(each->rotation()->z(), std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(each->rotation()->w(), std::sqrt(0.5), 1e-12);
  }
  // Parts and partial frames update only their nodes.
  frame.first_node = 1;
  frame.poses = std::span(poses).subspan(1, 1);
  EXPECT_EQ(transforms_in(transforms.encode(frame, 0))->transforms()->Get(0)->child_frame_id()->str(),
            ids[1]);
  const std::vector<uint32_t> indices{2};
  frame.first_node = 0;
  frame.node_indices = indices;
  const auto* partial = transforms_in(transforms.encode(frame, 0));
  ASSERT_EQ(partial->transforms()->size(), 1u);
  EXPECT_EQ(partial->transforms()->Get(0)->child_frame_id()->str(), ids[2]);
  frame.node_count = 4;
  EXPECT_TRUE(transforms.encode(frame, 0).empty());
}

// Viewers rotate a glTF model by 90 degrees about X on load: a node at rest must coincide with the model
// then.
TEST(Foxglove, NodesMatchModelFrames) {
  record::FoxgloveTransforms transforms;
  wire::StreamDescription of_the_scene = zed_up_in_millimetres();
  of_the_scene.world_from_stream = wire::StreamDescription{}.world_from_stream;
  transforms.describe(of_the_scene);
  std::vector<wire::Affine3x4> poses(3);
  for (wire::Affine3x4& pose : poses) pose.m = {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3};
  wire::PoseFrameView frame;
  frame.node_count = 3;
  frame.poses = poses;
  const auto* node = transforms_in(transforms.encode(frame, 0))->transforms()->Get(0);
  EXPECT_EQ(node->translation()->x(), 1);
  EXPECT_EQ(node->translation()->y(), -3);
  EXPECT_EQ(node->translation()->z(), 2);
  EXPECT_NEAR(node->rotation()->x(), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(node->rotation()->w(), std::sqrt(0.5), 1e-12);
}

TEST(Foxglove, NothingIsLeftToReadersDefaults) {
  record::FoxgloveTransforms transforms;
  transforms.describe(zed_up_in_millimetres());
  const std::vector<wire::Affine3x4> poses(3);
  wire::PoseFrameView frame;
  frame.node_count = 3;
  frame.poses = poses;
  const auto* each = transforms_in(transforms.encode(frame, 0))->transforms()->Get(0);
  const auto* translation = reinterpret_cast<const flatbuffers::Table*>(each->translation());
  const auto* rotation = reinterpret_cast<const flatbuffers::Table*>(each->rotation());
  for (const flatbuffers::voffset_t field : {4, 6, 8}) EXPECT_TRUE(translation->CheckField(field));
  for (const flatbuffers::voffset_t field : {4, 6, 8, 10}) EXPECT_TRUE(rotation->CheckField(field));
}

TEST(Foxglove, RecordingHasItsChannelsBesideOurs) {
  record::LogOptions options;
  options.writer.chunk_bytes = 2000;
  options.foxglove = true;
  options.models.push_back({"scene.glb", "model/gltf-binary", Bytes(100, std::byte{42})});
  MemoryLog memory(options), plain({.writer = options.writer});
  for (MemoryLog* log : {&memory, &plain}) {
    ASSERT_TRUE(log->take(description(7), 0));
    for (uint64_t s = 1; s <= 60; ++s) ASSERT_TRUE(log->take(frame(7, s), s));
    ASSERT_TRUE(log->log.finish().ok());
  }
  auto reader = record::Reader::open(source_of(*memory.files[0]));
  ASSERT_TRUE(reader.ok());
  std::map<std::string, std::vector<Bytes>> by_topic;
  record::Message message;
  uint64_t sequence = 0;
  while (reader->next(message) == record::Reader::Step::message) {
    const record::Channel& channel = reader->index().channels.at(message.channel_id);
    by_topic[channel.topic].emplace_back(message.data.begin(), message.data.end());
    const record::Schema& schema = reader->index().schemas.at(channel.schema_id);
    EXPECT_EQ(schema.encoding, "flatbuffer");
    if (channel.topic == "/arm/transforms") {
      EXPECT_EQ(schema.name, "foxglove.FrameTransforms");
      EXPECT_TRUE(std::ranges::equal(schema.data, record::transforms_schema()));
      EXPECT_EQ(message.sequence, ++sequence);
      EXPECT_EQ(message.log_time_ns, kBegun_ns + sequence * kMs);
      const auto* moved = transforms_in(message.data)->transforms();
      ASSERT_EQ(moved->size(), 3u);
      EXPECT_EQ(moved->Get(1)->translation()->x(), static_cast<double>(sequence * 10 + 1));
    }
  }
  EXPECT_EQ(sequence, 60u);
  ASSERT_EQ(by_topic["/scene"].size(), 1u);
  const Bytes& scene = by_topic["/scene"][0];
  flatbuffers::Verifier verifier(reinterpret_cast<const uint8_t*>(scene.data()), scene.size());
  ASSERT_TRUE(verifier.VerifyBuffer<foxglove::SceneUpdate>());
  const auto* entity = flatbuffers::GetRoot<foxglove::SceneUpdate>(scene.data())->entities()->Get(0);
  EXPECT_EQ(entity->id()->str(), "scene.glb");
  EXPECT_EQ(entity->frame_id()->str(), "world");
  const auto* model = entity->models()->Get(0);
  EXPECT_EQ(model->media_type()->str(), "model/gltf-binary");
  ASSERT_EQ(model->data()->size(), 100u);
  EXPECT_EQ(model->data()->Get(99), 42);
  EXPECT_EQ(model->scale()->x(), 1);
  // The native channels are equal with and without Foxglove's.
  auto with = record::Playback::open(source_of(*memory.files[0]));
  auto without = record::Playback::open(source_of(*plain.files[0]));
  ASSERT_TRUE(with.ok() && without.ok());
  with->rewind();
  without->rewind();
  record::Played a, b;
  for (;;) {
    const auto step = with->next(a);
    ASSERT_EQ(step, without->next(b));
    if (step == record::Playback::Step::end) break;
    EXPECT_TRUE(std::ranges::equal(a.message, b.message));
  }
  EXPECT_EQ(with->refused(), 0u);
}

// --- frame count

wire::PoseFrameView part(uint64_t sequence, uint32_t first, uint32_t count) {
  static const std::vector<wire::Affine3x4> poses(10);
  wire::PoseFrameView view;
  view.header.sequence = sequence;
  view.node_count = 10;
  view.first_node = first;
  view.poses = std::span(poses).first(count);
  return view;
}

TEST(FrameCounter, RepeatedPosesCountOnce) {
  record::FrameCounter tally;
  tally.take(part(1, 0, 5));
  tally.take(part(1, 0, 5));  // repeated
  EXPECT_EQ(tally.incomplete(true), 1u);
  tally.take(part(2, 0, 6));
  tally.take(part(2, 2, 4));  // within the part before
  EXPECT_EQ(tally.incomplete(true), 2u);
  wire::PoseFrameView other_time = part(2, 6, 4);
  other_time.header.sim_time_ns = 1;
  tally.take(other_time);
  EXPECT_EQ(tally.incomplete(true), 2u);
  tally.take(part(2, 4, 6));  // overlapping, with the rest
  EXPECT_EQ(tally.incomplete(true), 1u);
  EXPECT_EQ(tally.counts().late, 3u);
}

TEST(FrameCounter, FramePartsMayCross) {
  record::FrameCounter tally;
  EXPECT_TRUE(tally.take(part(1, 0, 5)));
  EXPECT_TRUE(tally.take(part(2, 0, 5)));
  EXPECT_EQ(tally.incomplete(false), 1u);
  EXPECT_FALSE(tally.take(part(1, 5, 5)));
  EXPECT_FALSE(tally.take(part(2, 5, 5)));
  EXPECT_EQ(tally.incomplete(true), 0u);
  EXPECT_TRUE(tally.take(part(4, 0, 10)));
  EXPECT_FALSE(tally.take(part(2, 5, 5)));  // repeated
  EXPECT_FALSE(tally.take(part(3, 0, 10)));
  EXPECT_TRUE(tally.take(part(5, 0, 9)));
  EXPECT_EQ(tally.incomplete(false), 0u);
  EXPECT_EQ(tally.incomplete(true), 1u);
  const record::FrameCounts& counts = tally.counts();
  EXPECT_EQ(counts.frames, 4u);
  EXPECT_EQ(counts.parts, 6u);
  EXPECT_EQ(counts.missing, 1u);
  EXPECT_EQ(counts.late, 2u);
  tally.begin();
  EXPECT_TRUE(tally.take(part(1, 0, 10)));
  EXPECT_EQ(counts.missing, 1u);
  EXPECT_EQ(tally.incomplete(true), 1u);
  for (uint64_t sequence = 2; sequence < 100; ++sequence) tally.take(part(sequence, 0, 1));
  EXPECT_EQ(tally.incomplete(true), 99u);
}

// Jitter: all parts of a frame are overtaken by the next frame.
TEST(FrameCounter, OvertakenFramesAreNotMissing) {
  record::FrameCounter tally;
  EXPECT_TRUE(tally.take(part(2, 0, 5)));
  EXPECT_TRUE(tally.take(part(4, 0, 5)));
  EXPECT_EQ(tally.counts().missing, 1u);
  EXPECT_TRUE(tally.take(part(3, 0, 5)));
  EXPECT_EQ(tally.counts().missing, 0u);
  EXPECT_FALSE(tally.take(part(3, 5, 5)));
  EXPECT_FALSE(tally.take(part(3, 5, 5))) << "repeated";
  EXPECT_FALSE(tally.take(part(1, 5, 5))) << "before the first";
  EXPECT_EQ(tally.counts().frames, 3u);
  EXPECT_EQ(tally.counts().late, 2u);
  EXPECT_EQ(tally.incomplete(true), 2u);
}

}  // namespace
}  // namespace fire3dv::record_test
