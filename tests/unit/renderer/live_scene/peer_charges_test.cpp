// Test of replacement shares: pauses of peers whose changes replaced the scene. No GPU, no clock.
#include "renderer/live_scene/peer_charges.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace fire3dv::app {
namespace {

class ReplacementSharesTest : public testing::Test {
 protected:
  const std::shared_ptr<BudgetPool> pool_ = BudgetPool::create();
  const std::shared_ptr<PeerBudget> greedy_ = pool_->add_peer("greedy"), honest_ = pool_->add_peer("honest");
  ReplacementShares shares_;
};

TEST_F(ReplacementSharesTest, GreedyPeerIsLimitedToQuarter) {
  const std::vector honest{ReplacementShares::Cause{honest_, 0, 1}};
  const std::vector greedy{ReplacementShares::Cause{greedy_, 200, 1}};
  shares_.add({honest, 0, 10, 1000, false});
  EXPECT_EQ(shares_.earliest_ns(honest_), 1030);
  shares_.add({greedy, 50, 400, 2000, false});
  EXPECT_EQ(shares_.earliest_ns(greedy_), 2000 + 3 * 400 + 50 + 200);
  EXPECT_EQ(shares_.earliest_ns(honest_), 1030) << "it has not caused this";
}

TEST_F(ReplacementSharesTest, LonePeerTakesHalf) {
  const std::vector causes{ReplacementShares::Cause{greedy_, 200, 1}};
  shares_.add({causes, 50, 400, 2000, true});
  EXPECT_EQ(shares_.earliest_ns(greedy_), 2400);
}

TEST_F(ReplacementSharesTest, LargerLoadRestsLonger) {
  constexpr int64_t kLoadNs = 98'000'000, kShownNs = 50'000'000;
  const std::vector causes{ReplacementShares::Cause{greedy_, kLoadNs, 0},
                           ReplacementShares::Cause{honest_, 0, 0}};
  shares_.add({causes, 0, kShownNs, 0, false});
  EXPECT_NEAR(static_cast<double>(shares_.earliest_ns(honest_)), 3.0 * kShownNs / 100, 10);
  EXPECT_NEAR(static_cast<double>(shares_.earliest_ns(greedy_)), 3.0 * kShownNs * 99 / 100 + kLoadNs, 10);
}

// Else whoever connects again would not rest at all.
TEST_F(ReplacementSharesTest, NewPeerWaitsForLastReplacement) {
  EXPECT_EQ(shares_.earliest_ns(honest_), 0);
  const std::vector causes{ReplacementShares::Cause{greedy_, 0, 1}};
  shares_.add({causes, 0, 400, 2000, false});
  EXPECT_EQ(shares_.earliest_ns(honest_), 2400);
  shares_.add({causes, 0, 10, 2100, false});
  EXPECT_EQ(shares_.earliest_ns(honest_), 2400);
}

TEST_F(ReplacementSharesTest, RestGrowsWithoutCalm) {
  const std::vector causes{ReplacementShares::Cause{greedy_, 0, 1}};
  constexpr int64_t kShownNs = 10'000'000;
  const auto rest_after = [&](int64_t now_ns) {
    shares_.add({causes, 0, kShownNs, now_ns, false});
    return shares_.earliest_ns(greedy_) - now_ns;
  };
  int64_t now_ns = 10 * ReplacementShares::kCalmNs, rest_ns = 0;
  for (int i = 0; i < 200; ++i) {
    rest_ns = rest_after(now_ns);
    EXPECT_GE(rest_ns, 3 * kShownNs) << i;
    now_ns += rest_ns;
  }
  EXPECT_EQ(rest_ns, ReplacementShares::kMaxGrowth * 3 * kShownNs);
  EXPECT_EQ(rest_after(now_ns + 2 * ReplacementShares::kCalmNs), 3 * kShownNs) << "after some calm";
}

// Streams that have ended, or have no budget, share one rest.
TEST_F(ReplacementSharesTest, UnbudgetedPeerRestsToo) {
  const std::vector causes{ReplacementShares::Cause{nullptr, 0, 1}};
  shares_.add({causes, 0, 400, 2000, false});
  EXPECT_EQ(shares_.earliest_ns(nullptr), 3200);
}

}  // namespace
}  // namespace fire3dv::app
