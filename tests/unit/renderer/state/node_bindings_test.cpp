// Test of name binding between streams and scene nodes: matching, conflicts, order of age, and transforms.
#include <gtest/gtest.h>

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/model/math.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::state {
namespace {

using Names = std::vector<std::string>;

glm::mat4 moved(float x, float y, float z) {
  return glm::translate(glm::mat4(1), glm::vec3(x, y, z));
}
glm::vec3 origin_of(const PoseState& state, uint32_t node) {
  return glm::vec3(state.world_from_node(node)[3]);
}

// Node i rests one metre along X from its parent.
scene::Scene make_scene(const std::vector<std::pair<std::string, uint32_t>>& name_and_parent) {
  scene::Scene scene;
  for (const auto& [name, parent] : name_and_parent) {
    scene::Node node;
    node.name = name;
    node.parent = parent;
    node.parent_from_node = moved(1, 0, 0);
    node.world_from_node = node.parent_from_node;
    node.path = name;
    if (parent != scene::kNone) {
      node.world_from_node = scene.nodes[parent].world_from_node * node.parent_from_node;
      node.path = scene.nodes[parent].path + "/" + name;
    }
    scene.nodes.push_back(std::move(node));
  }
  return scene;
}

wire::StreamDescription stream_of(const Names& names, uint64_t epoch = 7) {
  wire::StreamDescription description;
  description.adapter_name = "adapter " + std::to_string(epoch);
  description.epoch = epoch;
  description.node_names = names;
  return description;
}

Names names(const PoseState& state, StreamId id, IndexSet Stream::*set) {
  return state.names_at(id, state.streams()[id].*set, 4096);
}

bool push_whole(PoseState& state, StreamId id, uint64_t sequence, const std::vector<glm::mat4>& matrices) {
  std::vector<wire::Affine3x4> poses;
  for (const glm::mat4& matrix : matrices) poses.push_back(scene::to_affine(matrix));
  wire::PoseFrameView frame;
  frame.header.epoch = state.streams()[id].epoch;
  frame.header.sequence = sequence;
  frame.node_count = static_cast<uint32_t>(poses.size());
  frame.poses = poses;
  return state.push(id, frame);
}

TEST(SceneMath, ConversionsKeepRowsAndColumns) {
  wire::Affine3x4 affine;
  for (size_t i = 0; i < 12; ++i) affine.m[i] = static_cast<float>(i);
  const glm::mat4 matrix = scene::to_mat4(affine);
  EXPECT_EQ(matrix[3], glm::vec4(3, 7, 11, 1));
  EXPECT_EQ(scene::to_affine(matrix), affine);
}

TEST(PoseBinding, UniqueNameThenPath) {
  const scene::Scene scene = make_scene({{"left", scene::kNone},
                                         {"finger", 0},
                                         {"right", scene::kNone},
                                         {"finger", 2},
                                         {"left/finger", scene::kNone}});
  PoseState state(scene);
  const StreamId id =
      state.add_stream(stream_of({"right/finger", "right", "finger", "nobody", "", "left/finger"}));
  const Stream& stream = state.streams()[id];
  EXPECT_EQ(names(state, id, &Stream::unmatched_names), (Names{"finger", "nobody", ""}))
      << "two nodes are called finger";
  EXPECT_TRUE(stream.conflicting_names.empty());
  // "left/finger" is the path of node 1 and the name of node 4: the exact name has priority.
  EXPECT_EQ(stream.scene_node_of_pose, (std::vector<uint32_t>{3, 2, kNone, kNone, kNone, 4}));
}

TEST(PoseBinding, DuplicatePathsBindNothing) {
  const scene::Scene scene = make_scene({{"arm", scene::kNone}, {"bolt", 0}, {"bolt", 0}});
  PoseState state(scene);
  const StreamId id = state.add_stream(stream_of({"arm/bolt"}));
  EXPECT_EQ(names(state, id, &Stream::unmatched_names), Names{"arm/bolt"});
}

TEST(PoseBinding, DuplicateNamesConflict) {
  const scene::Scene scene = make_scene({{"arm", scene::kNone}, {"hand", 0}});
  PoseState state(scene);
  const StreamId id = state.add_stream(stream_of({"hand", "arm/hand"}));
  EXPECT_EQ(names(state, id, &Stream::conflicting_names), Names{"arm/hand"});
  push_whole(state, id, 1, {moved(0, 5, 0), moved(0, 9, 0)});
  EXPECT_EQ(origin_of(state, 1), glm::vec3(0, 5, 0));
}

TEST(PoseBinding, NodesRestUntilFrame) {
  const scene::Scene scene = make_scene({{"arm", scene::kNone}, {"hand", 0}});
  PoseState state(scene);
  const StreamId id = state.add_stream(stream_of({"arm"}));
  EXPECT_EQ(state.node_drives()[0].stream, kNone);
  EXPECT_EQ(origin_of(state, 1), glm::vec3(2, 0, 0));
  const uint64_t before = state.drive_revision();
  EXPECT_TRUE(push_whole(state, id, 1, {moved(0, 5, 0)}));
  EXPECT_GT(state.drive_revision(), before);
  EXPECT_EQ(origin_of(state, 0), glm::vec3(0, 5, 0));
  EXPECT_EQ(origin_of(state, 1), glm::vec3(1, 5, 0)) << "a child without a driver follows";
  const uint64_t after = state.drive_revision();
  EXPECT_TRUE(push_whole(state, id, 2, {moved(0, 6, 0)}));
  EXPECT_EQ(state.drive_revision(), after) << "poses changed, bindings did not";
}

TEST(PoseBinding, DrivenChildIsAbsolute) {
  const scene::Scene scene =
      make_scene({{"arm", scene::kNone}, {"elbow", 0}, {"hand", 1}, {"finger", 2}, {"base", scene::kNone}});
  PoseState state(scene);
  const StreamId id = state.add_stream(stream_of({"hand", "arm"}));
  push_whole(state, id, 1, {moved(0, 0, 9), moved(0, 5, 0)});
  EXPECT_EQ(origin_of(state, 0), glm::vec3(0, 5, 0));
  EXPECT_EQ(origin_of(state, 1), glm::vec3(1, 5, 0));
  EXPECT_EQ(origin_of(state, 2), glm::vec3(0, 0, 9));
  EXPECT_EQ(origin_of(state, 3), glm::vec3(1, 0, 9));
  EXPECT_EQ(origin_of(state, 4), glm::vec3(1, 0, 0));
  EXPECT_EQ(state.node_drives()[3].pose_index, 0u);
  EXPECT_EQ(state.node_drives()[1].pose_index, 1u);
  EXPECT_EQ(state.node_drives()[4].stream, kNone);
}

TEST(PoseBinding, StreamAndBodyTransformsApply) {
  const scene::Scene scene = make_scene({{"arm", scene::kNone}, {"hand", 0}, {"base", scene::kNone}});
  // The stream is Z up, in centimetres.
  wire::StreamDescription description = stream_of({"base", "arm"});
  description.world_from_stream.m = {0.01, 0, 0, 0, 0, 0, 0.01, 0, 0, -0.01, 0, 0};
  description.body_from_node = {wire::Affine3x4{},
                                scene::to_affine(moved(0, 0, 100) * glm::scale(glm::mat4(1), glm::vec3(2)))};
  PoseState state(scene);
  const StreamId id = state.add_stream(description);
  push_whole(state, id, 1, {moved(300, 0, 0), moved(0, 200, 0)});
  EXPECT_NEAR(glm::distance(origin_of(state, 0), glm::vec3(0, 1, -2)), 0, 1e-6);
  EXPECT_NEAR(glm::distance(origin_of(state, 1), glm::vec3(0.02, 1, -2)), 0, 1e-6)
      << "the offset scales what rests below the body";
  EXPECT_NEAR(glm::distance(origin_of(state, 2), glm::vec3(3, 0, 0)), 0, 1e-6);
}

TEST(PoseBinding, OneBodyServesAll) {
  const scene::Scene scene = make_scene({{"a", scene::kNone}, {"b", scene::kNone}});
  wire::StreamDescription description = stream_of({"a", "b"});
  description.body_from_node = {scene::to_affine(moved(0, 1, 0))};
  PoseState state(scene);
  push_whole(state, state.add_stream(description), 1, {moved(0, 0, 1), moved(0, 0, 2)});
  EXPECT_EQ(origin_of(state, 0), glm::vec3(0, 1, 1));
  EXPECT_EQ(origin_of(state, 1), glm::vec3(0, 1, 2));
}

TEST(PoseBinding, OlderStreamKeepsNode) {
  const scene::Scene scene = make_scene({{"a", scene::kNone}, {"b", scene::kNone}, {"c", scene::kNone}});
  PoseState state(scene);
  const StreamId first = state.add_stream(stream_of({"a", "b"}, 1));
  const StreamId second = state.add_stream(stream_of({"b", "c"}, 2));
  EXPECT_TRUE(state.streams()[first].conflicting_names.empty());
  EXPECT_EQ(names(state, second, &Stream::conflicting_names), Names{"b"});
  EXPECT_EQ(names(state, first, &Stream::contested_names), Names{"b"});
  EXPECT_TRUE(state.streams()[second].contested_names.empty());
  EXPECT_EQ(state.streams()[second].scene_node_of_pose, (std::vector<uint32_t>{kNone, 2}));
  push_whole(state, first, 1, {moved(0, 1, 0), moved(0, 2, 0)});
  push_whole(state, second, 1, {moved(0, 0, 3), moved(0, 0, 4)});
  EXPECT_EQ(origin_of(state, 1), glm::vec3(0, 2, 0));
  EXPECT_EQ(state.shown().size(), 2u);

  const uint64_t before = state.drive_revision();
  state.remove_stream(first);
  EXPECT_GT(state.drive_revision(), before);
  EXPECT_EQ(origin_of(state, 0), glm::vec3(1, 0, 0)) << "at rest again";
  EXPECT_EQ(origin_of(state, 1), glm::vec3(0, 0, 3)) << "the next stream that wanted it";
  EXPECT_TRUE(state.streams()[second].conflicting_names.empty());
  ASSERT_EQ(state.shown().size(), 1u);
  EXPECT_EQ(state.shown()[0].stream, "adapter 2");
}

TEST(PoseBinding, ContestedNodeIsNamedOnce) {
  const scene::Scene scene = make_scene({{"arm", scene::kNone}, {"hand", 0}});
  PoseState state(scene);
  const StreamId first = state.add_stream(stream_of({"arm/hand", "hand"}, 1));
  EXPECT_TRUE(state.streams()[first].contested_names.empty()) << "two names of one stream are its own affair";
  state.add_stream(stream_of({"hand"}, 2));
  const StreamId last = state.add_stream(stream_of({"hand"}, 3));
  EXPECT_EQ(names(state, first, &Stream::contested_names), Names{"arm/hand"});
  state.remove_stream(last);
  EXPECT_EQ(names(state, first, &Stream::contested_names), Names{"arm/hand"});
}

TEST(PoseBinding, ReusedSlotIsYoungest) {
  const scene::Scene scene = make_scene({{"a", scene::kNone}});
  PoseState state(scene);
  const StreamId first = state.add_stream(stream_of({"a"}, 1));
  const StreamId second = state.add_stream(stream_of({"a"}, 2));
  push_whole(state, first, 3, {moved(0, 1, 0)});
  const uint64_t revision = state.streams()[first].revision;
  state.remove_stream(first);
  EXPECT_FALSE(state.streams()[first].active);
  const StreamId third = state.add_stream(stream_of({"a"}, 3));
  EXPECT_EQ(third, first);
  EXPECT_GT(state.streams()[third].revision, revision) << "whoever cached the old poses must notice";
  EXPECT_EQ(state.streams()[third].header.sequence, 0u);
  EXPECT_EQ(names(state, third, &Stream::conflicting_names), Names{"a"});
  EXPECT_TRUE(state.streams()[second].conflicting_names.empty());
}

TEST(PoseBinding, NamesCostTheirStream) {
  const scene::Scene scene = make_scene({{"a", scene::kNone}});
  PoseState state(scene);
  Names unmatched;
  for (int i = 0; i < 100'000; ++i) unmatched.push_back("nobody " + std::to_string(i));
  const StreamId large = state.add_stream(stream_of(unmatched, 1));
  const uint64_t before = state.name_lookups();
  EXPECT_EQ(before, unmatched.size());
  uint64_t place = 0;
  for (uint64_t epoch = 2; epoch < 202; ++epoch) {
    const StreamId id = state.add_stream(stream_of({"a"}, epoch), nullptr, place);
    if (epoch % 2 == 0)
      place = state.suspend_stream(id, 5);
    else
      state.remove_stream(id);
  }
  EXPECT_LE(state.name_lookups() - before, 1000u);
  EXPECT_EQ(state.streams()[large].unmatched_names.size(), unmatched.size());
  EXPECT_EQ(state.names_at(large, state.streams()[large].unmatched_names, 100).size(), 6u)
      << "a list is bounded";
}

TEST(PoseBinding, ReturningStreamFindsNodes) {
  const scene::Scene scene = make_scene({{"a", scene::kNone}, {"b", scene::kNone}});
  PoseState state(scene);
  StreamId first = state.add_stream(stream_of({"a", "b"}, 1));
  const StreamId waiting = state.add_stream(stream_of({"a", "b"}, 2));
  push_whole(state, first, 1, {moved(0, 1, 0), moved(0, 2, 0)});
  const uint64_t conflicts = state.streams()[waiting].conflicting_names.revision();
  const uint64_t place = state.suspend_stream(first, 5);
  EXPECT_FALSE(state.streams()[first].active);
  EXPECT_EQ(origin_of(state, 0), glm::vec3(1, 0, 0)) << "at rest";
  state.advance(4);
  EXPECT_EQ(state.streams()[waiting].conflicting_names.revision(), conflicts) << "both nodes are reserved";

  first = state.add_stream(stream_of({"a"}, 3), nullptr, place);
  EXPECT_EQ(state.streams()[first].scene_node_of_pose, std::vector<uint32_t>{0});
  EXPECT_EQ(names(state, first, &Stream::contested_names), Names{"a"});
  EXPECT_EQ(names(state, waiting, &Stream::conflicting_names), Names{"a"}) << "b is not asked for any more";
  EXPECT_LT(*state.age_of_driver(0), *state.age_of_driver(1)) << "and it is the older one still";

  EXPECT_NE(state.suspend_stream(first, 10), place);
  state.advance(9);
  EXPECT_EQ(names(state, waiting, &Stream::conflicting_names), Names{"a"});
  state.advance(10);
  EXPECT_TRUE(state.streams()[waiting].conflicting_names.empty()) << "nobody came";
  const StreamId late = state.add_stream(stream_of({"a"}, 4), nullptr, place);
  EXPECT_EQ(names(state, late, &Stream::conflicting_names), Names{"a"});
}

TEST(PoseBinding, OldestReservationsStay) {
  const scene::Scene scene = make_scene({{"a", scene::kNone}});
  PoseState state(scene);
  const uint64_t oldest = state.suspend_stream(state.add_stream(stream_of({"a"}, 1)), 5);
  for (uint64_t epoch = 2; epoch < 1000; ++epoch)
    state.suspend_stream(state.add_stream(stream_of({"a"}, epoch)), 5);
  EXPECT_LE(state.streams().size(), PoseState::kMaxReservations + 2);
  const StreamId back = state.add_stream(stream_of({"a"}, 1), nullptr, oldest);
  EXPECT_EQ(state.streams()[back].scene_node_of_pose, std::vector<uint32_t>{0});
}

// Added nodes follow the file's own.
TEST(PoseBinding, AddedNodeKeepsNames) {
  const scene::Scene file = make_scene({{"arm", scene::kNone}, {"hand", 0}});
  const scene::Scene tool = make_scene({{"arm", scene::kNone}, {"hand", 0}, {"tool", 1}, {"tip", 2}});
  const scene::Scene more = make_scene({{"arm", scene::kNone},
                                        {"hand", 0},
                                        {"other", scene::kNone},
                                        {"tip", 2},
                                        {"tool", 1},
                                        {"tip", 4},
                                        {"hand", scene::kNone},
                                        {"arm/hand", scene::kNone},
                                        {"hand", 0}});
  PoseState state(file);
  state.set_scene(tool);
  const StreamId id = state.add_stream(stream_of({"arm/hand", "tip", "tool"}, 1));
  EXPECT_EQ(state.streams()[id].scene_node_of_pose, (std::vector<uint32_t>{1, 3, 2}));
  state.set_scene(more);  // adds another tip before the first one, and three nodes with the hand's name
  EXPECT_EQ(state.streams()[id].scene_node_of_pose, (std::vector<uint32_t>{1, 5, 4}));
  const StreamId next = state.add_stream(stream_of({"hand", "tip"}, 2));
  EXPECT_EQ(names(state, next, &Stream::conflicting_names), Names{"hand"}) << "the file's";
  EXPECT_EQ(names(state, next, &Stream::unmatched_names), Names{"tip"}) << "there are two";
  state.set_scene(tool);
  EXPECT_EQ(state.streams()[id].scene_node_of_pose, (std::vector<uint32_t>{1, 3, 2}));
  state.set_scene(file);
  EXPECT_EQ(names(state, id, &Stream::unmatched_names), (Names{"tip", "tool"}));
}

TEST(PoseBinding, NextVersionKeepsBindings) {
  const scene::Scene before = make_scene({{"arm", scene::kNone}, {"hand", 0}, {"old", scene::kNone}});
  // Other order, another parent of the hand, and a node that was missing.
  const scene::Scene after = make_scene(
      {{"lamp", scene::kNone}, {"arm", scene::kNone}, {"wrist", 1}, {"hand", 2}, {"late", scene::kNone}});
  PoseState state(before);
  const StreamId id = state.add_stream(stream_of({"arm", "hand", "old", "late"}, 1));
  EXPECT_EQ(names(state, id, &Stream::unmatched_names), Names{"late"});
  state.set_scene(after, 5);
  EXPECT_EQ(state.streams()[id].scene_node_of_pose, (std::vector<uint32_t>{1, 3, kNone, 4}));
  EXPECT_EQ(names(state, id, &Stream::unmatched_names), Names{"old"});
  // All nodes are the file's now: an added node takes no name away.
  const scene::Scene added = make_scene({{"lamp", scene::kNone},
                                         {"arm", scene::kNone},
                                         {"wrist", 1},
                                         {"hand", 2},
                                         {"late", scene::kNone},
                                         {"late", 1}});
  state.set_scene(added);
  const StreamId next = state.add_stream(stream_of({"late"}, 2));
  EXPECT_EQ(names(state, next, &Stream::conflicting_names), Names{"late"})
      << "the file's, which the first has";
  state.set_scene(before, 3);
  EXPECT_EQ(state.streams()[id].scene_node_of_pose, (std::vector<uint32_t>{0, 1, 2, kNone}));
}

TEST(PoseBinding, SceneChangeCostsItsChanges) {
  const scene::Scene file = make_scene({{"arm", scene::kNone}});
  const scene::Scene tool = make_scene({{"arm", scene::kNone}, {"tool 7", 0}});
  PoseState state(file);
  Names wanted;
  for (int i = 0; i < 100'000; ++i) wanted.push_back("tool " + std::to_string(i));
  const StreamId id = state.add_stream(stream_of(wanted, 1));
  const uint64_t before = state.name_lookups();
  state.set_scene(tool);
  EXPECT_EQ(state.streams()[id].scene_node_of_pose[7], 1u);
  EXPECT_EQ(state.streams()[id].unmatched_names.size(), wanted.size() - 1);
  state.set_scene(file);
  EXPECT_EQ(state.streams()[id].scene_node_of_pose[7], kNone);
  EXPECT_EQ(state.streams()[id].unmatched_names.size(), wanted.size());
  EXPECT_LE(state.name_lookups() - before, 20u);
}

// Names of 16 bytes with one common value of libstdc++'s string hash, whose seed is fixed.
Names colliding_names(size_t count) {
  constexpr uint64_t kFactor = 0xc6a4a7935bd1e995u;
  uint64_t inverse = kFactor;  // modulo 2^64, by Newton's method
  for (int i = 0; i < 6; ++i) inverse *= 2 - kFactor * inverse;
  const auto mix = [](uint64_t v) { return v ^ (v >> 47); };
  const uint64_t begin = 0xc70f6907u ^ (16 * kFactor);
  Names names;
  for (uint64_t first = 1; first <= count; ++first) {
    const uint64_t hash = (begin ^ (mix(first * kFactor) * kFactor)) * kFactor;
    const uint64_t second = mix(hash * inverse) * inverse;  // its mix equals `hash`: both cancel to 0
    std::string name(16, 0);
    std::memcpy(name.data(), &first, 8);
    std::memcpy(name.data() + 8, &second, 8);
    names.push_back(std::move(name));
  }
  return names;
}

TEST(PoseBinding, ChosenNamesSpreadOverBuckets) {
  const Names names = colliding_names(4096);
#ifdef __GLIBCXX__
  for (const std::string& name : names)
    ASSERT_EQ(std::hash<std::string_view>()(name), std::hash<std::string_view>()(names[0]));
#endif
  scene::Scene scene;
  for (const std::string& name : names) scene.nodes.emplace_back().name = name;
  EXPECT_LE(NodeNames(scene).longest_bucket(), 16u);
}

TEST(PoseBinding, UnknownStreamsAreNoFault) {
  const scene::Scene scene = make_scene({{"a", scene::kNone}});
  PoseState state(scene);
  state.remove_stream(5);
  const StreamId id = state.add_stream(stream_of({"a"}));
  state.remove_stream(id);
  state.remove_stream(id);
  EXPECT_FALSE(push_whole(state, id, 1, {moved(0, 1, 0)}));
  EXPECT_FALSE(state.push(99, {}));
}

}  // namespace
}  // namespace fire3dv::state
