// Test of scene edits in the pose state: frames wait for their edits, and consumers get the newest value of
// each key.
#include <gtest/gtest.h>

#include "renderer/state/pose_state.h"

namespace fire3dv::state {
namespace {

constexpr uint64_t kEditsEpoch = 42;

wire::SceneEdit visible(uint64_t version, const std::string& node, bool shown, uint64_t epoch = kEditsEpoch) {
  return {epoch, version, node, wire::Property::visible, wire::Visible{shown}};
}

class StateEdits : public testing::Test {
 protected:
  StateEdits() { id_ = add_stream(kEditsEpoch); }

  StreamId add_stream(uint64_t epoch) {
    wire::StreamDescription description;
    description.epoch = epoch;
    description.node_names = {"a", "b", "c", "d"};
    return state_.add_stream(description);
  }

  static std::vector<wire::Affine3x4> poses_of(float x, size_t count = 4) {
    std::vector<wire::Affine3x4> poses(count);
    for (auto& pose : poses) pose.m[3] = x;
    return poses;
  }

  wire::PoseFrameView frame(uint64_t sequence, uint64_t version) {
    wire::PoseFrameView result;
    result.header.epoch = kEditsEpoch;
    result.header.sequence = sequence;
    result.header.scene_version = version;
    result.node_count = 4;
    return result;
  }
  bool push(uint64_t sequence, uint64_t version) {
    const auto poses = poses_of(static_cast<float>(sequence));
    wire::PoseFrameView whole = frame(sequence, version);
    whole.poses = poses;
    return state_.push(id_, whole, now_ns_, now_ns_);
  }
  bool push_partial(uint64_t sequence, std::vector<uint32_t> nodes, uint64_t version = 0) {
    const auto poses = poses_of(static_cast<float>(sequence), nodes.size());
    wire::PoseFrameView partial = frame(sequence, version);
    partial.poses = poses;
    partial.node_indices = nodes;
    return state_.push(id_, partial, now_ns_, now_ns_);
  }
  bool push_part(uint64_t sequence, uint32_t first, uint32_t count) {
    const auto poses = poses_of(static_cast<float>(sequence), count);
    wire::PoseFrameView part = frame(sequence, 0);
    part.first_node = first;
    part.poses = poses;
    return state_.push(id_, part, now_ns_, now_ns_);
  }

  const Stream& stream() const { return state_.streams()[id_]; }
  uint64_t shown() const { return stream().header.sequence; }
  std::vector<float> shown_x() const {
    std::vector<float> x;
    for (const auto& pose : stream().poses) x.push_back(pose.m[3]);
    return x;
  }

  scene::Scene scene_;
  PoseState state_{scene_};
  StreamId id_ = 0;
  int64_t now_ns_ = 1;
};

TEST_F(StateEdits, FrameWaitsForItsEdits) {
  EXPECT_TRUE(push(1, 0));
  EXPECT_FALSE(push(2, 2));
  EXPECT_EQ(shown(), 1u);
  EXPECT_FALSE(state_.apply(id_, visible(1, "a", false)));
  EXPECT_EQ(shown(), 1u);
  EXPECT_TRUE(state_.apply(id_, visible(2, "b", false)));
  EXPECT_EQ(shown(), 2u);
  EXPECT_EQ(stream().frames_queued, 1u);
  EXPECT_EQ(stream().frames_superseded, 0u);
  EXPECT_TRUE(push(3, 1)) << "newer edits are no reason to wait";
}

TEST_F(StateEdits, WaitingKeepsNextAndNewest) {
  push(1, 0);
  for (uint64_t i = 2; i <= 9; ++i) EXPECT_FALSE(push(i, i));
  EXPECT_EQ(stream().frames_superseded, 6u);
  EXPECT_TRUE(state_.apply(id_, visible(2, "a", false)));
  EXPECT_EQ(shown(), 2u);
  EXPECT_FALSE(state_.apply(id_, visible(8, "a", true)));
  EXPECT_TRUE(state_.apply(id_, visible(9, "a", false)));
  EXPECT_EQ(shown(), 9u);
}

TEST_F(StateEdits, LaggingEditsStillShow) {
  push(1, 0);
  uint64_t changes = 0, applied = 0;
  // Publishes one frame and one edit at a time; every second edit arrives.
  for (uint64_t i = 2; i <= 200; ++i) {
    push(i, i);
    if (i % 2 == 0) changes += state_.apply(id_, visible(++applied + 1, "a", false));
  }
  EXPECT_GT(changes, 3u) << "the picture stood still";
}

TEST_F(StateEdits, NewestVersionIsTaken) {
  state_.apply(id_, visible(1, "a", false));
  state_.apply(id_, visible(2, "b", false));
  state_.apply(id_, visible(3, "a", true));
  state_.apply(id_, {kEditsEpoch, 4, "a", wire::Property::base_color, wire::BaseColor{}});
  auto changes = state_.take_scene_changes();
  ASSERT_EQ(changes.size(), 1u);
  ASSERT_EQ(changes[0].edits.size(), 3u);
  EXPECT_EQ(changes[0].edits[0], visible(2, "b", false));
  EXPECT_EQ(changes[0].edits[1], visible(3, "a", true));
  EXPECT_EQ(changes[0].edits[2].version, 4u);
  EXPECT_TRUE(state_.take_scene_changes().empty());
  state_.apply(id_, visible(4, "a", false));
  state_.apply(id_, visible(5, "a", false, kEditsEpoch + 1));
  EXPECT_TRUE(state_.take_scene_changes().empty());
  EXPECT_EQ(stream().edits_stale, 2u);
  EXPECT_EQ(stream().edits_received, 4u);
}

TEST_F(StateEdits, LaterVersionIsCounted) {
  EXPECT_FALSE(push(1, 1));
  EXPECT_TRUE(state_.apply(id_, wire::UnknownEdit{kEditsEpoch, 1}));
  EXPECT_TRUE(state_.take_scene_changes().empty());
}

TEST_F(StateEdits, EndedStreamIsReported) {
  const StreamId second = add_stream(kEditsEpoch + 1);
  state_.apply(second, visible(1, "a", false, kEditsEpoch + 1));
  state_.apply(id_, visible(1, "b", false));
  auto changes = state_.take_scene_changes();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].stream, id_) << "the older one first";
  state_.remove_stream(id_);
  id_ = add_stream(kEditsEpoch + 2);
  state_.apply(id_, visible(1, "c", false, kEditsEpoch + 2));
  changes = state_.take_scene_changes();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_TRUE(changes[0].ended);
  EXPECT_EQ(changes[0].epoch, kEditsEpoch);
  EXPECT_EQ(changes[1].epoch, kEditsEpoch + 2);
  EXPECT_GT(changes[1].age, changes[0].age);
  state_.remove_stream(second);
  const StreamId third = add_stream(kEditsEpoch + 3);
  state_.apply(third, visible(1, "c", false, kEditsEpoch + 3));
  state_.remove_stream(third);  // none of its edits was delivered
  changes = state_.take_scene_changes();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].epoch, kEditsEpoch + 1);
}

TEST_F(StateEdits, FrameWaitsForAsset) {
  state_.remove_stream(id_);
  state_.load_assets_asynchronously();
  id_ = add_stream(kEditsEpoch);
  wire::NodeAdded node;
  node.asset_uri = "a.glb";
  state_.apply(id_, {kEditsEpoch, 1, "n", wire::Property::node, node});
  EXPECT_FALSE(push(1, 1));
  state_.apply(id_, visible(2, "a", false));
  EXPECT_EQ(shown(), 0u);
  EXPECT_FALSE(state_.finish_edit(id_, kEditsEpoch + 1, 1));
  EXPECT_TRUE(state_.finish_edit(id_, kEditsEpoch, 1));
  EXPECT_EQ(shown(), 1u);
  // An edit replaced before its delivery is never loaded.
  state_.apply(id_, {kEditsEpoch, 3, "m", wire::Property::node, node});
  EXPECT_FALSE(push(2, 3));
  EXPECT_TRUE(state_.apply(id_, {kEditsEpoch, 4, "m", wire::Property::node, wire::Cleared{}}));
  EXPECT_EQ(shown(), 2u);
}

TEST_F(StateEdits, LimitStopsNoFrame) {
  PeerLimits limits;
  limits.of(Resource::edits) = 2;
  limits.of(Resource::edit_bytes) = 4096;
  StreamEdits edits(BudgetPool::create(limits)->add_peer("peer"));
  EXPECT_EQ(edits.add(visible(1, "a", false)), StreamEdits::Outcome::accepted);
  EXPECT_EQ(edits.add(visible(2, "b", false)), StreamEdits::Outcome::accepted);
  EXPECT_EQ(edits.add(visible(3, "c", false)), StreamEdits::Outcome::refused);
  EXPECT_EQ(edits.applied(), 3u);
  wire::Vertices vertices;
  vertices.positions.resize(1000);
  EXPECT_EQ(edits.add({kEditsEpoch, 4, "a", wire::Property::vertices, vertices}),
            StreamEdits::Outcome::refused);
  EXPECT_EQ(edits.add(visible(5, "a", true)), StreamEdits::Outcome::accepted);
  EXPECT_EQ(edits.take().edits.size(), 2u);
}

// Edits are charged until they are cleared or replaced or their stream ends, also after their delivery.
TEST_F(StateEdits, EditsInForceAreCharged) {
  PeerLimits limits;
  limits.of(Resource::edits) = 60;
  limits.of(Resource::edit_bytes) = 1 << 20;
  const auto budget = BudgetPool::create(limits)->add_peer("peer");
  state_.remove_stream(id_);
  wire::StreamDescription description;
  description.epoch = kEditsEpoch;
  id_ = state_.add_stream(description, budget);
  wire::Vertices vertices;
  vertices.positions.resize(8192);  // 96 KiB
  std::vector<SceneChanges> in_force;
  uint64_t version = 0;
  const auto set = [&](const std::string& node, wire::EditValue value) {
    state_.apply(id_, {kEditsEpoch, ++version, node, wire::Property::vertices, std::move(value)});
    for (SceneChanges& changes : state_.take_scene_changes()) in_force.push_back(std::move(changes));
  };
  for (int i = 0; i < 30; ++i) set("nobody " + std::to_string(i), vertices);
  EXPECT_EQ(stream().edits_received, 10u);
  EXPECT_EQ(stream().edits_refused, 20u);
  EXPECT_EQ(budget->used(Resource::edits), 10u);
  EXPECT_LE(budget->used(Resource::edit_bytes), uint64_t{1} << 20);
  EXPECT_GE(budget->used(Resource::edit_bytes), 10u * 96 * 1024);
  EXPECT_TRUE(push(1, version) || shown() == 0) << "a refused edit counts as applied";
  const std::vector<BudgetRefusal> refusals = state_.take_refusals();
  ASSERT_EQ(refusals.size(), 1u) << "said once";
  EXPECT_EQ(refusals[0].resource, Resource::edit_bytes);
  EXPECT_NE(refusals[0].message.find("--peer-limit edit-bytes"), std::string::npos) << refusals[0].message;

  for (int i = 0; i < 10; ++i) set("nobody " + std::to_string(i), wire::Cleared{});
  in_force.clear();
  EXPECT_EQ(budget->used(Resource::edits), 0u) << "keys are forgotten with their values";
  EXPECT_EQ(budget->used(Resource::edit_bytes), 0u);
  for (int i = 0; i < 1000; ++i) set("never set " + std::to_string(i), wire::Cleared{});
  EXPECT_EQ(budget->used(Resource::edits), 0u);
  for (int i = 0; i < 100; ++i)
    state_.apply(id_, {kEditsEpoch, ++version, std::to_string(i), wire::Property::visible, wire::Visible{}});
  EXPECT_EQ(budget->used(Resource::edits), 60u);
  EXPECT_EQ(state_.take_refusals().size(), 1u);
  // At the limit an existing value can be replaced.
  const uint64_t refused = stream().edits_refused;
  (void)state_.take_scene_changes();
  state_.apply(id_, {kEditsEpoch, ++version, "5", wire::Property::visible, wire::Visible{false}});
  EXPECT_EQ(stream().edits_refused, refused);
  state_.remove_stream(id_);
  EXPECT_EQ(budget->used(Resource::edits), 0u);
}

TEST_F(StateEdits, PartialExtendsNewest) {
  EXPECT_FALSE(push_partial(1, {0}));
  EXPECT_EQ(stream().frames_without_base, 1u);
  push(2, 0);
  EXPECT_TRUE(push_partial(3, {1, 3}));
  EXPECT_EQ(shown_x(), (std::vector<float>{2, 3, 2, 3}));
  EXPECT_FALSE(push_partial(3, {0}));
  EXPECT_EQ(stream().frames_stale, 1u);
  // A partial frame may also build on a waiting frame.
  EXPECT_FALSE(push(4, 1));
  EXPECT_FALSE(push_partial(5, {0}, 1));
  EXPECT_TRUE(state_.apply(id_, visible(1, "a", false)));
  EXPECT_EQ(shown(), 5u);
  EXPECT_EQ(shown_x(), (std::vector<float>{5, 4, 4, 4}));
}

TEST_F(StateEdits, WholeRepairsPartial) {
  push(1, 0);
  push_partial(3, {1});  // 2 was lost; it moved node 0
  EXPECT_FALSE(push_part(3, 0, 2));
  EXPECT_TRUE(push_part(3, 2, 2));
  EXPECT_EQ(shown_x(), (std::vector<float>{3, 3, 3, 3}));
  EXPECT_FALSE(push(3, 0)) << "once";
  EXPECT_EQ(stream().frames_stale, 1u);
  EXPECT_EQ(stream().frames_incomplete, 0u);
}

TEST_F(StateEdits, InterpolatedStreamIsRepairedToo) {
  state_.interpolate(id_, 0);
  now_ns_ = 1'000'000'000;
  push(1, 0);
  push_partial(2, {1});
  now_ns_ += 1'000'000'000;
  state_.advance(now_ns_);
  EXPECT_EQ(shown_x(), (std::vector<float>{1, 2, 1, 1}));
  push(2, 0);
  EXPECT_TRUE(state_.advance(now_ns_));
  EXPECT_EQ(shown_x(), (std::vector<float>{2, 2, 2, 2}));
}

}  // namespace
}  // namespace fire3dv::state
