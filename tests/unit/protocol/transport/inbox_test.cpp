// Test of the inbox of network listeners: budgets per peer, order, bounded cost, limited notes.
#include "protocol/transport/core/inbox.h"

#include <algorithm>
#include <new>

#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {
namespace {

struct Inboxed {
  explicit Inboxed(const PeerLimits& limits = {}) : pool(BudgetPool::create(limits)) {}
  std::shared_ptr<BudgetPool> pool;
  LinkCounters counters;
  Inbox inbox{counters, "test://"};
  std::vector<Event> events;

  void connect(PeerId peer) { inbox.connected(peer, pool->add_peer(std::to_string(peer))); }
  void poll() {
    events.clear();
    inbox.poll([this](const LinkEvent& event) {
      const bool has_message = event.kind == Kind::pose || event.kind == Kind::control;
      events.push_back(
          {event.kind, event.peer, has_message ? text_of(event.message) : std::string(event.text)});
    });
  }
  size_t count(Kind kind) const {
    return static_cast<size_t>(
        std::count_if(events.begin(), events.end(), [&](const Event& event) { return event.kind == kind; }));
  }
};

std::vector<std::byte> message(size_t bytes) {
  return std::vector<std::byte>(bytes);
}
std::vector<std::byte> message(const std::string& text) {
  return {bytes_of(text).begin(), bytes_of(text).end()};
}

PeerLimits small_limits() {
  PeerLimits limits;
  const auto i = static_cast<size_t>(Resource::received_bytes);
  limits.per_peer[i] = 1 << 20;
  limits.reserved[i] = 256 << 10;
  limits.shared[i] = 1 << 20;
  return limits;
}

TEST(Inbox, PeersDoNotStealMessages) {
  Inboxed all(small_limits());
  for (PeerId peer = 1; peer <= 4; ++peer) all.connect(peer);
  for (PeerId peer = 1; peer <= 3; ++peer)
    for (int i = 0; i < 100; ++i) (void)all.inbox.state(peer, message(20'000));
  EXPECT_GT(all.pool->used(Resource::received_bytes), uint64_t{1} << 20);
  EXPECT_EQ(all.inbox.control(3, message(20'000)), Cause::no_memory);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(all.inbox.control(4, message(20'000)));
  all.inbox.pose(4, message("pose"), true);
  all.poll();
  EXPECT_TRUE(std::any_of(all.events.begin(), all.events.end(),
                          [](const Event& event) { return event.peer == 4 && event.text == "pose"; }));
  EXPECT_FALSE(all.inbox.control(3, message(20'000))) << "what was polled is given back";
}

TEST(Inbox, ChargesEndWithTheirPeer) {
  Inboxed all;
  all.connect(1);
  (void)all.inbox.control(1, message(1 << 20));
  EXPECT_GE(all.pool->used(Resource::received_bytes), uint64_t{1} << 20);
  all.poll();
  EXPECT_LE(all.pool->used(Resource::received_bytes), uint64_t{64} << 10);
  all.inbox.pose(1, message(100), true);
  all.inbox.disconnected(1, "end");
  EXPECT_NE(all.inbox.budget(1), nullptr) << "until the end was polled";
  all.poll();
  EXPECT_EQ(all.inbox.budget(1), nullptr);
  EXPECT_EQ(all.pool->used(Resource::received_bytes), 0u);
  EXPECT_EQ(all.inbox.entries(), 0u);
}

TEST(Inbox, DiscardedMessagesAreRefunded) {
  Inboxed all;
  for (PeerId peer = 1; peer <= 3; ++peer) {
    all.connect(peer);
    (void)all.inbox.control(peer, message(1 << 20));
  }
  EXPECT_THROW(all.inbox.poll([](const LinkEvent&) { throw std::bad_alloc(); }), std::bad_alloc);
  EXPECT_LE(all.pool->used(Resource::received_bytes), uint64_t{3 * 64} << 10);
}

TEST(Inbox, PoseAndControlOrderIsKept) {
  Inboxed all;
  all.connect(1);
  all.inbox.pose_part(1, message("9"), 9, true);
  (void)all.inbox.control(1, message("a"));
  all.inbox.pose_part(1, message("8"), 8, true);
  (void)all.inbox.state(1, message("b"));
  all.inbox.pose_part(1, message("9b"), 9, true);
  all.inbox.disconnected(1, "end");
  all.poll();
  std::string order;
  for (const Event& event : all.events) order += event.text + " ";
  EXPECT_EQ(order, " 9 a 8 b 9b end ");
}

TEST(Inbox, PausedPeerKeepsMessages) {
  Inboxed all;
  all.connect(1);
  all.connect(2);
  all.poll();
  all.inbox.pause(1, true);
  for (int i = 0; i < 300; ++i) (void)all.inbox.state(1, message("state"));
  (void)all.inbox.control(2, message("other"));
  all.poll();
  EXPECT_EQ(all.events.size(), 1u) << "of the other peer";
  EXPECT_TRUE(all.inbox.is_full_of_states(1)) << "the listener stops reading";
  all.inbox.pause(1, false);
  all.poll();
  EXPECT_EQ(all.events.size(), 300u);
  EXPECT_FALSE(all.inbox.is_full_of_states(1));
}

// Parts of incomplete frames, and control messages, wait. Whole small frames arrive meanwhile.
uint64_t examined_for(uint64_t waiting, uint64_t frames) {
  Inboxed all;
  all.connect(1);
  for (uint64_t i = 0; i < waiting; ++i) {
    all.inbox.pose_part(1, message("part"), UINT64_MAX, false);
    (void)all.inbox.state(1, message("state"));
  }
  const uint64_t before = all.inbox.examined_messages();
  for (uint64_t frame = 1; frame <= frames; ++frame) {
    all.inbox.drop_parts_before(1, frame);
    all.inbox.pose_part(1, message("whole"), frame, true);
  }
  return all.inbox.examined_messages() - before;
}

TEST(Inbox, DroppedPartsAreRefunded) {
  EXPECT_EQ(examined_for(100, 200), 199u);
  EXPECT_EQ(examined_for(400, 200), 199u) << "does not grow with the messages that wait";
  EXPECT_EQ(examined_for(100, 800), 799u);
}

TEST(Inbox, FloodedNotesKeepOtherCauses) {
  Inboxed all;
  for (int i = 0; i < 80; ++i) {
    const std::string text = "bad " + std::to_string(i);
    all.inbox.note(Cause::malformed, text, text);
  }
  all.inbox.note(Cause::version, "other version", "other version");
  all.poll();
  EXPECT_EQ(all.count(Kind::note), NoteLimiter::kMaxNotesPerWindow + 1);
  EXPECT_EQ(all.events.back().text, "test://: other version");
}

TEST(NoteLimiter, NotesPerCauseAreLimited) {
  NoteLimiter limiter;
  std::vector<std::string> summaries;
  const auto allow = [&](int i, int64_t at_s) {
    return limiter.allow(Cause::malformed, "note " + std::to_string(i), at_s * kSecondNs);
  };
  size_t shown = 0;
  for (int i = 0; i < 80; ++i) shown += allow(i, 100);
  EXPECT_EQ(shown, NoteLimiter::kMaxNotesPerWindow);
  EXPECT_TRUE(limiter.allow(Cause::version, "other cause", 100 * kSecondNs));
  limiter.take_summaries(105 * kSecondNs, summaries);
  EXPECT_TRUE(summaries.empty()) << "the window is not over";
  limiter.take_summaries(110 * kSecondNs, summaries);
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0], "and 72 more were refused (malformed) in the last 10 s");
  EXPECT_FALSE(limiter.has_suppressed());
  EXPECT_TRUE(allow(1000, 111)) << "a later note of the same cause";
}

TEST(NoteLimiter, EqualNotesCountOnce) {
  NoteLimiter limiter;
  std::vector<std::string> summaries;
  size_t shown = 0;
  for (int64_t second = 0; second < 60; ++second) {  // without a pause of 10 s
    shown += limiter.allow(Cause::silent, "no greeting", (100 + second) * kSecondNs);
    limiter.take_summaries((100 + second) * kSecondNs, summaries);
  }
  EXPECT_EQ(shown, 1u);
  EXPECT_GE(summaries.size(), 4u);
  EXPECT_LE(summaries.size(), 6u);
  EXPECT_TRUE(limiter.allow(Cause::silent, "no greeting", 400 * kSecondNs));
}

}  // namespace
}  // namespace fire3dv::transport::test
