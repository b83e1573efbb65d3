// Test of budgets per peer: limits, reserved and shared amounts, lifetime of charges, option texts, and the
// table of the specification.
#include "base/peer_budget.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

namespace fire3dv {
namespace {

constexpr Resource kNodes = Resource::nodes, kBytes = Resource::edit_bytes;

PeerLimits small_limits() {
  PeerLimits limits;
  limits.per_peer[static_cast<size_t>(kNodes)] = 100;
  limits.reserved[static_cast<size_t>(kNodes)] = 10;
  limits.shared[static_cast<size_t>(kNodes)] = 120;
  return limits;
}

TEST(PeerBudget, RefusalNamesLimitAndOption) {
  const auto pool = BudgetPool::create(small_limits());
  const auto peer = pool->add_peer("a");
  ASSERT_TRUE(peer->take(kNodes, 60));
  const Result<void> refused = peer->take(kNodes, 41);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "added nodes would use 101; the limit of one peer is 100 (the renderer's option --peer-limit "
            "nodes=VALUE changes it)");
  EXPECT_EQ(peer->used(kNodes), 60u);
  EXPECT_EQ(peer->refused(kNodes), 1u);
  EXPECT_TRUE(peer->take(kNodes, 40));
  peer->give_back(kNodes, 100);
  EXPECT_EQ(pool->used(kNodes), 0u);
}

TEST(PeerBudget, HugeAmountsDoNotWrap) {
  const auto pool = BudgetPool::create(small_limits());
  const auto peer = pool->add_peer("a");
  ASSERT_TRUE(peer->take(kNodes, 100));
  EXPECT_FALSE(peer->take(kNodes, UINT64_MAX));
  EXPECT_FALSE(peer->take(kNodes, UINT64_MAX - 50));
  EXPECT_EQ(peer->used(kNodes), 100u);
}

TEST(PeerBudget, ReservationIsGuaranteed) {
  const auto pool = BudgetPool::create(small_limits());
  const auto a = pool->add_peer("a"), b = pool->add_peer("b"), c = pool->add_peer("c");
  ASSERT_TRUE(a->take(kNodes, 100));      // 90 of the shared amount
  ASSERT_FALSE(b->try_take(kNodes, 41));  // 31 more of it; 30 are left
  ASSERT_TRUE(b->take(kNodes, 40));
  EXPECT_TRUE(c->take(kNodes, 10));
  const Result<void> refused = c->take(kNodes, 1);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("shared-nodes"), std::string::npos) << refused.error().message;
  a->give_back(kNodes, 95);
  EXPECT_TRUE(c->take(kNodes, 90));
}

TEST(PeerBudget, GoneWithItsPeer) {
  const auto pool = BudgetPool::create(small_limits());
  {
    const auto peer = pool->add_peer("a");
    ASSERT_TRUE(peer->take(kNodes, 100));
    ASSERT_EQ(pool->report().size(), 1u);
  }
  EXPECT_EQ(pool->used(kNodes), 0u);
  EXPECT_TRUE(pool->report().empty());
  const auto again = pool->add_peer("b");
  EXPECT_TRUE(again->take(kNodes, 100));
}

TEST(BudgetCharge, AmountMovesAndResizes) {
  const auto pool = BudgetPool::create(small_limits());
  const auto peer = pool->add_peer("a");
  {
    Result<BudgetCharge> charge = BudgetCharge::take(peer, kNodes, 30);
    ASSERT_TRUE(charge);
    BudgetCharge moved = std::move(*charge);
    EXPECT_EQ(peer->used(kNodes), 30u);
    EXPECT_TRUE(moved.resize(80));
    EXPECT_FALSE(moved.resize(101));
    EXPECT_EQ(moved.amount(), 80u);
    EXPECT_TRUE(moved.resize(5));
    EXPECT_EQ(peer->used(kNodes), 5u);
    BudgetCharge other = std::move(*BudgetCharge::take(peer, kNodes, 7));
    moved = std::move(other);
    EXPECT_EQ(peer->used(kNodes), 7u);
  }
  EXPECT_EQ(peer->used(kNodes), 0u);
}

TEST(BudgetCharge, OutlivesThePeersConnection) {
  const auto pool = BudgetPool::create(small_limits());
  auto peer = pool->add_peer("a");
  BudgetCharge charge = std::move(*BudgetCharge::take(peer, kNodes, 30));
  peer.reset();
  EXPECT_EQ(pool->used(kNodes), 30u);
  charge.release();
  EXPECT_EQ(pool->used(kNodes), 0u);
}

TEST(BudgetCharge, WithoutABudgetChargesNobody) {
  const Result<BudgetCharge> charge = BudgetCharge::take(nullptr, kNodes, UINT64_MAX);
  EXPECT_TRUE(charge);
}

TEST(PeerBudget, ThreadsAgreeOnTheSum) {
  const auto pool = BudgetPool::create();
  const auto peer = pool->add_peer("a");
  const auto work = [&] {
    for (int i = 0; i < 2'000; ++i) {
      Result<BudgetCharge> charge = BudgetCharge::take(peer, kBytes, 1'000);
      if (charge && i % 3 == 0) (void)charge->resize(10);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(peer->used(kBytes), 0u);
  EXPECT_EQ(pool->used(kBytes), 0u);
}

TEST(PeerLimits, AreSetByName) {
  PeerLimits limits;
  EXPECT_TRUE(set_limit("edit-bytes=3MiB", limits));
  EXPECT_EQ(limits.of(kBytes), uint64_t{3} << 20);
  EXPECT_EQ(limits.reserved[static_cast<size_t>(kBytes)], uint64_t{3} << 20);  // not above the limit
  EXPECT_TRUE(set_limit("shared-edit-bytes=2GiB", limits));
  EXPECT_EQ(limits.shared[static_cast<size_t>(kBytes)], uint64_t{2} << 30);
  EXPECT_TRUE(set_limit("nodes=0", limits));
  EXPECT_EQ(limits.of(kNodes), 0u);
  EXPECT_TRUE(set_limit("receive-ms=7", limits));
  EXPECT_EQ(limits.slices.receive_ns, 7'000'000);
}

TEST(PeerLimits, RefuseWhatMeansNothing) {
  PeerLimits limits;
  for (const char* text : {"", "nodes", "nodes=", "nodes=-1", "nodes=4KiB", "edit-bytes=4kb",
                           "edit-bytes=1.5MiB", "edit-bytes=99999999999GiB", "knots=4", "shared-=4",
                           "shared-image-ms=4", "image-ms=0", "receive-ms=60001", "=4"}) {
    const Result<void> set = set_limit(text, limits);
    ASSERT_FALSE(set) << text;
    EXPECT_FALSE(set.error().message.empty()) << text;
  }
}

// The table of SPEC.md, section 14, equals the defaults in the code.
TEST(PeerLimits, SpecificationListsTheDefaults) {
  std::ifstream file(FIRE3DV_SOURCE_DIR "/protocol/SPEC.md");
  std::stringstream text;
  text << file.rdbuf();
  const auto number = [](const ResourceInfo& row, uint64_t value) {
    if (row.is_bytes && value >= uint64_t{1} << 30) return std::to_string(value >> 30) + " GiB";
    if (row.is_bytes) return std::to_string(value >> 20) + " MiB";
    std::string digits = std::to_string(value);
    for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
      digits.insert(static_cast<size_t>(at), ",");
    return digits;
  };
  for (const ResourceInfo& row : resource_table()) {
    const std::string end = " | " + number(row, row.per_peer) + " | " + number(row, row.reserved) + " | " +
                            number(row, row.shared) + " |\n";
    const size_t begin = text.str().find("| `" + std::string(row.name) + "` |");
    ASSERT_NE(begin, std::string::npos) << row.name;
    const std::string line = text.str().substr(begin, text.str().find('\n', begin) + 1 - begin);
    EXPECT_TRUE(line.ends_with(end)) << line << " should end with" << end;
  }
}

}  // namespace
}  // namespace fire3dv
