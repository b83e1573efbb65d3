// Ownership of nodes by streams: reconnection, restart, takeover, conflicts.
#include "tests/unit/renderer/streams/receiver_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(StreamReceiverTest, ReconnectKeepsNodes) {
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  EXPECT_TRUE(receiver_.poll());
  link_->deliver(3, LinkEvent::Kind::control, description(7));
  // The first connection is dead, and its time-out has not expired.
  link_->deliver(2, LinkEvent::Kind::control, description(42));
  link_->deliver(2, LinkEvent::Kind::pose, frame(42, 2));
  EXPECT_FALSE(receiver_.poll());
  EXPECT_EQ(answers<wire::Ping>(1).size(), 1u) << "it may be alive";
  ASSERT_EQ(answers<wire::Status>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].contested_names, std::vector<std::string>{"arm"});
  EXPECT_NE(answers<wire::Status>(1)[0].message.find("another connection"), std::string::npos);
  now_ns_ += 2 * kSecondNs - 1;
  EXPECT_FALSE(receiver_.poll());
  EXPECT_TRUE(answers<wire::Welcome>(2).empty());
  now_ns_ += 1;
  receiver_.poll();
  EXPECT_TRUE(receiver_.poll());
  EXPECT_EQ(receiver_.active_streams(), 2u);
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_TRUE(answers<wire::Welcome>(2)[0].conflicting_names.empty());
  ASSERT_EQ(poses_.shown().size(), 1u);
  EXPECT_EQ(poses_.shown()[0].sequence, 2u);
  EXPECT_NE(poses_.node_drives()[0].stream, state::kNone);

  link_->deliver(1, LinkEvent::Kind::disconnected, {},
                 "timed out");  // the late time-out of the old connection changes nothing
  now_ns_ += 10 * kSecondNs;
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 2u);
  EXPECT_EQ(driver(), 42u);
}

TEST_F(StreamReceiverTest, EpochAloneTakesNothing) {
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  receiver_.poll();
  now_ns_ += 10 * kSecondNs;  // a simulator that pauses
  link_->deliver(2, LinkEvent::Kind::control, description(42));
  link_->deliver(2, LinkEvent::Kind::pose, frame(42, 9));
  receiver_.poll();
  now_ns_ += kSecondNs / 4;
  const std::vector<wire::Ping> pings = answers<wire::Ping>(1);
  ASSERT_EQ(pings.size(), 1u);
  link_->deliver(1, LinkEvent::Kind::control,
                 wire::encode(wire::Pong{pings[0].id, pings[0].sender_time_ns, 5'000'000'000}));
  for (int i = 0; i < 3; ++i) {
    receiver_.poll();
    now_ns_ += kSecondNs / 4;
  }
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(2)[0].status, wire::WelcomeStatus::refused);
  EXPECT_EQ(answers<wire::Welcome>(2)[0].epoch, 42u);
  EXPECT_EQ(receiver_.active_streams(), 1u);
  EXPECT_EQ(poses_.shown().at(0).sequence, 1u);
  EXPECT_EQ(receiver_.rejected_messages(), 1u) << "the frame";
  // A peer with its own stream cannot take it over either.
  link_->deliver(3, LinkEvent::Kind::control, description(7, "other"));
  link_->deliver(3, LinkEvent::Kind::control, description(42));
  receiver_.poll();
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 2));
  now_ns_ += 1;
  EXPECT_TRUE(receiver_.poll());
  receiver_.poll();
  EXPECT_EQ(driver(), 42u);
  EXPECT_EQ(answers<wire::Welcome>(3).back().status, wire::WelcomeStatus::refused);
}

TEST_F(StreamReceiverTest, LostLinkResumesReservation) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "waits"));
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "reset");
  receiver_.poll();
  EXPECT_EQ(driver(), 0u);
  link_->deliver(3, LinkEvent::Kind::control, description(1, "another name"));
  receiver_.poll();
  EXPECT_EQ(driver(), 0u) << "neither who waits nor who pretends";
  link_->deliver(3, LinkEvent::Kind::control, wire::encode(wire::Goodbye{1}));
  now_ns_ += 5 * kSecondNs - 1;
  link_->deliver(4, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  now_ns_ += 10 * kSecondNs;
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  link_->deliver(4, LinkEvent::Kind::control, wire::encode(wire::Goodbye{1}));
  receiver_.poll();
  EXPECT_EQ(driver(), 2u) << "who says goodbye leaves no place";
}

TEST_F(StreamReceiverTest, RestartHoldsUntilPredecessorReturns) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "waits"));
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "reset");
  link_->deliver(3, LinkEvent::Kind::control, description(3));
  link_->deliver(4, LinkEvent::Kind::control, description(4));
  receiver_.poll();
  EXPECT_EQ(driver(), 3u) << "of that name";
  now_ns_ += 4 * kSecondNs;
  link_->deliver(5, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_EQ(driver(), 1u) << "that epoch";
  EXPECT_EQ(answers<wire::Welcome>(3).back().status, wire::WelcomeStatus::refused);
  EXPECT_EQ(receiver_.active_streams(), 3u);
  link_->deliver(5, LinkEvent::Kind::disconnected, {}, "reset");
  link_->deliver(6, LinkEvent::Kind::control, description(6));
  receiver_.poll();
  EXPECT_EQ(driver(), 4u) << "of that name, and there already";
  now_ns_ += 6 * kSecondNs;
  link_->deliver(7, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_EQ(driver(), 4u) << "too late";
}

// Over UDP a killed publisher times out only after seconds.
TEST_F(StreamReceiverTest, EarlyRestartTakesNodes) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "waits"));
  link_->deliver(3, LinkEvent::Kind::control, description(3));
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "nothing came from it for 10 seconds");
  receiver_.poll();
  EXPECT_EQ(driver(), 3u);
  link_->deliver(4, LinkEvent::Kind::control, description(1));  // only its link was lost
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(3).back().status, wire::WelcomeStatus::refused);
  EXPECT_EQ(receiver_.active_streams(), 2u);
}

// Two publishers of one name: whatever the younger one does, the older one keeps its nodes.
TEST_F(StreamReceiverTest, NamesakeTakesNothing) {
  link_->deliver(1, LinkEvent::Kind::control, description(1, "same"));
  link_->deliver(1, LinkEvent::Kind::pose, frame(1, 1));
  receiver_.poll();
  PeerId peer = 2;
  for (const bool says_goodbye : {false, true, false}) {
    for (int visit = 0; visit < 3; ++visit, ++peer) {
      link_->deliver(peer, LinkEvent::Kind::control, description(2, "same"));
      link_->deliver(peer, LinkEvent::Kind::pose, frame(2, 1));
      receiver_.poll();
      EXPECT_EQ(driver(), 1u) << peer;
      if (says_goodbye) link_->deliver(peer, LinkEvent::Kind::control, wire::encode(wire::Goodbye{2}));
      link_->deliver(peer, LinkEvent::Kind::disconnected, {}, "gone");
      receiver_.poll();
      EXPECT_EQ(driver(), 1u) << peer;
      EXPECT_EQ(receiver_.active_streams(), 1u) << peer;
    }
  }
}

TEST_F(StreamReceiverTest, NewDescriptionKeepsNodes) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  for (uint64_t epoch = 3; epoch < 20; ++epoch) {
    link_->deliver(1, LinkEvent::Kind::control, description(epoch));
    receiver_.poll();
    EXPECT_EQ(driver(), epoch);
  }
  EXPECT_EQ(answers<wire::Welcome>(2).size(), 1u) << "nothing changed for the one that waits";
}

TEST_F(StreamReceiverTest, SegmentPublisherMayRestart) {
  link_->address = "shm://robot";
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(9, LinkEvent::Kind::control, description(9, "waits"));
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "killed");
  link_->deliver(2, LinkEvent::Kind::control, description(2, "restarted"));
  receiver_.poll();
  EXPECT_EQ(driver(), 2u);
}

// The disconnected stream keeps its nodes for a grace time.
TEST_F(StreamReceiverTest, ContenderGetsFreedNode) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "another"));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(2)[0].conflicting_names, std::vector<std::string>{"arm"});
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "it left");
  receiver_.poll();
  EXPECT_EQ(answers<wire::Welcome>(2).size(), 1u);
  now_ns_ += 5 * kSecondNs;
  receiver_.poll();
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 2u);
  EXPECT_TRUE(answers<wire::Welcome>(2)[1].conflicting_names.empty());
}

TEST_F(StreamReceiverTest, DriverHearsContention) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_TRUE(answers<wire::Status>(1).empty()) << "nobody else is there";
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Status>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].epoch, 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].contested_names, std::vector<std::string>{"arm"});
  link_->deliver(3, LinkEvent::Kind::control, description(3));
  receiver_.poll();
  EXPECT_EQ(answers<wire::Status>(1).size(), 1u) << "a third one changes nothing for the first";
  EXPECT_TRUE(answers<wire::Status>(2).empty()) << "it drives nothing that could be asked for";

  link_->deliver(1, LinkEvent::Kind::control, wire::encode(wire::Goodbye{1}));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Status>(2).size(), 1u) << "the second has the node now, and the third asks for it";
  link_->deliver(3, LinkEvent::Kind::control, wire::encode(wire::Goodbye{3}));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Status>(2).size(), 2u);
  EXPECT_TRUE(answers<wire::Status>(2)[1].contested_names.empty());
}

// On a multicast group every host sees the epoch of a stream.
TEST_F(StreamReceiverTest, SeenEpochTakesNothing) {
  auto other = std::make_unique<ScriptedListener>();
  ScriptedListener* const open_link = other.get();
  receiver_.add(std::move(other));
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  receiver_.poll();
  const auto owner = poses_.node_drives()[0].stream;
  open_link->deliver(1, LinkEvent::Kind::control, description(42));
  open_link->deliver(1, LinkEvent::Kind::pose, frame(42, 7));
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 2u);
  EXPECT_EQ(poses_.node_drives()[0].stream, owner);
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 2));
  EXPECT_TRUE(receiver_.poll()) << "the first stream still drives its node";
}

}  // namespace
}  // namespace fire3dv::app
