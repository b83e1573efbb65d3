// Time slices, order and budgets of the messages of peers.
#include "tests/unit/renderer/streams/receiver_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(StreamReceiverTest, BusyPeerCostsOneSlice) {
  link_->deliver(1, LinkEvent::Kind::control, description(1, "busy", {"nothing"}));
  link_->deliver(2, LinkEvent::Kind::connected);
  receiver_.poll();
  step_ns_ = 1'000'000;  // a slice is two messages
  constexpr uint64_t kEdits = 1000;
  for (uint64_t version = 1; version <= kEdits; ++version)
    link_->deliver(1, LinkEvent::Kind::control, visible(1, version));
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  link_->deliver(2, LinkEvent::Kind::pose, frame(2, 1));
  EXPECT_TRUE(receiver_.poll());
  EXPECT_EQ(poses_.streams()[1].header.sequence, 1u);
  EXPECT_EQ(poses_.streams()[0].edits_received, 2u);
  EXPECT_EQ(receiver_.deferred_messages(), kEdits - 2);
  const auto budget = poses_.take_scene_changes().at(0).budget;
  EXPECT_GT(budget->used(Resource::received_bytes), (kEdits - 2) * visible(1, 1).size());
  const int64_t begin_ns = now_ns_;
  for (uint64_t i = 2; i <= 200; ++i) {
    link_->deliver(2, LinkEvent::Kind::pose, frame(2, i));
    const uint64_t before = poses_.streams()[0].edits_received;
    EXPECT_TRUE(receiver_.poll());
    EXPECT_EQ(poses_.streams()[1].header.sequence, i);
    EXPECT_LE(poses_.streams()[0].edits_received - before, 2u);
  }
  const auto quarter = static_cast<uint64_t>((now_ns_ - begin_ns) / step_ns_ / 4);
  EXPECT_LE(poses_.streams()[0].edits_received, quarter + 2) << "a quarter of the time";
  EXPECT_GE(poses_.streams()[0].edits_received, quarter / 2) << "and not much less";
  step_ns_ = 0;
  now_ns_ += 1'000'000'000;
  receiver_.poll();
  EXPECT_EQ(poses_.streams()[0].edits_received, kEdits) << "in order: none was stale";
  EXPECT_EQ(poses_.streams()[0].edits_stale, 0u);
  EXPECT_EQ(receiver_.deferred_messages(), 0u);
  EXPECT_EQ(budget->used(Resource::received_bytes), 0u);
}

TEST_F(StreamReceiverTest, LinkKeepsDeferredMessages) {
  link_->deliver(1, LinkEvent::Kind::control, description(1, "busy", {"nothing"}));
  link_->deliver(2, LinkEvent::Kind::connected);
  receiver_.poll();
  step_ns_ = 1'000'000;  // a slice is two messages
  for (uint64_t version = 1; version <= 5; ++version)
    link_->deliver(1, LinkEvent::Kind::control, visible(1, version));
  receiver_.poll();
  ASSERT_EQ(receiver_.deferred_messages(), 3u);
  using Pauses = std::vector<std::pair<PeerId, bool>>;
  EXPECT_EQ(link_->pauses, (Pauses{{1, true}}));
  for (int turn = 0; turn < 2; ++turn) {
    now_ns_ += 10'000'000;  // its rest is over
    receiver_.poll();
  }
  ASSERT_EQ(receiver_.deferred_messages(), 0u);
  EXPECT_EQ(link_->pauses, (Pauses{{1, true}, {1, false}}));
}

TEST_F(StreamReceiverTest, NewestWaitingPoseIsHandled) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::connected);
  receiver_.poll();
  step_ns_ = 1'000'000;
  for (uint64_t version = 1; version <= 9; ++version)
    link_->deliver(1, LinkEvent::Kind::control, visible(1, version));
  for (uint64_t i = 1; i <= 100; ++i) link_->deliver(1, LinkEvent::Kind::pose, frame(1, i));
  receiver_.poll();
  EXPECT_EQ(receiver_.deferred_messages(), 8u) << "seven edits and a frame";
  int polls = 1;
  while (!receiver_.poll()) {
    now_ns_ += 10'000'000;  // its rest is over
    ASSERT_LT(++polls, 10);
  }
  EXPECT_EQ(poses_.shown().at(0).sequence, 100u);
  EXPECT_EQ(poses_.streams()[0].frames_received, 1u);
}

TEST_F(StreamReceiverTest, LockstepHandlesAllInOrder) {
  state::PoseState poses(scene_);
  StreamReceiver receiver(poses, true);
  auto listener = std::make_unique<ScriptedListener>();
  ScriptedListener* const link = listener.get();
  receiver.add(std::move(listener));
  receiver.set_clock([this] { return now_ns_ += 10'000'000; });  // five slices a message
  link->deliver(2, LinkEvent::Kind::control, description(2, "second", {"nothing"}));
  link->deliver(1, LinkEvent::Kind::control, description(1));
  for (uint64_t i = 1; i <= 3; ++i) {
    link->deliver(2, LinkEvent::Kind::pose, frame(2, i));
    link->deliver(1, LinkEvent::Kind::pose, frame(1, i));
  }
  for (uint64_t i = 1; i <= 3; ++i) {
    EXPECT_TRUE(receiver.poll());
    EXPECT_EQ(poses.streams()[0].header.sequence, i);
    EXPECT_EQ(poses.streams()[1].header.sequence, i - 1);
    EXPECT_TRUE(receiver.poll());
    EXPECT_EQ(poses.streams()[1].header.sequence, i);
  }
  EXPECT_FALSE(receiver.poll());
}

TEST_F(StreamReceiverTest, RepeatedDescriptionsDelayNobody) {
  step_ns_ = 1'000'000;
  link_->deliver(2, LinkEvent::Kind::control, description(5000));
  receiver_.poll();
  uint64_t epoch = 0;
  for (uint64_t i = 1; i <= 10; ++i) {
    for (int n = 0; n < 100; ++n) link_->deliver(1, LinkEvent::Kind::control, description(++epoch));
    link_->deliver(2, LinkEvent::Kind::pose, frame(5000, i));
    const uint64_t before = poses_.name_lookups();
    EXPECT_TRUE(receiver_.poll());
    EXPECT_LE(poses_.name_lookups() - before, 10u) << "two descriptions a poll";
  }
  EXPECT_EQ(driver(), 5000u);
  EXPECT_LE(answers<wire::Status>(2).size(), 10u) << "the other one hears of it once a poll at most";
}

TEST_F(StreamReceiverTest, LongMessagesRestAfterEach) {
  link_->deliver(2, LinkEvent::Kind::control, description(5000));
  receiver_.poll();
  link_->deliver(1, LinkEvent::Kind::control, description(1, "large"));
  link_->deliver(1, LinkEvent::Kind::control, description(2, "large"));
  step_ns_ = 100'000'000;
  receiver_.poll();
  step_ns_ = 1;
  EXPECT_EQ(receiver_.deferred_messages(), 1u);
  now_ns_ += 100'000'000;
  for (uint64_t i = 1; i <= 100; ++i) {
    link_->deliver(2, LinkEvent::Kind::pose, frame(5000, i));
    EXPECT_TRUE(receiver_.poll());
    EXPECT_EQ(receiver_.deferred_messages(), 1u);
  }
  now_ns_ += 200'000'000;
  receiver_.poll();
  EXPECT_EQ(receiver_.deferred_messages(), 0u);
}

TEST_F(StreamReceiverTest, LongEditsMakeRests) {
  link_->deliver(1, LinkEvent::Kind::control, description(1, "editor", {"nothing"}));
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  receiver_.poll();
  uint64_t version = 0;
  const auto edits_after = [&](int64_t edit_ns, int64_t pause_ns) {
    receiver_.add_edit_time(0, edit_ns);
    now_ns_ += pause_ns;
    link_->deliver(1, LinkEvent::Kind::control, visible(1, ++version));
    receiver_.poll();
    return poses_.streams()[0].edits_received;
  };
  EXPECT_EQ(edits_after(1'000'000, 1'000), 1u) << "less than a slice";
  EXPECT_EQ(edits_after(10'000'000, 25'000'000), 1u) << "it rests for 30 ms";
  now_ns_ += 10'000'000;
  receiver_.poll();
  EXPECT_EQ(poses_.streams()[0].edits_received, 2u);
}

TEST_F(StreamReceiverTest, NewStreamsOfOneHostArePaced) {
  const std::shared_ptr<BudgetPool> pool = BudgetPool::create();
  PeerId last = 0;
  const auto connect = [&](const std::string& host) {
    link_->budgets[++last] = pool->add_peer("tcp://renderer:1 from " + host);
    link_->deliver(last, LinkEvent::Kind::connected);
    link_->deliver(last, LinkEvent::Kind::control,
                   description(last, "s" + std::to_string(last), {"nothing"}));
  };
  connect("10.0.0.1");
  receiver_.poll();
  constexpr auto kBurst = static_cast<size_t>(StreamAdmission::kBurst);
  for (size_t i = 0; i < kBurst + 6; ++i) connect("10.0.0.2");
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 1 + kBurst);
  EXPECT_EQ(receiver_.deferred_messages(), 6u);
  EXPECT_EQ(count_of(receiver_.take_log_messages(), "waits: 10.0.0.2 begins more than 8 streams a second"),
            1u);
  // Whoever leaves frees its place in the queue.
  for (PeerId peer = last - 3; peer <= last; ++peer)
    link_->deliver(peer, LinkEvent::Kind::disconnected, {}, "gone");
  receiver_.poll();
  receiver_.poll();
  EXPECT_EQ(receiver_.deferred_messages(), 2u);
  connect("10.0.0.3");
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 2 + kBurst) << "another host does not wait";
  now_ns_ += 130'000'000;
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 3 + kBurst);
  now_ns_ += 130'000'000;
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 4 + kBurst);
  EXPECT_EQ(receiver_.deferred_messages(), 0u);
}

TEST(StreamAdmission, HostsAreWithoutPorts) {
  EXPECT_EQ(host_of_peer("tcp://0.0.0.0:1 from 127.0.0.1"), "127.0.0.1");
  EXPECT_EQ(host_of_peer("udp://0.0.0.0:1 from 127.0.0.1:7345"), "127.0.0.1");
  EXPECT_EQ(host_of_peer("udp://[::]:1 from [::1]:7345"), "::1");
  EXPECT_EQ(host_of_peer("tcp://[::]:1 from fe80::1"), "fe80::1");
  EXPECT_EQ(host_of_peer("shm://demo peer 1"), "shm://demo peer 1");
}

TEST_F(StreamReceiverTest, OversizedDescriptionIsRefused) {
  PeerLimits limits;
  limits.of(Resource::names) = 10;
  state::PoseState poses(scene_);
  StreamReceiver receiver(poses, false, {}, BudgetPool::create(limits));
  auto listener = std::make_unique<ScriptedListener>();
  link_ = listener.get();
  receiver.add(std::move(listener));
  std::vector<std::string> nodes;
  for (int i = 0; i < 11; ++i) nodes.push_back(std::to_string(i));
  link_->deliver(1, LinkEvent::Kind::control, description(1, "large", nodes));
  receiver.poll();
  EXPECT_EQ(receiver.active_streams(), 0u);
  ASSERT_EQ(answers<wire::Welcome>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(1)[0].status, wire::WelcomeStatus::bad_description);
  EXPECT_NE(answers<wire::Welcome>(1)[0].message.find("--peer-limit names="), std::string::npos);
  nodes.pop_back();
  for (uint64_t epoch = 2; epoch < 10; ++epoch)  // a replaced description is not charged
    link_->deliver(1, LinkEvent::Kind::control, description(epoch, "large", nodes));
  receiver.poll();
  EXPECT_EQ(answers<wire::Welcome>(1).back().status, wire::WelcomeStatus::accepted);
}

}  // namespace
}  // namespace fire3dv::app
