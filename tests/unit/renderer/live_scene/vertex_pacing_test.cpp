// Test of the pace of streamed vertices. No GPU, no clock.
#include "renderer/live_scene/vertex_pacing.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::app {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr size_t kVertices = 10'000;

class VertexPacingTest : public testing::Test {
 protected:
  static wire::SceneEdit edit(uint64_t version, const std::string& node = "cloth",
                              size_t vertices = kVertices) {
    wire::Vertices value;
    value.positions.resize(vertices);
    return {7, version, node, wire::Property::vertices, std::move(value)};
  }
  static state::SceneChanges change(std::vector<wire::SceneEdit> edits, uint64_t age = 1) {
    state::SceneChanges made{3, 7, age, false, std::move(edits)};
    made.charges.resize(made.edits.size());
    return made;
  }
  // Versions that are applied at a time when these edits come.
  std::vector<uint64_t> applied(std::vector<wire::SceneEdit> edits, int64_t now_ns,
                                bool others_active = true) {
    std::vector<state::SceneChanges> changes;
    changes.push_back(change(std::move(edits)));
    waiting_ = pacing_.hold(changes[0], others_active, now_ns);
    for (state::SceneChanges& due : pacing_.take_due(others_active, now_ns))
      changes.push_back(std::move(due));
    std::vector<uint64_t> versions;
    for (const state::SceneChanges& each : changes) {
      pacing_.applied(each, now_ns);
      for (const wire::SceneEdit& one : each.edits) versions.push_back(one.version);
    }
    return versions;
  }
  using Versions = std::vector<uint64_t>;

  VertexPacing pacing_;
  std::vector<uint64_t> waiting_;
};

TEST_F(VertexPacingTest, NewestUpdateWins) {
  EXPECT_EQ(applied({edit(1)}, 0), Versions{1}) << "the first one makes the node's own vertices";
  for (uint64_t version = 2; version < 10; ++version) {
    EXPECT_EQ(applied({edit(version)}, 0), Versions{});
    EXPECT_EQ(waiting_, Versions{version}) << "no frame waits for it";
  }
  EXPECT_EQ(pacing_.skipped(), 7u);
  EXPECT_TRUE(pacing_.take_notice(1));
  EXPECT_FALSE(pacing_.take_notice(1)) << "once";
  EXPECT_EQ(applied({}, 1000 * kMs), Versions{9});
  EXPECT_EQ(applied({}, 2000 * kMs), Versions{});
}

TEST_F(VertexPacingTest, LoneStreamLosesNothing) {
  for (uint64_t version = 1; version < 20; ++version)
    EXPECT_EQ(applied({edit(version)}, 0, false), Versions{version});
  EXPECT_EQ(pacing_.skipped(), 0u);
}

TEST_F(VertexPacingTest, TimeShareFollowsMeasurement) {
  ASSERT_EQ(applied({edit(1)}, 0), Versions{1});
  pacing_.frame_recorded(5);
  pacing_.frame_finished(4, 1000);  // of an earlier frame
  pacing_.frame_finished(5, 100);
  // 100 ms an update: a quarter of the time is one in 400 ms.
  ASSERT_EQ(applied({edit(2)}, 1000 * kMs), Versions{2});
  EXPECT_EQ(applied({edit(3)}, 1390 * kMs), Versions{});
  EXPECT_EQ(applied({}, 1410 * kMs), Versions{3});
  // Twice the vertices take twice as long.
  ASSERT_EQ(applied({edit(4, "cloth", 2 * kVertices)}, 3000 * kMs), Versions{4});
  EXPECT_EQ(applied({edit(5)}, 3790 * kMs), Versions{});
  EXPECT_EQ(applied({}, 3810 * kMs), Versions{5});
}

TEST_F(VertexPacingTest, OtherEditsPass) {
  ASSERT_EQ(applied({edit(1), edit(2, "flag")}, 0), (Versions{1, 2})) << "one update of several nodes";
  wire::SceneEdit visible{7, 4, "cloth", wire::Property::visible, wire::Visible{false}};
  EXPECT_EQ(applied({edit(3), visible, edit(5, "new")}, 0), (Versions{4, 5}));
  wire::SceneEdit cleared{7, 6, "cloth", wire::Property::vertices, wire::Cleared{}};
  EXPECT_EQ(applied({cleared}, 0), Versions{6});
  EXPECT_EQ(applied({}, 5000 * kMs), Versions{}) << "the cleared update does not come back";
}

TEST_F(VertexPacingTest, EndedStreamHoldsNothing) {
  ASSERT_EQ(applied({edit(1)}, 0), Versions{1});
  ASSERT_EQ(applied({edit(2)}, 0), Versions{});
  state::SceneChanges end{3, 7, 1, true, {}};
  pacing_.hold(end, true, 0);
  EXPECT_TRUE(pacing_.take_due(true, 5000 * kMs).empty());
}

}  // namespace
}  // namespace fire3dv::app
