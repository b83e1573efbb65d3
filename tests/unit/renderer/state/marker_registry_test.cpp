// Test of markers in force: lifetimes, parents, ends of streams, budgets and reports. No GPU.
#include "renderer/state/marker_registry.h"

#include <gtest/gtest.h>

#include <set>

namespace fire3dv::state {
namespace {

// "hand" is below "arm".
scene::Scene robot() {
  scene::Scene scene;
  const auto add = [&](const char* name, uint32_t parent) {
    scene::Node& node = scene.nodes.emplace_back();
    node.name = node.path = name;
    node.parent = parent;
  };
  add("arm", scene::kNone);
  add("hand", 0);
  return scene;
}

wire::Marker points(float x = 0) {
  wire::Marker marker;
  marker.positions = {{x, 0, 0}};
  return marker;
}

class MarkerRegistryTest : public testing::Test {
 protected:
  StreamId stream(uint64_t epoch, std::shared_ptr<PeerBudget> budget = nullptr) {
    wire::StreamDescription description;
    description.epoch = epoch;
    description.adapter_name = "stream " + std::to_string(epoch);
    description.node_names = {"arm"};
    description.world_from_stream.m[3] = 100;  // x
    return poses_.add_stream(description, std::move(budget));
  }
  void edit(StreamId id, const std::string& name, wire::EditValue value) {
    poses_.apply(id,
                 {poses_.streams()[id].epoch, ++version_, name, wire::Property::marker, std::move(value)});
  }
  void publish(StreamId id, int64_t sim_time_ns, float x = 0) {
    std::vector<wire::Affine3x4> pose(1);
    pose[0].m[3] = x;
    wire::PoseFrameView frame;
    frame.header.epoch = poses_.streams()[id].epoch;
    frame.header.sequence = ++sequence_;
    frame.header.sim_time_ns = sim_time_ns;
    frame.node_count = 1;
    frame.poses = pose;
    EXPECT_TRUE(poses_.push(id, frame));
  }
  const std::vector<ShownMarker>& shown() {
    changes_ = poses_.take_scene_changes();
    is_changed_ = markers_.take_from(changes_);
    return markers_.resolve(poses_, edits_);
  }
  std::string log() {
    std::string text;
    for (const std::string& message : markers_.take_log_messages()) text += message + "\n";
    return text;
  }

  const scene::Scene scene_ = robot();
  PoseState poses_{scene_};
  scene::SceneEdits edits_;
  MarkerRegistry markers_;
  std::vector<SceneChanges> changes_;
  bool is_changed_ = false;
  uint64_t version_ = 0, sequence_ = 0;
};

TEST_F(MarkerRegistryTest, NewestValueStaysUntilCleared) {
  const StreamId id = stream(1);
  edit(id, "cloud", points(1));
  edit(id, "b", points(2));
  ASSERT_EQ(shown().size(), 2u);
  EXPECT_TRUE(is_changed_);
  EXPECT_TRUE(changes_.empty()) << "markers are no edits of nodes";
  const uint64_t cloud = shown()[1].id;
  EXPECT_FALSE(is_changed_);
  EXPECT_EQ(shown()[1].marker->positions[0][0], 1);
  edit(id, "b", points(3));
  EXPECT_EQ(shown()[0].marker->positions[0][0], 3);
  EXPECT_EQ(shown()[1].id, cloud) << "its arrays are not uploaded again";
  edit(id, "cloud", wire::Cleared{});
  EXPECT_EQ(shown().size(), 1u);
  edit(id, "b", wire::Marker{});
  EXPECT_TRUE(shown().empty()) << "a marker without positions";
  EXPECT_EQ(log(), "");
}

TEST_F(MarkerRegistryTest, HidesNamespacesOfStream) {
  const StreamId first = stream(1), second = stream(2);
  for (const char* name : {"a/1", "a/2/3", "a", "ab/1", "/b"}) edit(first, name, points());
  edit(second, "a/1", points(7));
  ASSERT_EQ(shown().size(), 6u);
  const std::map<std::string, size_t, std::less<>> counts{{"", 2}, {"a", 2}, {"ab", 1}};
  EXPECT_EQ(markers_.namespaces(1), counts);
  EXPECT_EQ(markers_.namespaces(2).size(), 1u);
  EXPECT_TRUE(markers_.namespaces(3).empty());

  const auto shown_without = [&](const MarkerNamespaces& hidden) {
    return markers_.resolve(poses_, edits_, true, hidden).size();
  };
  EXPECT_EQ(shown_without({{"stream 1", "a"}}), 4u);
  EXPECT_EQ(shown_without({{"stream 1", ""}}), 4u) << "those without a namespace";
  EXPECT_EQ(shown_without({{"stream 2", "a"}}), 5u);
  EXPECT_EQ(shown_without({{"stream 1", ""}, {"stream 1", "a"}, {"stream 1", "ab"}, {"stream 2", "a"}}), 0u);
  EXPECT_EQ(shown_without({{"stream", "a"}, {"stream 1", "a/2"}, {"stream 3", "a"}}), 6u);
  EXPECT_EQ(shown().size(), 6u) << "the registry keeps nothing of it";

  edit(first, "a/1", points(1));
  edit(first, "a/2/3", wire::Cleared{});
  edit(first, "ab/1", wire::Cleared{});
  (void)shown();
  EXPECT_EQ(markers_.namespaces(1), (std::map<std::string, size_t, std::less<>>{{"", 2}, {"a", 1}}));
}

TEST_F(MarkerRegistryTest, OtherEditsStay) {
  const StreamId id = stream(1);
  edit(id, "arm", points());
  poses_.apply(id, {1, ++version_, "arm", wire::Property::visible, wire::Visible{false}});
  EXPECT_EQ(shown().size(), 1u);
  ASSERT_EQ(changes_.size(), 1u);
  ASSERT_EQ(changes_[0].edits.size(), 1u);
  EXPECT_EQ(changes_[0].edits[0].property, wire::Property::visible);
}

TEST_F(MarkerRegistryTest, EndsWithItsStream) {
  const StreamId first = stream(1), second = stream(2);
  edit(first, "a", points(1));
  edit(second, "a", points(2));
  ASSERT_EQ(shown().size(), 2u) << "streams do not share names";
  poses_.remove_stream(first);
  ASSERT_EQ(shown().size(), 1u);
  EXPECT_TRUE(is_changed_);
  EXPECT_EQ(shown()[0].marker->positions[0][0], 2);
  poses_.suspend_stream(second, 1'000'000);
  EXPECT_TRUE(shown().empty());
  EXPECT_TRUE(markers_.empty());
}

TEST_F(MarkerRegistryTest, FrameIsStreamOrParent) {
  const StreamId id = stream(1);
  wire::Marker marker = points();
  marker.parent_from_marker.m[7] = 5;  // y
  edit(id, "a", marker);
  marker.parent = "hand";
  edit(id, "b", marker);
  publish(id, 0, 7);
  ASSERT_EQ(shown().size(), 2u);
  EXPECT_EQ(shown()[0].world_from_marker[3], glm::vec4(100, 5, 0, 1));
  EXPECT_EQ(shown()[1].world_from_marker[3], glm::vec4(107, 5, 0, 1));
  publish(id, 1, 8);
  EXPECT_EQ(shown()[1].world_from_marker[3], glm::vec4(108, 5, 0, 1)) << "the parent moves";
  scene::NodeEdits hidden;
  hidden[0].hidden = true;  // above the parent
  edits_.set(scene_, hidden);
  ASSERT_EQ(shown().size(), 1u);
  EXPECT_TRUE(shown()[0].marker->parent.empty());
}

TEST_F(MarkerRegistryTest, LifetimeIsSimulatedTime) {
  const StreamId id = stream(1);
  wire::Marker marker = points();
  marker.sim_time_ns = 1000;
  marker.lifetime_ns = 50;
  edit(id, "a", marker);
  EXPECT_TRUE(shown().empty()) << "no frame says what time it is";
  for (const auto& [time_ns, is_shown] :
       std::map<int64_t, bool>{{999, false}, {1000, true}, {1050, true}, {1051, false}, {INT64_MAX, false}}) {
    publish(id, time_ns);
    EXPECT_EQ(shown().size(), is_shown ? 1u : 0u) << time_ns;
  }
  publish(id, 1020);  // the simulator starts again
  EXPECT_EQ(shown().size(), 1u);
  marker.sim_time_ns = INT64_MIN;
  marker.lifetime_ns = UINT64_MAX;
  edit(id, "a", marker);
  for (const int64_t time_ns : {INT64_MIN, int64_t{0}, INT64_MAX}) {
    publish(id, time_ns);
    EXPECT_EQ(shown().size(), 1u) << time_ns;
  }
}

TEST_F(MarkerRegistryTest, HiddenMarkersAreReported) {
  const StreamId id = stream(1);
  wire::Marker marker = points();
  marker.kind = static_cast<wire::MarkerKind>(77);
  edit(id, "new", marker);
  EXPECT_TRUE(shown().empty());
  EXPECT_EQ(log(),
            "warning: the marker \"new\" is not shown: its kind 77 is of a later version: "
            "update the renderer\n");
  marker = points();
  marker.parent = "nobody";
  edit(id, "lost", marker);
  changes_ = poses_.take_scene_changes();
  markers_.take_from(changes_);
  EXPECT_TRUE(markers_.resolve(poses_, edits_, false).empty());
  EXPECT_EQ(log(), "") << "the node may still be added";
  EXPECT_TRUE(shown().empty());
  EXPECT_EQ(log(), "warning: the marker \"lost\" is not shown: no scene node is called \"nobody\"\n");
  EXPECT_TRUE(shown().empty());
  EXPECT_EQ(log(), "") << "once";
  marker = points();
  marker.parent_from_marker.m[3] = 1e12f;
  edit(id, "far", marker);
  EXPECT_EQ(shown().size(), 1u);
}

TEST_F(MarkerRegistryTest, BoundsVerticesOfStream) {
  const StreamId id = stream(1);
  publish(id, 0);
  wire::Marker capsules;
  capsules.kind = wire::MarkerKind::capsules;
  capsules.positions.resize(1'000'000);
  capsules.sizes = {{1, 1, 1}};
  edit(id, "a", capsules);
  EXPECT_EQ(shown().size(), 1u);
  edit(id, "b", capsules);
  EXPECT_EQ(shown().size(), 1u);
  EXPECT_NE(log().find("vertices"), std::string::npos);
  edit(id, "a", wire::Cleared{});  // makes room
  edit(id, "b", capsules);
  EXPECT_EQ(shown().size(), 1u);
  wire::Marker cloud;
  cloud.positions.resize(1'000'000);
  edit(id, "cloud", cloud);
  EXPECT_EQ(shown().size(), 2u);
}

TEST_F(MarkerRegistryTest, BoundsGlyphsOfStream) {
  const StreamId id = stream(1);
  publish(id, 0);
  wire::Marker texts;
  texts.kind = wire::MarkerKind::texts;
  texts.positions.resize(1024);
  texts.texts.assign(1024, std::string(1024, 'x'));
  for (int i = 0; i < 40; ++i) edit(id, std::to_string(i), texts);
  EXPECT_EQ(shown().size(), 31u) << "6 vertices a byte, 200 million of a stream";
  EXPECT_NE(log().find("vertices"), std::string::npos);
}

TEST_F(MarkerRegistryTest, ChargesThePeer) {
  PeerLimits limits;
  limits.of(Resource::gpu_bytes) = 50;
  const auto budget = BudgetPool::create(limits)->add_peer("peer");
  const StreamId id = stream(1, budget);
  edit(id, "a", points());
  EXPECT_EQ(shown().size(), 1u);
  EXPECT_EQ(budget->used(Resource::gpu_bytes), 24u) << "12 bytes, and as many to grow without a copy";
  EXPECT_EQ(budget->used(Resource::edits), 1u);
  wire::Marker more = points();
  more.positions.resize(3);
  edit(id, "b", more);
  EXPECT_EQ(shown().size(), 1u);
  EXPECT_TRUE(log().starts_with("warning: the marker \"b\" is not shown: ")) << "over the limit";
  edit(id, "a", wire::Cleared{});
  EXPECT_TRUE(shown().empty());
  EXPECT_EQ(budget->used(Resource::gpu_bytes), 0u);
  EXPECT_EQ(budget->used(Resource::edits), 1u) << "that of b, until it is cleared";
  more.positions.resize(2);
  edit(id, "b", more);
  EXPECT_EQ(shown().size(), 1u);
  poses_.remove_stream(id);
  EXPECT_TRUE(shown().empty());
  EXPECT_EQ(budget->used(Resource::gpu_bytes), 0u);
  EXPECT_EQ(budget->used(Resource::edit_bytes), 0u);
}

TEST_F(MarkerRegistryTest, ChargesImagesAndTexts) {
  PeerLimits limits;
  limits.of(Resource::gpu_bytes) = 10'000'000;
  const auto budget = BudgetPool::create(limits)->add_peer("peer");
  const StreamId id = stream(1, budget);
  wire::Marker image = points();
  image.kind = wire::MarkerKind::images;
  image.sizes = {{1, 1, 0}};
  image.image = {1000, 500, 1, std::vector<uint8_t>(500'000)};
  edit(id, "a", image);
  EXPECT_EQ(shown().size(), 1u);
  EXPECT_EQ(budget->used(Resource::gpu_bytes), 2u * (12 + 12 + 4 * 500'000)) << "4 bytes a pixel";
  EXPECT_GE(budget->used(Resource::edit_bytes), 500'000u);
  EXPECT_LT(budget->used(Resource::edit_bytes), 502'000u);
  edit(id, "a", image);
  edit(id, "b", image);
  image.image = {1000, 1000, 1, std::vector<uint8_t>(1'000'000)};
  edit(id, "c", image);
  EXPECT_EQ(shown().size(), 2u) << "c is over the limit, and harms nobody";
  EXPECT_TRUE(log().starts_with("warning: the marker \"c\" is not shown: "));
  for (const char* name : {"a", "b", "c"}) edit(id, name, wire::Cleared{});
  EXPECT_TRUE(shown().empty());
  const uint64_t empty = budget->used(Resource::edit_bytes);
  wire::Marker texts = points();
  texts.kind = wire::MarkerKind::texts;
  texts.texts = {std::string(1024, 'x')};
  edit(id, "a", texts);
  (void)shown();
  EXPECT_GE(budget->used(Resource::edit_bytes), empty + 1024);
}

}  // namespace
}  // namespace fire3dv::state
