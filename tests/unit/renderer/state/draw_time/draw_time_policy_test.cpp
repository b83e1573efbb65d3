// Test of the drawing time of peers: shares, hiding, return, and who is never hidden. Time is simulated.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "renderer/state/draw_time/draw_time_policy.h"

namespace fire3dv::state {
namespace {

constexpr int64_t kMsNs = 1'000'000, kSecondNs = 1'000'000'000;
using Policy = DrawTimePolicy;
using NoticeKind = Policy::Notice::Kind;

// Renderer that draws 64 x 64 images, with content whose true cost differs from the estimate.
class DrawTime : public testing::Test {
 protected:
  struct Source {
    double markers_ms = 0, meshes_ms = 0;  // true cost of an image
    double estimate = 1;                   // estimated by true cost
  };

  DrawTime() { connect({&honest_, &greedy_}); }

  void connect(std::vector<Policy::Peer> peers) {
    peers_ = std::move(peers);
    policy_.set_peers(peers_);
  }
  static DrawWork work_of(double ms) { return {.fragments = ms * 1e6 / 5}; }  // of a software device
  Policy::Image image(Policy::Peer requester) const {
    Policy::Image image{.kind = 1, .pixels = 64 * 64, .requester = requester};
    for (const auto& [peer, source] : sources_)
      image.content.push_back(
          {peer, work_of(source.markers_ms * source.estimate), work_of(source.meshes_ms * source.estimate)});
    return image;
  }
  // Returns the time of the image in milliseconds.
  double draw(Policy::Peer requester) {
    Policy::Image drawn = image(requester);
    policy_.plan(drawn, now_ns_);
    std::erase_if(drawn.content, [&](const auto& content) { return policy_.is_hidden(content.peer); });
    double markers_ms = 0, total_ms = base_ms_;
    for (const auto& [peer, source] : sources_) {
      if (policy_.is_hidden(peer)) continue;
      markers_ms += source.markers_ms;
      total_ms += source.markers_ms + source.meshes_ms;
    }
    now_ns_ += static_cast<int64_t>(total_ms * 1e6);
    policy_.add(drawn, {static_cast<int64_t>(total_ms * 1e6), static_cast<int64_t>(markers_ms * 1e6)},
                now_ns_);
    now_ns_ += kMsNs;
    for (const Policy::Notice& notice : policy_.take_notices()) notices_.push_back(notice);
    longest_ms_ = std::max(longest_ms_, total_ms);
    return total_ms;
  }
  void draw_for(int64_t span_ns, Policy::Peer requester) {
    for (const int64_t end_ns = now_ns_ + span_ns; now_ns_ < end_ns;) draw(requester);
  }
  size_t count(NoticeKind kind) const {
    return static_cast<size_t>(std::ranges::count(notices_, kind, &Policy::Notice::kind));
  }
  Policy::Report report(Policy::Peer peer) const {
    for (const Policy::Report& report : policy_.report())
      if (report.peer == peer) return report;
    return {};
  }

  const std::shared_ptr<BudgetPool> pool_ = BudgetPool::create();
  const std::shared_ptr<PeerBudget> honest_budget_ = pool_->add_peer("honest"),
                                    greedy_budget_ = pool_->add_peer("greedy");
  const PeerBudget& honest_ = *honest_budget_;
  const PeerBudget& greedy_ = *greedy_budget_;
  Policy policy_{{.factor = 2, .is_software = true}};
  std::vector<Policy::Peer> peers_;
  std::map<Policy::Peer, Source> sources_;
  std::vector<Policy::Notice> notices_;
  double base_ms_ = 2, longest_ms_ = 0;
  int64_t now_ns_ = kSecondNs;
};

TEST_F(DrawTime, SharesFollowTheMeasuredTime) {
  base_ms_ = 20;
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 5};
  sources_[&honest_] = {.markers_ms = 2, .meshes_ms = 3};
  draw_for(20 * kSecondNs, &honest_);
  EXPECT_NEAR(report(&greedy_).share, 5.0 / 30, 0.02);
  EXPECT_NEAR(report(&honest_).share, 5.0 / 30, 0.02);
  EXPECT_NEAR(report(&greedy_).seconds, 20 * 5.0 / 31, 0.2);
  EXPECT_TRUE(notices_.empty());
}

// An estimate is never exact: the measured time of meshes is what an image takes beyond one without them.
TEST_F(DrawTime, WrongEstimatesAreScaled) {
  base_ms_ = 20;
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.meshes_ms = 8, .estimate = 0.2};
  draw_for(20 * kSecondNs, &honest_);
  EXPECT_NEAR(report(&greedy_).share, 8.0 / 28, 0.03);
}

TEST_F(DrawTime, ExpensiveContentIsHiddenAfterSomeImages) {
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 12};
  draw_for(2 * kSecondNs, &honest_);
  EXPECT_TRUE(policy_.is_hidden(&greedy_));
  EXPECT_FALSE(policy_.is_hidden(&honest_));
  EXPECT_EQ(count(NoticeKind::hidden), 1u);
  const auto hidden = std::ranges::find(notices_, NoticeKind::hidden, &Policy::Notice::kind);
  EXPECT_EQ(hidden->peer, &greedy_);
  EXPECT_NE(hidden->text.find("86 % of drawing time, 12 ms of an image of 14 ms"), std::string::npos)
      << hidden->text;
  EXPECT_NE(hidden->text.find("--peer-limit draw-time=off"), std::string::npos) << hidden->text;
  EXPECT_EQ(draw(&honest_), base_ms_);
}

// Content that would take seconds is not drawn once to find that out.
TEST_F(DrawTime, ContentFarBeyondTheBudgetIsHiddenUndrawn) {
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 5'000, .estimate = 0.3};
  draw_for(2 * kSecondNs, &honest_);
  EXPECT_TRUE(policy_.is_hidden(&greedy_));
  EXPECT_EQ(longest_ms_, base_ms_);
}

TEST_F(DrawTime, SlowestOfSeveralIsHiddenFirst) {
  const auto third_budget = pool_->add_peer("third");
  connect({&honest_, &greedy_, third_budget.get()});
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 12};
  sources_[third_budget.get()] = {.markers_ms = 1};
  draw_for(2 * kSecondNs, &honest_);
  EXPECT_TRUE(policy_.is_hidden(&greedy_));
  EXPECT_FALSE(policy_.is_hidden(third_budget.get()));
}

// Many peers that take a little each are no way around the budget.
TEST_F(DrawTime, CostsOfPeersAddUp) {
  std::vector<std::shared_ptr<PeerBudget>> budgets;
  std::vector<Policy::Peer> peers{&honest_};
  for (int i = 0; i < 16; ++i) {
    budgets.push_back(pool_->add_peer("small"));
    peers.push_back(budgets.back().get());
    sources_[peers.back()] = {.markers_ms = 1.2};
  }
  connect(peers);
  draw_for(4 * kSecondNs, &honest_);
  EXPECT_LE(draw(&honest_), 2 * base_ms_ + 0.01);
  EXPECT_GE(draw(&honest_), base_ms_ + 1);
}

TEST_F(DrawTime, OwnContentOfARequesterDoesNotCount) {
  sources_[&greedy_] = {.markers_ms = 40, .meshes_ms = 40};
  draw_for(5 * kSecondNs, &greedy_);
  EXPECT_FALSE(policy_.is_hidden(&greedy_));
}

TEST_F(DrawTime, OnePeerAloneLosesNothing) {
  connect({&greedy_});
  sources_[&greedy_] = {.markers_ms = 400};
  draw_for(10 * kSecondNs, nullptr);
  EXPECT_FALSE(policy_.is_active());
  EXPECT_FALSE(policy_.hides_any());
  EXPECT_EQ(report(&greedy_).share, 0);
  EXPECT_TRUE(notices_.empty());
}

TEST_F(DrawTime, ContentReturnsWhenTheOthersHaveLeft) {
  sources_[&greedy_] = {.markers_ms = 400};
  draw_for(kSecondNs, &honest_);
  ASSERT_TRUE(policy_.is_hidden(&greedy_));
  const Policy::Peer rest = &greedy_;
  EXPECT_TRUE(policy_.set_peers({&rest, 1}));
  EXPECT_FALSE(policy_.is_hidden(&greedy_));
}

TEST_F(DrawTime, ContentReturnsWhenItHasShrunk) {
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 100};
  draw_for(10 * kSecondNs, &honest_);
  ASSERT_TRUE(policy_.is_hidden(&greedy_));
  sources_[&greedy_] = {.markers_ms = 0.2};
  draw_for(3 * kSecondNs, &honest_);
  EXPECT_FALSE(policy_.is_hidden(&greedy_));
  EXPECT_EQ(count(NoticeKind::shown), 1u);
}

TEST_F(DrawTime, ContentThatIsGoneIsNotHidden) {
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 100};
  draw_for(kSecondNs, &honest_);
  ASSERT_TRUE(policy_.is_hidden(&greedy_));
  sources_.clear();
  draw_for(6 * kSecondNs, &honest_);
  EXPECT_FALSE(policy_.is_hidden(&greedy_));
}

// Content that is small for a moment and large again, as often as it likes.
TEST_F(DrawTime, ToggledContentReturnsMoreAndMoreSeldom) {
  draw_for(kSecondNs, &honest_);
  for (int i = 0; i < 100; ++i) {
    sources_[&greedy_] = {.markers_ms = policy_.is_hidden(&greedy_) ? 0.2 : 100};
    draw_for(kSecondNs, &honest_);
  }
  EXPECT_LE(count(NoticeKind::hidden), 7u);
  EXPECT_GE(count(NoticeKind::hidden), 4u);
}

TEST_F(DrawTime, WrongMeasurementDoesNotHideForGood) {
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 12};
  draw_for(kSecondNs, &honest_);
  ASSERT_TRUE(policy_.is_hidden(&greedy_));
  sources_[&greedy_] = {.markers_ms = 0.5, .estimate = 10};  // estimated at 5 ms
  draw_for(60 * kSecondNs, &honest_);
  EXPECT_FALSE(policy_.is_hidden(&greedy_));
}

TEST_F(DrawTime, CheapImagesHaveAFloor) {
  base_ms_ = 0.1;
  sources_[&greedy_] = {.markers_ms = 0.7};
  draw_for(5 * kSecondNs, &honest_);
  EXPECT_FALSE(policy_.is_hidden(&greedy_));
}

TEST_F(DrawTime, OffMeasuresAndHidesNothing) {
  policy_ = Policy({.factor = 0, .is_software = true});
  connect({&honest_, &greedy_});
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 100};
  draw_for(10 * kSecondNs, &honest_);
  EXPECT_FALSE(policy_.is_hidden(&greedy_));
  EXPECT_GT(report(&greedy_).share, 0.9);
  EXPECT_EQ(count(NoticeKind::expensive), 1u);
  EXPECT_EQ(notices_[0].text, "takes 61 % of drawing time: 100 ms of an image of 102 ms");
  EXPECT_FALSE(policy_.abandon_after_ns(image(&honest_)));
}

TEST_F(DrawTime, AbandonedImageHidesTheCostliestContent) {
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.markers_ms = 30};  // is drawn, to be measured
  sources_[&honest_] = {.markers_ms = 1};
  ASSERT_TRUE(policy_.abandon_after_ns(image(&honest_)));
  EXPECT_TRUE(policy_.add_abandoned(image(&honest_), kSecondNs, now_ns_));
  EXPECT_TRUE(policy_.is_hidden(&greedy_));
  EXPECT_FALSE(policy_.abandon_after_ns(image(&honest_)));  // nothing of others is left
}

TEST_F(DrawTime, LargeMeshesAreNotUploadedBesideOthers) {
  EXPECT_FALSE(policy_.refuse_meshes(&greedy_, {.rebuilt = 100'000}, {}, now_ns_));
  EXPECT_TRUE(policy_.refuse_meshes(&greedy_, {.rebuilt = 3'000'000}, {}, now_ns_));
  EXPECT_TRUE(policy_.is_hidden(&greedy_));
  connect({&greedy_});
  EXPECT_FALSE(policy_.refuse_meshes(&greedy_, {.rebuilt = 3'000'000}, {}, now_ns_));
}

TEST_F(DrawTime, ExpensiveMeshesAreNotUploadedBesideOthers) {
  draw_for(kSecondNs, &honest_);
  sources_[&greedy_] = {.meshes_ms = 20};
  std::vector<Policy::Image> images{image(&honest_)};
  EXPECT_FALSE(policy_.refuse_meshes(&greedy_, {}, images, now_ns_));
  sources_[&greedy_] = {.meshes_ms = 500};
  images = {image(&greedy_)};
  EXPECT_FALSE(policy_.refuse_meshes(&greedy_, {}, images, now_ns_)) << "own images do not count";
  images = {image(&honest_)};
  EXPECT_TRUE(policy_.refuse_meshes(&greedy_, {}, images, now_ns_));
  EXPECT_TRUE(policy_.is_hidden(&greedy_));
}

TEST(DrawTimeFactor, IsANumberOrOff) {
  EXPECT_EQ(*parse_draw_time_factor("off"), 0);
  EXPECT_EQ(*parse_draw_time_factor("1.5"), 1.5);
  for (const char* wrong : {"", "0", "-1", "0.5", "2x", "nan", "1e9", "on"})
    EXPECT_FALSE(parse_draw_time_factor(wrong)) << wrong;
}

}  // namespace
}  // namespace fire3dv::state
