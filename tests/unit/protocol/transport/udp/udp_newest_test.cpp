// The newest frame of a simulator that pauses arrives over UDP despite packet loss.
#include <atomic>
#include <climits>

#include "protocol/transport/udp/udp_datagram.h"
#include "tests/unit/protocol/transport/link_fixture.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::transport::test {
namespace {

using impair::Impairment;
using impair::UdpRelay;

// A listener behind a relay.
struct Behind {
  Listener listener{"udp://127.0.0.1:0"};
  std::unique_ptr<UdpRelay> relay;
  std::atomic<int> poses_to_lose{0};
  std::atomic<int> poses_seen{0};

  Behind() {
    auto opened = UdpRelay::open("udp://127.0.0.1:0", listener.link->uri(), {});
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    relay = std::move(*opened);
    relay->set_filter([this](bool, std::span<std::byte> datagram) {
      udp::Header header;
      if (!udp::read_header(datagram, header) || header.type != udp::Type::pose) return true;
      ++poses_seen;
      return poses_to_lose.fetch_sub(1) <= 0;
    });
  }
  std::unique_ptr<PublisherLink> publisher() {
    auto opened = open_publisher_or_fail(relay->uri());
    EXPECT_TRUE(opened->set_description(bytes_of("d")));
    EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "d"); }));
    return opened;
  }
};

TEST(UdpNewest, LastLostFrameIsRepaired) {
  Behind behind;
  auto publisher = behind.publisher();
  behind.poses_to_lose = 3;
  publisher->publish(message_of("the last one"));
  EXPECT_TRUE(behind.listener.poll_until([&] { return behind.listener.saw(Kind::pose, "the last one"); }));
  EXPECT_EQ(behind.listener.count(Kind::pose), 1u);
  EXPECT_EQ(publisher->stats().frames_dropped, 0u);
}

TEST(UdpNewest, LargeFrameSurvivesOverflow) {
  Behind behind;
  auto publisher = behind.publisher();
  constexpr int kParts = 500;
  behind.poses_to_lose = 400;
  for (int part = 0; part < kParts; ++part)
    publisher->publish(message_of(std::to_string(part)), part + 1 == kParts);
  EXPECT_TRUE(behind.listener.poll_until([&] { return behind.listener.count(Kind::pose) >= kParts; }));
  for (int part = 0; part < kParts; ++part)
    EXPECT_TRUE(behind.listener.saw(Kind::pose, std::to_string(part)));
  EXPECT_EQ(behind.listener.count(Kind::pose), static_cast<size_t>(kParts)) << "no part is handed on twice";
}

TEST(UdpNewest, EachNewSessionGetsIt) {
  Behind behind;
  const std::string uri = behind.listener.link->uri();
  auto publisher = behind.publisher();
  publisher->publish(message_of("the last one"));
  ASSERT_TRUE(behind.listener.poll_until([&] { return behind.listener.saw(Kind::pose, "the last one"); }));
  for (int restart = 0; restart < 3; ++restart) {
    behind.listener.link.reset();
    behind.listener.events.clear();
    auto again = open_listener(uri);
    ASSERT_TRUE(again.ok()) << again.error().message;
    behind.listener.link = std::move(*again);
    EXPECT_TRUE(behind.listener.poll_until([&] { return behind.listener.saw(Kind::pose, "the last one"); }));
  }
  EXPECT_EQ(publisher->stats().poses_dropped, 0u);
}

// Losses in buffers and on the network are detected by gaps in the frame numbers.
TEST(UdpNewest, MissingFramesAreCounted) {
  Behind behind;
  auto publisher = behind.publisher();
  constexpr uint64_t kFrames = 20;
  ASSERT_TRUE(publish_until_seen(*publisher, behind.listener, "first"));
  const uint64_t dropped_before = behind.listener.link->stats().frames_dropped;
  behind.listener.events.clear();
  behind.poses_to_lose = INT_MAX / 2;
  const int seen_before = behind.poses_seen;
  for (uint64_t i = 1; i < kFrames; ++i) publisher->publish(message_of("lost"));
  ASSERT_TRUE(behind.listener.poll_until(
      [&] { return behind.poses_seen - seen_before >= static_cast<int>(kFrames) - 1; }));
  behind.poses_to_lose = 0;  // from here on the one before the last may come, too, when it is repeated
  publisher->publish(message_of("last"));
  ASSERT_TRUE(behind.listener.poll_until([&] { return behind.listener.saw(Kind::pose, "last"); }));
  EXPECT_EQ(behind.listener.link->stats().frames_dropped - dropped_before +
                behind.listener.count(Kind::pose) + behind.listener.link->stats().poses_dropped,
            kFrames);
  EXPECT_GE(behind.listener.link->stats().frames_dropped - dropped_before, kFrames - 2);
}

// Unacknowledged frames are repeated at least every 250 ms: half a second without one means that it is
// acknowledged.
TEST(UdpNewest, ArrivedFramesAreNotRepeated) {
  Behind behind;
  auto publisher = behind.publisher();
  publisher->publish(message_of("the last one"));
  ASSERT_TRUE(behind.listener.poll_until([&] { return behind.listener.saw(Kind::pose, "the last one"); }));
  const auto until = std::chrono::steady_clock::now() + kHangLimit;
  int before = -1;
  while (behind.poses_seen != before && std::chrono::steady_clock::now() < until) {
    before = behind.poses_seen;
    ::usleep(500'000);
  }
  EXPECT_EQ(behind.poses_seen, before);
}

TEST(UdpNewest, DroppedFramesAreCounted) {
  auto publisher = open_publisher_or_fail("udp://127.0.0.1:9");
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  constexpr int kParts = 20, kFrames = 10;
  for (int frame = 0; frame < kFrames; ++frame)
    for (int part = 0; part < kParts; ++part) publisher->publish(message_of("p"), part + 1 == kParts);
  EXPECT_EQ(publisher->stats().frames_dropped, uint64_t{kFrames - 1}) << "the newest waits for a renderer";
  EXPECT_EQ(publisher->stats().poses_dropped, uint64_t{kParts} * (kFrames - 1));
}

}  // namespace
}  // namespace fire3dv::transport::test
