// Test of frame assembly: only whole frames are shown, the newest wins, and all others are counted.
#include <gtest/gtest.h>

#include "renderer/state/pose_state.h"

namespace fire3dv::state {
namespace {

constexpr uint64_t kEpoch = 42;

class PoseFrames : public testing::Test {
 protected:
  PoseFrames() {
    wire::StreamDescription description;
    description.adapter_name = "test";
    description.epoch = kEpoch;
    description.node_names = {"a", "b", "c", "d"};
    id_ = state_.add_stream(description);
  }

  // Poses [first, first + count) of a frame of 4; every pose contains the frame's sequence.
  bool push(uint64_t sequence, uint32_t first = 0, uint32_t count = 4, uint64_t epoch = kEpoch,
            uint32_t node_count = 4, int64_t sim_time_ns = 0) {
    std::vector<wire::Affine3x4> poses(count);
    for (uint32_t i = 0; i < count; ++i) {
      poses[i].m[3] = static_cast<float>(sequence);
      poses[i].m[7] = static_cast<float>(first + i);
    }
    wire::PoseFrameView frame;
    frame.header.epoch = epoch;
    frame.header.sequence = sequence;
    frame.header.sim_time_ns = sim_time_ns;
    frame.node_count = node_count;
    frame.first_node = first;
    frame.poses = poses;
    return state_.push(id_, frame);
  }

  const Stream& stream() const { return state_.streams()[id_]; }

  void expect_shown(uint64_t sequence) const {
    EXPECT_EQ(stream().header.sequence, sequence);
    ASSERT_EQ(stream().poses.size(), 4u);
    for (uint32_t i = 0; i < 4; ++i) {
      EXPECT_EQ(stream().poses[i].m[3], static_cast<float>(sequence)) << i;
      EXPECT_EQ(stream().poses[i].m[7], static_cast<float>(i));
    }
  }

  scene::Scene scene_;
  PoseState state_{scene_};
  StreamId id_ = 0;
};

TEST_F(PoseFrames, NothingIsShownAtFirst) {
  EXPECT_TRUE(state_.shown().empty());
  EXPECT_EQ(stream().header.sequence, 0u);
  EXPECT_FALSE(push(0)) << "sequences start at 1";
}

TEST_F(PoseFrames, WholeFramesAreTagged) {
  const uint64_t before = stream().revision;
  EXPECT_TRUE(push(5, 0, 4, kEpoch, 4, 123));
  expect_shown(5);
  EXPECT_EQ(stream().revision, before + 1);
  EXPECT_EQ(stream().frames_received, 1u);
  ASSERT_EQ(state_.shown().size(), 1u);
  EXPECT_EQ(state_.shown()[0].stream, "test");
  EXPECT_EQ(state_.shown()[0].epoch, kEpoch);
  EXPECT_EQ(state_.shown()[0].sequence, 5u);
  EXPECT_EQ(state_.shown()[0].sim_time_ns, 123);
}

TEST_F(PoseFrames, OlderFramesAreStale) {
  push(5);
  const uint64_t revision = stream().revision;
  EXPECT_FALSE(push(5));
  EXPECT_FALSE(push(4));
  EXPECT_FALSE(push(4, 0, 2));
  EXPECT_EQ(stream().frames_stale, 3u);
  EXPECT_EQ(stream().revision, revision);
  expect_shown(5);
}

TEST_F(PoseFrames, AnotherEpochIsDropped) {
  EXPECT_FALSE(push(9, 0, 4, kEpoch + 1));
  EXPECT_EQ(stream().frames_stale, 1u);
  EXPECT_TRUE(push(1));
}

TEST_F(PoseFrames, WrongCountsAreRefused) {
  EXPECT_FALSE(push(1, 0, 3, kEpoch, 3));
  EXPECT_FALSE(push(1, 0, 4, kEpoch, 5));
  EXPECT_FALSE(push(1, 3, 2)) << "reaches beyond the frame";
  EXPECT_FALSE(push(1, UINT32_MAX, 2)) << "must not wrap";
  EXPECT_FALSE(push(1, 0, 0)) << "an empty part";
  EXPECT_EQ(stream().frames_refused, 5u);
  EXPECT_EQ(stream().header.sequence, 0u);
}

TEST_F(PoseFrames, PartOrderIsFree) {
  EXPECT_FALSE(push(1, 3, 1));
  EXPECT_FALSE(push(1, 0, 2));
  EXPECT_TRUE(state_.shown().empty()) << "never half a frame";
  EXPECT_TRUE(push(1, 2, 1));
  expect_shown(1);
  EXPECT_EQ(stream().frames_incomplete, 0u);
}

TEST_F(PoseFrames, RepeatedPartsCountOnce) {
  EXPECT_FALSE(push(1, 0, 2));
  EXPECT_FALSE(push(1, 0, 2));
  EXPECT_EQ(stream().frames_stale, 1u);
  EXPECT_FALSE(push(1, 1, 2)) << "overlaps, brings one pose";
  EXPECT_TRUE(push(1, 2, 2));
  expect_shown(1);
}

TEST_F(PoseFrames, FramesMayInterleave) {
  EXPECT_FALSE(push(1, 0, 2));
  EXPECT_FALSE(push(2, 0, 2));
  EXPECT_TRUE(push(1, 2, 2));
  expect_shown(1);
  EXPECT_TRUE(push(2, 2, 2));
  expect_shown(2);
  EXPECT_EQ(stream().frames_incomplete, 0u);
}

TEST_F(PoseFrames, NewerFrameClosesOlder) {
  EXPECT_FALSE(push(1, 0, 2));
  EXPECT_FALSE(push(2, 0, 2));
  EXPECT_TRUE(push(3));
  EXPECT_EQ(stream().frames_incomplete, 2u);
  EXPECT_FALSE(push(2, 2, 2));
  EXPECT_EQ(stream().frames_stale, 1u);
  expect_shown(3);
}

TEST_F(PoseFrames, IncompleteFramesAreDropped) {
  for (uint64_t sequence = 1; sequence <= 1000; ++sequence) EXPECT_FALSE(push(sequence, 0, 3));
  EXPECT_GE(stream().frames_incomplete, 900u);
  EXPECT_FALSE(push(1, 3, 1)) << "long given up";
  EXPECT_TRUE(push(1000, 3, 1));
  expect_shown(1000);
  EXPECT_EQ(stream().frames_incomplete, 999u);
}

TEST_F(PoseFrames, StepsAreNotMixed) {
  EXPECT_FALSE(push(1, 0, 2, kEpoch, 4, 1000));
  EXPECT_FALSE(push(1, 2, 2, kEpoch, 4, 2000));
  EXPECT_EQ(stream().frames_refused, 1u);
  EXPECT_TRUE(state_.shown().empty());
  EXPECT_TRUE(push(1, 2, 2, kEpoch, 4, 1000));
}

TEST_F(PoseFrames, NodelessFramesCount) {
  wire::StreamDescription description;
  description.epoch = 3;
  const StreamId id = state_.add_stream(description);
  wire::PoseFrameView frame;
  frame.header.epoch = 3;
  frame.header.sequence = 1;
  EXPECT_TRUE(state_.push(id, frame));
  EXPECT_EQ(state_.streams()[id].header.sequence, 1u);
}

// Four parts of one pose each are charged for these poses, not for the claimed frame size.
TEST(PoseMemory, FollowsPosesThatHaveArrived) {
  PeerLimits limits;
  limits.of(Resource::pose_bytes) = uint64_t{120} << 20;
  const auto budget = BudgetPool::create(limits)->add_peer("peer");
  scene::Scene scene;
  PoseState state(scene);
  wire::StreamDescription description;
  description.epoch = kEpoch;
  const uint32_t count = 1u << 20;
  for (uint32_t i = 0; i < count; ++i) description.node_names.push_back(std::to_string(i));
  const StreamId id = state.add_stream(description, budget);
  const std::vector<wire::Affine3x4> poses(count);
  wire::PoseFrameView frame;
  frame.header.epoch = kEpoch;
  frame.node_count = count;
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
    frame.header.sequence = sequence;
    frame.first_node = static_cast<uint32_t>(sequence) * 200'000;
    frame.poses = {poses.data(), 1};
    EXPECT_FALSE(state.push(id, frame));
  }
  EXPECT_GT(budget->used(Resource::pose_bytes), 0u);
  EXPECT_LT(budget->used(Resource::pose_bytes), 64u << 10);

  frame.header.sequence = 5;
  frame.first_node = 0;
  frame.poses = poses;
  EXPECT_TRUE(state.push(id, frame));
  EXPECT_GE(budget->used(Resource::pose_bytes), count * sizeof(wire::Affine3x4));
  // The next two wait for edits; the budget has room for one.
  frame.header.scene_version = 1;
  for (frame.header.sequence = 6; frame.header.sequence <= 7; ++frame.header.sequence) {
    frame.header.scene_version = frame.header.sequence;
    EXPECT_FALSE(state.push(id, frame));
  }
  EXPECT_EQ(state.streams()[id].frames_queued, 1u);
  EXPECT_EQ(state.streams()[id].frames_refused, 1u);
  EXPECT_LE(budget->used(Resource::pose_bytes), uint64_t{120} << 20);
  ASSERT_EQ(state.take_refusals().size(), 1u);
  state.remove_stream(id);
  EXPECT_EQ(budget->used(Resource::pose_bytes), 0u);
}

}  // namespace
}  // namespace fire3dv::state
