// The parts of the UDP link that do no I/O, under loss, reordering and repetition from seeded generators.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "protocol/transport/udp/udp_control.h"
#include "protocol/transport/udp/udp_handshake.h"
#include "protocol/transport/udp/udp_poses.h"
#include "protocol/transport/udp/udp_session.h"

namespace fire3dv::transport::udp {
namespace {

std::vector<std::byte> pattern(size_t bytes, uint32_t seed) {
  std::mt19937 generator(seed);
  std::vector<std::byte> message(bytes);
  for (std::byte& byte : message) byte = static_cast<std::byte>(generator());
  return message;
}

// Vector of the reference implementation: key 00..0f, message 00..0e.
TEST(UdpCookie, SipHashIsReferenceFunction) {
  std::vector<std::byte> message;
  for (int i = 0; i < 15; ++i) message.push_back(static_cast<std::byte>(i));
  EXPECT_EQ(siphash({0x0706050403020100, 0x0f0e0d0c0b0a0908}, message), 0xa129ca6149be45e5u);
}

bool first_time(ReplayWindow& window, uint64_t counter) {
  const bool is_new = window.is_new(counter);
  if (is_new) window.mark(counter);
  return is_new;
}

struct Wire {
  FragmentHeader header;
  std::vector<std::byte> data;
};

TEST(UdpControl, LossKeepsOrder) {
  for (const double loss : {0.0, 0.05, 0.2, 0.5}) {
    std::mt19937 generator(42);
    std::uniform_real_distribution<double> chance(0, 1);
    ControlSender sender;
    ControlReceiver receiver;
    std::vector<std::vector<std::byte>> sent;
    for (const size_t bytes : {0, 1, 1135, 1136, 1137, 100'000, 700'000, 17}) {
      sent.push_back(pattern(bytes, static_cast<uint32_t>(bytes)));
      ASSERT_TRUE(sender.push(ControlSender::prepare(sent.back()), SIZE_MAX));
    }
    std::vector<std::vector<std::byte>> got;
    std::vector<Wire> on_the_way;
    std::vector<Ack> acks;
    int64_t now_ns = 1;
    uint64_t lost = 0;
    for (int turn = 0; turn < 200'000 && !sender.idle(); ++turn) {
      while (const auto fragment = sender.next(now_ns)) {
        Wire wire{fragment->header, {fragment->data.begin(), fragment->data.end()}};
        if (chance(generator) < loss) {
          ++lost;
          continue;
        }
        if (chance(generator) < loss) on_the_way.push_back(wire);  // twice
        on_the_way.push_back(std::move(wire));
      }
      if (loss > 0) std::shuffle(on_the_way.begin(), on_the_way.end(), generator);
      for (const Wire& wire : on_the_way) {
        const auto outcome = receiver.fragment(wire.header, wire.data, SIZE_MAX);
        ASSERT_NE(outcome, ControlReceiver::Outcome::corrupt);
        if (outcome == ControlReceiver::Outcome::complete) got.push_back(receiver.take());
        if (const auto ack = receiver.ack(); ack && chance(generator) >= loss) acks.push_back(*ack);
      }
      on_the_way.clear();
      now_ns += 1'000'000;
      for (const Ack& ack : acks) sender.acknowledge(ack, now_ns);
      acks.clear();
    }
    EXPECT_TRUE(sender.idle()) << "loss " << loss;
    EXPECT_EQ(got, sent) << "loss " << loss;
    EXPECT_EQ(lost != 0, loss != 0) << "the loss took place";
  }
}

TEST(UdpControl, ClaimedLengthTakesNoMemory) {
  ControlReceiver receiver;
  FragmentHeader header{1, 255, 59'000, 59'000 * static_cast<uint32_t>(kFragmentBytes), 1};
  const auto data = pattern(kFragmentBytes, 1);
  EXPECT_EQ(receiver.fragment(header, data, SIZE_MAX), ControlReceiver::Outcome::accepted);
  EXPECT_LT(receiver.buffered_bytes(), 600'000u);
  header.index = 50'000;
  EXPECT_EQ(receiver.fragment(header, data, SIZE_MAX), ControlReceiver::Outcome::ignored)
      << "out of the window";
  header.index = 256;
  EXPECT_EQ(receiver.fragment(header, data, 0), ControlReceiver::Outcome::ignored) << "over the budget";
}

TEST(UdpControl, ContradictionIsCorrupt) {
  using Outcome = ControlReceiver::Outcome;
  const auto data = pattern(kFragmentBytes, 1);
  const FragmentHeader sound{1, 0, 2, static_cast<uint32_t>(kFragmentBytes) + 5, 1};
  {
    ControlReceiver receiver;
    FragmentHeader wrong = sound;
    wrong.count = 3;
    EXPECT_EQ(receiver.fragment(wrong, data, SIZE_MAX), Outcome::corrupt);
    wrong = sound;
    wrong.message_bytes = UINT32_MAX;
    EXPECT_EQ(receiver.fragment(wrong, data, SIZE_MAX), Outcome::corrupt);
  }
  {
    ControlReceiver receiver;
    EXPECT_EQ(receiver.fragment(sound, data, SIZE_MAX), Outcome::accepted);
    FragmentHeader other = sound;
    other.hash = 2;
    EXPECT_EQ(receiver.fragment(other, data, SIZE_MAX), Outcome::corrupt);
  }
  {
    ControlReceiver receiver;
    EXPECT_EQ(receiver.fragment(sound, data, SIZE_MAX), Outcome::accepted);
    FragmentHeader last = sound;
    last.index = 1;
    EXPECT_EQ(receiver.fragment(last, pattern(6, 1), SIZE_MAX), Outcome::corrupt) << "wrong size";
    EXPECT_EQ(receiver.fragment(last, pattern(5, 1), SIZE_MAX), Outcome::corrupt) << "wrong hash";
  }
}

TEST(UdpControl, ForgedAcknowledgmentsDoNoHarm) {
  ControlSender sender;
  ASSERT_TRUE(sender.push(ControlSender::prepare(pattern(500'000, 1)), SIZE_MAX));
  std::mt19937 generator(6);
  for (int i = 0; i < 10'000; ++i) {
    Ack ack;
    ack.message = generator() % 3;
    ack.first_missing = generator() >> (generator() % 32);
    for (uint64_t& word : ack.beyond) word = generator();
    sender.acknowledge(ack, i);
  }
  EXPECT_FALSE(sender.idle()) << "nobody can have what was never sent";
  EXPECT_TRUE(sender.next(20'000));
}

TEST(UdpWindow, EachCounterPassesOnce) {
  ReplayWindow window;
  EXPECT_FALSE(first_time(window, 0));
  std::mt19937 generator(7);
  std::vector<uint64_t> counters;
  for (uint64_t i = 1; i <= 100'000; ++i) counters.push_back(i);
  for (size_t i = 0; i + 64 <= counters.size(); i += 64)
    std::shuffle(counters.begin() + static_cast<std::ptrdiff_t>(i),
                 counters.begin() + static_cast<std::ptrdiff_t>(i + 64), generator);
  for (size_t i = 0; i < counters.size(); ++i) {
    EXPECT_TRUE(first_time(window, counters[i]));
    EXPECT_FALSE(first_time(window, counters[i]));
    EXPECT_FALSE(first_time(window, counters[i - std::min<size_t>(i, 1000)]));
  }
  EXPECT_TRUE(first_time(window, UINT64_MAX));
  EXPECT_FALSE(first_time(window, UINT64_MAX));
  EXPECT_FALSE(first_time(window, 100'001)) << "too old to be known";
}

TEST(UdpWindow, AllPartsMakeAFrame) {
  using Outcome = FrameTracker::Outcome;
  FrameTracker tracker;
  EXPECT_EQ(tracker.part(1, 2, true), Outcome::part);
  EXPECT_EQ(tracker.part(1, 0, false), Outcome::part);
  EXPECT_EQ(tracker.part(1, 0, false), Outcome::repeated) << "a repetition does not count twice";
  EXPECT_EQ(tracker.part(1, 1, false), Outcome::whole);
  EXPECT_EQ(tracker.part(2, 0, false), Outcome::part);
  EXPECT_EQ(tracker.part(3, 0, true), Outcome::whole);
  EXPECT_EQ(tracker.part(2, 1, true), Outcome::superseded);
  for (uint64_t frame = 10; frame < 1000; ++frame) EXPECT_EQ(tracker.part(frame, 5, true), Outcome::part);
  EXPECT_EQ(tracker.part(11, 0, false), Outcome::superseded) << "only the newest are remembered";
}

}  // namespace
}  // namespace fire3dv::transport::udp
