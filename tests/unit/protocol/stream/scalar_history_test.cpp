// Test of the history of scalars: rings by simulation time, statistics, limits and charges.
#include "protocol/stream/scalar_history.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fire3dv::stream {
namespace {

using Outcome = ScalarHistory::Outcome;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

wire::SceneEdit declaration(uint64_t version, const std::string& group, size_t count = 2) {
  wire::Scalars scalars;
  for (size_t i = 0; i < count; ++i) {
    scalars.names.push_back("s" + std::to_string(i));
    scalars.units.push_back(i == 0 ? "rad" : "");
  }
  return {7, version, group, wire::Property::scalars, scalars};
}

wire::SceneEdit values(uint64_t declared, const std::string& group, int64_t sim_time_ns,
                       std::vector<double> numbers) {
  return {7, 99, group, wire::Property::scalar_values,
          wire::ScalarValues{declared, sim_time_ns, std::move(numbers)}};
}

TEST(ScalarHistory, KeepsSamplesAndStatistics) {
  ScalarHistory history;
  EXPECT_EQ(history.apply(values(1, "arm", 0, {1, 2})), Outcome::unmatched);
  ASSERT_EQ(history.apply(declaration(1, "arm")), Outcome::accepted);
  EXPECT_EQ(history.apply(values(1, "arm", 10, {3, kNan})), Outcome::accepted);
  EXPECT_EQ(history.apply(values(1, "arm", 20, {-5, 7})), Outcome::accepted);
  EXPECT_EQ(history.apply(values(1, "arm", 30, {INFINITY, 8})), Outcome::accepted);
  EXPECT_EQ(history.apply(values(1, "arm", 40, {1, 2, 3})), Outcome::unmatched);
  EXPECT_EQ(history.apply(values(2, "arm", 40, {1, 2})), Outcome::unmatched) << "of another declaration";
  const ScalarGroup& arm = history.groups().at("arm");
  ASSERT_EQ(arm.size(), 3u);
  EXPECT_EQ(arm.sim_time_ns(0), 10);
  EXPECT_EQ(arm.value(1, 0), -5);
  EXPECT_TRUE(std::isnan(arm.value(0, 1)));
  EXPECT_EQ(arm.find(5), 0u);
  EXPECT_EQ(arm.find(20), 1u);
  EXPECT_EQ(arm.find(21), 2u);
  EXPECT_EQ(arm.find(31), 3u);
  const ScalarStatistics& first = arm.statistics()[0];
  EXPECT_EQ(first.count, 2u) << "infinity does not count";
  EXPECT_EQ(first.min, -5);
  EXPECT_EQ(first.max, 3);
  EXPECT_EQ(first.last, -5);
  EXPECT_EQ(arm.statistics()[1].min, 7);

  // The same declaration again keeps the history, under its new version.
  ASSERT_EQ(history.apply(declaration(5, "arm")), Outcome::accepted);
  EXPECT_EQ(history.apply(values(5, "arm", 30, {4, 4})), Outcome::accepted);
  ASSERT_EQ(arm.size(), 3u) << "values of the same time replace the sample";
  EXPECT_EQ(arm.value(2, 0), 4);
  // Another one does not.
  ASSERT_EQ(history.apply(declaration(6, "arm", 3)), Outcome::accepted);
  EXPECT_EQ(history.groups().at("arm").size(), 0u);
  EXPECT_EQ(history.apply({7, 8, "arm", wire::Property::scalars, wire::Cleared{}}), Outcome::accepted);
  EXPECT_TRUE(history.groups().empty());
}

TEST(ScalarHistory, TimeReversalClears) {
  ScalarHistory history;
  history.apply(declaration(1, "a", 1));
  history.apply(declaration(2, "b", 1));
  for (int64_t t = 0; t < 100; ++t) history.apply(values(1, "a", t, {1.0 * static_cast<double>(t)}));
  history.apply(values(2, "b", 99, {1}));
  history.apply(values(1, "a", 98, {5}));
  const ScalarGroup& a = history.groups().at("a");
  ASSERT_EQ(a.size(), 1u);
  EXPECT_EQ(a.sim_time_ns(0), 98);
  EXPECT_EQ(a.statistics()[0].count, 1u);
  EXPECT_EQ(a.statistics()[0].max, 5);
  EXPECT_EQ(history.groups().at("b").size(), 1u);
}

TEST(ScalarHistory, KeepsTheNewestSamples) {
  ScalarHistory history;
  history.apply(declaration(1, "a", 1));
  constexpr int64_t kCount = 3 * ScalarHistory::kMaxSamples + 17;
  for (int64_t t = 0; t < kCount; ++t) history.apply(values(1, "a", t, {2.0 * static_cast<double>(t)}));
  const ScalarGroup& a = history.groups().at("a");
  ASSERT_EQ(a.size(), ScalarHistory::kMaxSamples);
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a.sim_time_ns(i), kCount - static_cast<int64_t>(a.size() - i));
    ASSERT_EQ(a.value(i, 0), 2.0 * static_cast<double>(a.sim_time_ns(i)));
  }
  EXPECT_EQ(a.statistics()[0].min, 0) << "statistics are of the whole history";
  EXPECT_EQ(a.statistics()[0].count, static_cast<uint64_t>(kCount));
}

TEST(ScalarHistory, IsBoundedAndCharged) {
  const auto pool = BudgetPool::create();
  const auto peer = pool->add_peer("peer");
  {
    ScalarHistory history(peer);
    ASSERT_EQ(history.apply(declaration(1, "wide", wire::kMaxScalars)), Outcome::accepted);
    EXPECT_EQ(history.apply(declaration(2, "more", 1)), Outcome::refused);
    EXPECT_NE(history.refusal().find("4096 scalars"), std::string::npos) << history.refusal();
    for (int64_t t = 0; t < 3000; ++t)
      history.apply(values(1, "wide", t, std::vector<double>(wire::kMaxScalars, 1)));
    const ScalarGroup& wide = history.groups().at("wide");
    EXPECT_GT(wide.size(), 300u);
    EXPECT_LT(wide.size() * wire::kMaxScalars * 8, ScalarHistory::kMaxSampleBytes);
    EXPECT_EQ(wide.sim_time_ns(wide.size() - 1), 2999);
    EXPECT_GT(peer->used(Resource::edit_bytes), wide.size() * wire::kMaxScalars * 8);
    EXPECT_LT(peer->used(Resource::edit_bytes), 2 * ScalarHistory::kMaxSampleBytes);
    EXPECT_LE(peer->refused(Resource::edit_bytes), 1u);
    history.apply({7, 8, "wide", wire::Property::scalars, wire::Cleared{}});
    EXPECT_EQ(peer->used(Resource::edit_bytes), 0u);
    EXPECT_EQ(history.apply(declaration(9, "more", 1)), Outcome::accepted);
  }
  EXPECT_EQ(peer->used(Resource::edit_bytes), 0u);

  PeerLimits limits;
  limits.of(Resource::edit_bytes) = 2000;
  ScalarHistory poor(BudgetPool::create(limits)->add_peer("poor"));
  EXPECT_EQ(poor.apply(declaration(1, "a", 100)), Outcome::refused);
  EXPECT_NE(poor.refusal().find("edit-bytes"), std::string::npos) << poor.refusal();
  EXPECT_EQ(poor.apply(declaration(2, "b", 1)), Outcome::accepted);
  EXPECT_EQ(poor.apply(values(2, "b", 0, {1})), Outcome::accepted);
}

TEST(ScalarHistory, StatisticsAreOptional) {
  ScalarHistory history(nullptr, ScalarHistory::Keep::statistics);
  history.apply(declaration(1, "a", 1));
  for (int64_t t = 0; t < 100; ++t)
    ASSERT_EQ(history.apply(values(1, "a", t, {static_cast<double>(t)})), Outcome::accepted);
  EXPECT_EQ(history.groups().at("a").size(), 0u);
  EXPECT_EQ(history.groups().at("a").statistics()[0].count, 100u);
  ASSERT_EQ(history.apply(values(1, "a", 3, {-1})), Outcome::accepted);
  EXPECT_EQ(history.groups().at("a").statistics()[0].count, 1u);
}

}  // namespace
}  // namespace fire3dv::stream
