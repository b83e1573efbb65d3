// Test of the frame receiver on its own: one stream, no scene.
#include "renderer/state/frame_receiver.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::state {
namespace {

constexpr uint64_t kReceiverEpoch = 42;
constexpr uint32_t kNodes = 3;

// Poses [first, first + count) of a frame; every pose contains the frame's sequence.
bool push(FrameReceiver& receiver, uint64_t sequence, uint64_t scene_version = 0, uint32_t first = 0,
          uint32_t count = kNodes) {
  std::vector<wire::Affine3x4> poses(count);
  for (wire::Affine3x4& pose : poses) pose.m[3] = static_cast<float>(sequence);
  wire::PoseFrameView frame;
  frame.header.epoch = kReceiverEpoch;
  frame.header.sequence = sequence;
  frame.header.scene_version = scene_version;
  frame.node_count = kNodes;
  frame.first_node = first;
  frame.poses = poses;
  return receiver.push(frame);
}

wire::SceneEdit edit(uint64_t version, wire::EditValue value) {
  return {kReceiverEpoch, version, "node", wire::Property::node, std::move(value)};
}

TEST(FrameReceiver, PartsShowTogether) {
  FrameReceiver receiver(kReceiverEpoch, kNodes);
  EXPECT_FALSE(push(receiver, 1, 0, 0, 1));
  EXPECT_FALSE(push(receiver, 2, 0, 1, 2));
  EXPECT_EQ(receiver.header.sequence, 0u);
  EXPECT_TRUE(push(receiver, 2, 0, 0, 1));
  EXPECT_EQ(receiver.header.sequence, 2u);
  ASSERT_EQ(receiver.poses.size(), kNodes);
  for (const wire::Affine3x4& pose : receiver.poses) EXPECT_EQ(pose.m[3], 2.0f);
  EXPECT_EQ(receiver.frames_incomplete, 1u);
  EXPECT_EQ(receiver.frames_received, 1u);
}

// The playout buffer has the frame: it is whole, although it is not shown yet.
TEST(FrameReceiver, BufferedFramesAreNotIncomplete) {
  FrameReceiver receiver(kReceiverEpoch, kNodes);
  receiver.interpolate(0);
  for (uint64_t sequence = 1; sequence <= 20; ++sequence) {
    push(receiver, sequence, 0, 0, 1);
    push(receiver, sequence, 0, 1, 2);
  }
  receiver.advance(INT64_MAX / 2);
  EXPECT_EQ(receiver.frames_received, 20u);
  EXPECT_EQ(receiver.frames_incomplete, 0u);
}

TEST(FrameReceiver, EverySampleOfScalarsCounts) {
  FrameReceiver receiver(kReceiverEpoch, kNodes);
  const auto scalars = [](uint64_t version, wire::Property property, wire::EditValue value) {
    return wire::SceneEdit{kReceiverEpoch, version, "arm", property, std::move(value)};
  };
  receiver.apply(scalars(2, wire::Property::scalars, wire::Scalars{{"energy"}, {"J"}}));
  for (uint64_t i = 0; i < 10; ++i)
    receiver.apply(scalars(3 + i, wire::Property::scalar_values,
                           wire::ScalarValues{2, static_cast<int64_t>(i), {0.5 * static_cast<double>(i)}}));
  receiver.apply(scalars(5, wire::Property::scalar_values, wire::ScalarValues{2, 50, {1}}));
  receiver.apply(scalars(20, wire::Property::scalar_values, wire::ScalarValues{7, 50, {1}}));
  EXPECT_FALSE(receiver.has_new_edits()) << "they change no node";
  EXPECT_EQ(receiver.edits_received, 12u);
  EXPECT_EQ(receiver.edits_stale, 1u);
  EXPECT_EQ(receiver.scalars_unmatched, 1u);
  EXPECT_EQ(receiver.scalars().groups().at("arm").size(), 10u);
  EXPECT_TRUE(push(receiver, 1, 20)) << "a frame that waits for their version is shown";
}

TEST(FrameReceiver, FrameWaitsForItsEdits) {
  FrameReceiver receiver(kReceiverEpoch, kNodes);
  receiver.load_assets_asynchronously();
  EXPECT_FALSE(push(receiver, 1, 5));
  EXPECT_FALSE(receiver.has_new_edits());
  EXPECT_FALSE(receiver.apply(edit(5, wire::NodeAdded{})));
  EXPECT_TRUE(receiver.has_new_edits());
  EXPECT_FALSE(receiver.has_applied_edits());
  EXPECT_EQ(receiver.take_edits().edits.size(), 1u);
  EXPECT_TRUE(receiver.has_applied_edits());
  EXPECT_FALSE(receiver.finish_edit(4)) << "another version";
  EXPECT_TRUE(receiver.finish_edit(5));
  EXPECT_EQ(receiver.header.sequence, 1u);
  EXPECT_EQ(receiver.frames_queued, 1u);
}

TEST(FrameReceiver, OtherEpochsAreDropped) {
  FrameReceiver other_epoch(kReceiverEpoch + 1, kNodes), other_count(kReceiverEpoch, kNodes + 1);
  EXPECT_FALSE(push(other_epoch, 1));
  EXPECT_FALSE(push(other_count, 1));
  EXPECT_EQ(other_epoch.frames_stale, 1u);
  EXPECT_EQ(other_count.frames_refused, 1u);
  EXPECT_FALSE(other_epoch.apply(edit(1, wire::NodeRemoved{})));
  EXPECT_EQ(other_epoch.edits_stale, 1u);
}

TEST(FrameReceiver, RefusalIsReportedPerResource) {
  PeerLimits limits;
  limits.of(Resource::pose_bytes) = 1;
  limits.of(Resource::edits) = 0;
  FrameReceiver receiver(kReceiverEpoch, kNodes, BudgetPool::create(limits)->add_peer("peer"));
  for (uint64_t sequence = 1; sequence <= 3; ++sequence) EXPECT_FALSE(push(receiver, sequence));
  for (uint64_t version = 1; version <= 3; ++version) receiver.apply(edit(version, wire::NodeRemoved{}));
  const std::vector<FrameReceiver::Refusal> refusals = receiver.take_refusals();
  ASSERT_EQ(refusals.size(), 2u);
  EXPECT_EQ(refusals[0].resource, Resource::pose_bytes);
  EXPECT_NE(refusals[0].message.find("--peer-limit pose-bytes="), std::string::npos) << refusals[0].message;
  EXPECT_EQ(refusals[1].resource, Resource::edits);
  EXPECT_TRUE(receiver.take_refusals().empty());
  EXPECT_EQ(receiver.frames_refused, 3u);
  EXPECT_EQ(receiver.edits_refused, 3u);
}

}  // namespace
}  // namespace fire3dv::state
