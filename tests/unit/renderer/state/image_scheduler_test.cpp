// Test of fair scheduling of requested images, on a simulated device and clock.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <span>

#include "renderer/state/image_scheduler.h"

namespace fire3dv::state {
namespace {

constexpr int64_t kUsNs = 1'000, kMsNs = 1'000'000, kSecondNs = 1'000'000'000;
constexpr int64_t kSliceNs = 50 * kMsNs;

// Peer that requests its next images a while after the last ones are done.
struct Peer {
  uint64_t image_cost = 1;
  int64_t image_ns = kMsNs;
  int64_t pause_ns = 0;
  uint64_t images = 1;  // requested together
  int64_t next_ns = 0;
  uint64_t due = 0;
  uint64_t made = 0;
};

// Device that draws one submission at a time, driven by ImageScheduler as in ImageService.
class Device {
 public:
  explicit Device(bool is_waiting_allowed = true) : turns_(kSliceNs, is_waiting_allowed) {}

  std::map<uint64_t, Peer> peers;
  std::vector<uint64_t> order;

  void run(int64_t span_ns) {
    const int64_t end_ns = now_ns_ + span_ns;
    while (now_ns_ < end_ns) {
      const std::vector<ImageDemand> demands = demands_now();
      turns_.note_demands(demands, now_ns_);
      const auto requester = turns_.next(demands, now_ns_);
      if (!requester) {
        now_ns_ += 100 * kUsNs;
        continue;
      }
      Peer& peer = peers.at(*requester);
      const int64_t slice_end_ns = now_ns_ + kSliceNs;
      do {
        turns_.submitted(*requester, peer.image_cost, 1, now_ns_);
        turns_.finished(now_ns_, now_ns_ + peer.image_ns);
        now_ns_ += peer.image_ns;
        order.push_back(*requester);
        ++peer.made;
        --peer.due;
      } while (peer.due > 0 && now_ns_ < slice_end_ns);
      if (peer.due == 0) peer.next_ns = now_ns_ + peer.pause_ns;
    }
  }
  uint64_t made_within(uint64_t requester, int64_t span_ns) {
    const uint64_t before = peers.at(requester).made;
    run(span_ns);
    return peers.at(requester).made - before;
  }

 private:
  std::vector<ImageDemand> demands_now() {
    std::vector<ImageDemand> demands;
    for (auto& [requester, peer] : peers) {
      if (peer.due == 0 && now_ns_ >= peer.next_ns) peer.due = peer.images;
      if (peer.due > 0) demands.push_back({requester, peer.due * peer.image_cost, peer.image_cost});
    }
    return demands;
  }

  ImageScheduler turns_;
  int64_t now_ns_ = kSecondNs;
};

constexpr Peer kVictim{.image_cost = 100, .image_ns = kMsNs, .pause_ns = kMsNs};
constexpr Peer kGreedy{.image_cost = 100'000, .image_ns = kSecondNs, .images = 16};

TEST(ImageScheduler, PeerKeepsHalfItsRate) {
  Device device;
  device.peers[1] = kVictim;
  const uint64_t alone = device.made_within(1, kSecondNs);
  EXPECT_GT(alone, 400u);
  device.peers[2] = kGreedy;
  EXPECT_GE(device.made_within(1, 2 * kSecondNs), alone) << "before the first huge image is accounted for";
  EXPECT_GE(device.made_within(1, 20 * kSecondNs), 12 * alone);
  EXPECT_GE(device.peers[2].made, 6u) << "the greedy peer has its share";
}

TEST(ImageScheduler, GreedyPeersShareALimit) {
  Device device;
  device.peers[1] = kVictim;
  const uint64_t alone = device.made_within(1, kSecondNs);
  for (uint64_t peer = 2; peer < 6; ++peer) device.peers[peer] = kGreedy;
  EXPECT_GE(device.made_within(1, 60 * kSecondNs), 36 * alone);
  for (uint64_t peer = 2; peer < 6; ++peer) EXPECT_GE(device.peers[peer].made, 3u) << peer;
}

TEST(ImageScheduler, SmallImagesShareASlice) {
  Device device;
  device.peers[1] = kVictim;
  const uint64_t alone = device.made_within(1, kSecondNs);
  device.peers[2] = {.image_cost = 100, .image_ns = kMsNs, .images = 1000};
  EXPECT_GE(device.made_within(1, 20 * kSecondNs), 12 * alone);
  EXPECT_GE(device.peers[2].made, 6'000u);
}

// Turns of others delay the noted end of its pauses.
TEST(ImageScheduler, PeerThatComesLaterKeepsHalfItsRate) {
  Device alone;
  alone.peers[1] = kVictim;
  const uint64_t rate = alone.made_within(1, kSecondNs);
  Device device;
  device.peers[2] = {.image_cost = 100, .image_ns = kMsNs, .images = 1000};
  device.run(kSecondNs);
  device.peers[1] = kVictim;
  EXPECT_GE(device.made_within(1, 20 * kSecondNs), 12 * rate);
  EXPECT_GE(device.peers[2].made, 5'000u);
}

TEST(ImageScheduler, CostsAreScaledToMeasuredTimes) {
  Device device;
  device.peers[1] = {.image_cost = 500, .image_ns = 5 * kMsNs};
  device.peers[2] = {.image_cost = 100, .image_ns = 5 * kMsNs};
  device.run(kSecondNs);
  device.order.clear();
  device.run(2 * kSecondNs);
  const auto of_first = static_cast<size_t>(std::count(device.order.begin(), device.order.end(), 1));
  EXPECT_NEAR(static_cast<double>(of_first), static_cast<double>(device.order.size()) / 2, 10);
}

TEST(ImageScheduler, SubmissionsBesideOthersFitASlice) {
  constexpr uint64_t kUnlimited = std::numeric_limits<uint64_t>::max();
  ImageScheduler turns(kSliceNs);
  const ImageDemand greedy{1, 1'000'000, 1000}, other{2, 10, 10};
  turns.note_demands({&greedy, 1}, 0);
  EXPECT_EQ(turns.max_cost(1, 1000, kSliceNs, 0), kUnlimited) << "it is alone";
  const std::array<ImageDemand, 2> both = {greedy, other};
  turns.note_demands(both, kMsNs);
  EXPECT_LT(turns.max_cost(1, 1000, kSliceNs, kMsNs), kUnlimited) << "nothing is measured yet";
  turns.submitted(1, 1000, 1, kMsNs);
  turns.finished(kMsNs, 2 * kMsNs);
  EXPECT_EQ(turns.max_cost(1, 1000, kSliceNs, 2 * kMsNs), 50'000u) << "50 ms at 1000 a millisecond";
  ImageScheduler lockstep(kSliceNs, false);
  lockstep.note_demands(both, 0);
  EXPECT_EQ(lockstep.max_cost(1, 1000, kSliceNs, 0), kUnlimited);
}

// The first image of a requester may take long, such as by compiling its pipelines; it says little about
// others.
TEST(ImageScheduler, SlowFirstImageDoesNotBlockLargerOnes) {
  ImageScheduler turns(kSliceNs);
  const std::array<ImageDemand, 2> both = {ImageDemand{1, 20'000, 20'000},
                                           ImageDemand{2, 1'000'000, 1'000'000}};
  turns.note_demands(both, 0);
  turns.submitted(1, 20'000, 1, 0);
  turns.finished(0, kMsNs);
  turns.submitted(2, 16'500, 1, kMsNs);
  turns.finished(kMsNs, 300 * kMsNs);
  EXPECT_GT(turns.max_cost(2, 1'000'000, kSecondNs, 300 * kMsNs), 2'000'000u) << "as fast as those of others";
  EXPECT_LT(turns.max_cost(2, 16'500, kSliceNs, 300 * kMsNs), 16'500u);
}

// Pipelines are compiled in the first submissions: that says nothing about later ones, and keeps nobody
// waiting.
TEST(ImageScheduler, CompilationIsNoMeasure) {
  ImageScheduler turns(kSliceNs);
  const std::array<ImageDemand, 2> both = {ImageDemand{1, 20'000, 20'000}, ImageDemand{2, 20'000, 20'000}};
  turns.note_demands(both, 0);
  ASSERT_EQ(turns.next(both, 0), 1u);
  turns.submitted(1, 20'000, 1, 0);
  turns.finished(0, 2 * kSecondNs, true);
  turns.note_demands(both, 2 * kSecondNs);
  EXPECT_EQ(turns.next(std::span(both).first(1), 2 * kSecondNs), 1u)
      << "it waits as if its images took seconds";
  turns.submitted(1, 20'000, 1, 2 * kSecondNs);
  turns.finished(2 * kSecondNs, 2 * kSecondNs + kMsNs);
  EXPECT_EQ(turns.max_cost(1, 20'000, kSliceNs, 2 * kSecondNs + kMsNs), 1'000'000u);
}

// Copies of a requester's images delay others as its images do.
TEST(ImageScheduler, HostTimeCounts) {
  ImageScheduler turns(kSliceNs);
  const std::array<ImageDemand, 2> both = {ImageDemand{1, 1000, 1000}, ImageDemand{2, 1000, 1000}};
  int64_t now_ns = 0;
  for (int i = 0; i < 8; ++i, now_ns += kMsNs) {
    turns.note_demands(both, now_ns);
    const auto requester = turns.next(both, now_ns);
    ASSERT_TRUE(requester);
    turns.submitted(*requester, 1000, 1, now_ns);
    turns.finished(now_ns, now_ns + kMsNs);
  }
  turns.spent(2, now_ns, now_ns + 20 * kMsNs);
  now_ns += 20 * kMsNs;
  for (int i = 0; i < 10; ++i, now_ns += kMsNs) {
    turns.note_demands(both, now_ns);
    ASSERT_EQ(turns.next(both, now_ns), 1u) << i;
    turns.submitted(1, 1000, 1, now_ns);
    turns.finished(now_ns, now_ns + kMsNs);
  }
}

TEST(ImageCost, GrowsWithWhatIsDrawn) {
  const uint64_t plain = image_cost(100, 100);
  EXPECT_EQ(plain, 26'384u);
  EXPECT_GT(image_cost(100, 100, {.outputs = 4}), plain);
  EXPECT_GT(image_cost(100, 100, {.is_distorted = true}), plain);
  EXPECT_GT(image_cost(100, 100, {.is_blurred = true}), plain);
  EXPECT_GT(image_cost(100, 100, {.has_markers = true}), plain);
  EXPECT_GT(image_cost(100, 100, {.path_samples = 64}), 32 * 10'000u);
}

TEST(ImageScheduler, EqualPeersDoNotWait) {
  Device device;
  for (uint64_t peer = 1; peer <= 4; ++peer)
    device.peers[peer] = {.image_cost = 100, .image_ns = kMsNs, .pause_ns = 30 * kMsNs};
  device.run(kSecondNs);
  for (uint64_t peer = 1; peer <= 4; ++peer) EXPECT_GE(device.made_within(peer, kSecondNs), 28u) << peer;
}

TEST(ImageScheduler, RarePeersCostNothing) {
  Device device;
  device.peers[1] = {.image_cost = 100, .image_ns = kMsNs, .pause_ns = 99 * kMsNs};
  device.peers[2] = {.image_cost = 2000, .image_ns = 20 * kMsNs};
  device.run(kSecondNs);
  EXPECT_GE(device.made_within(2, 10 * kSecondNs), 450u) << "of 500 without the other peer";
  EXPECT_GE(device.peers[1].made, 90u);
}

TEST(ImageScheduler, PausedPeerHasNoCredit) {
  Device device;
  device.peers[1] = {.image_cost = 100, .image_ns = 10 * kMsNs};
  device.run(10 * kSecondNs);
  device.peers[2] = device.peers[1];
  device.order.clear();
  device.run(2 * kSecondNs);
  const auto of_first = static_cast<size_t>(std::count(device.order.begin(), device.order.end(), 1));
  EXPECT_NEAR(static_cast<double>(of_first), static_cast<double>(device.order.size()) / 2, 10);
}

TEST(ImageScheduler, LonePeerNeverWaits) {
  Device device;
  device.peers[2] = kGreedy;
  EXPECT_EQ(device.made_within(2, 16 * kSecondNs), 16u);
  Device lockstep(false);
  lockstep.peers[1] = kVictim;
  lockstep.run(kSecondNs);
  lockstep.peers[2] = kGreedy;
  lockstep.order.clear();
  lockstep.run(kSecondNs / 2);
  ASSERT_FALSE(lockstep.order.empty());
  EXPECT_LE(std::find(lockstep.order.begin(), lockstep.order.end(), 2) - lockstep.order.begin(), 2);
}

TEST(ImageScheduler, EstimatesTheTimeInFlight) {
  ImageScheduler turns(kSliceNs);
  const ImageDemand demand{1, 1000, 1000};
  turns.note_demands({&demand, 1}, 0);
  EXPECT_EQ(turns.next({&demand, 1}, 0), 1u);
  EXPECT_EQ(turns.remaining_ns(0), 0);
  turns.submitted(1, 1000, 1, 0);
  EXPECT_EQ(turns.remaining_ns(0), std::nullopt) << "nothing is measured yet";
  turns.finished(0, 5 * kMsNs);
  turns.submitted(1, 2000, 1, 5 * kMsNs);
  EXPECT_EQ(turns.remaining_ns(5 * kMsNs), 10 * kMsNs);
  EXPECT_EQ(turns.remaining_ns(9 * kMsNs), 6 * kMsNs);
  EXPECT_GT(turns.remaining_ns(30 * kMsNs), 20 * kMsNs) << "late: it may take as long again";
  EXPECT_EQ(turns.in_flight(), 1u);
}

}  // namespace
}  // namespace fire3dv::state
