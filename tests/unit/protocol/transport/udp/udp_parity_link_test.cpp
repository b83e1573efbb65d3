// Whole frames over links that lose datagrams: parity restores them, and older peers get none.
#include <atomic>
#include <map>
#include <set>

#include "protocol/transport/udp/udp_datagram.h"
#include "tests/unit/protocol/transport/link_fixture.h"
#include "tests/unit/protocol/transport/secure_fixture.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::transport::test {
namespace {

constexpr int kParts = 15;  // as 300 nodes

struct Lossy {
  std::string publisher_options, listener_options;
  bool is_sealed = false;
  double loss = 0;
  int64_t jitter_ns = 0;
};

// Frames, and datagrams of each type that the relay saw on their way to the listener.
struct Outcome {
  int whole = 0, late = 0;
  uint64_t poses = 0, parity = 0, malformed = 0;
  bool is_lateness_noted = false;
};

Outcome run_frames(const Lossy& lossy, int frames, int first_counted) {
  Secured secured;
  ListenerOptions listener_options = lossy.is_sealed ? secured.keyed_listener('1') : ListenerOptions();
  listener_options.delivery = Delivery::all;
  Listener listener("udp://127.0.0.1:0" + lossy.listener_options, listener_options);
  const std::string uri = listener.link->uri();
  auto relay = std::move(*impair::UdpRelay::open("udp://127.0.0.1:0", uri.substr(0, uri.find('?')), {}));
  std::atomic<uint64_t> poses{0}, parity{0};
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    udp::Header header;
    if (to_target && udp::read_header(datagram, header)) {
      poses += header.type == udp::Type::pose;
      parity += header.type == udp::Type::parity;
    }
    return true;
  });
  auto publisher =
      open_publisher_or_fail(relay->uri() + lossy.publisher_options,
                             lossy.is_sealed ? secured.keyed_publisher('1') : PublisherOptions());
  EXPECT_TRUE(publisher->set_description(bytes_of("d")));
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "d"); }));
  publish_until_seen(*publisher, listener, "start");
  impair::Impairment impairment;
  impairment.loss = lossy.loss;
  impairment.seed = 4;
  impairment.delay_ns = impairment.jitter_ns = lossy.jitter_ns;
  relay->set(impairment);
  for (int frame = 0; frame < frames; ++frame) {
    for (int part = 0; part < kParts; ++part) {
      const std::string text = std::to_string(frame) + " " + std::to_string(part) + " ";
      publisher->publish(message_of(text + std::string(part + 1 == kParts ? 200 : 1000, 'p')),
                         part + 1 == kParts);
    }
    ::usleep(4000);
    listener.poll();
  }
  relay->set({});
  publish_until_seen(*publisher, listener, "end");
  std::map<int, std::set<int>> parts;
  Outcome outcome;
  for (const Event& event : listener.events) {
    int frame = 0, part = 0;
    if (event.kind != Kind::pose || std::sscanf(event.text.c_str(), "%d %d", &frame, &part) != 2) continue;
    EXPECT_EQ(event.text.back(), 'p');
    if (!parts[frame].insert(part).second) ++outcome.late;
  }
  for (const auto& [frame, received] : parts)
    outcome.whole += frame >= first_counted && received.size() == size_t{kParts};
  outcome.is_lateness_noted = listener.saw_part(Kind::note, "come after 64 newer ones");
  outcome.poses = poses;
  outcome.parity = parity;
  outcome.malformed =
      rejected(listener.link->stats(), Cause::malformed) + rejected(publisher->stats(), Cause::malformed);
  return outcome;
}

constexpr int kFrames = 400, kSettling = 50, kCounted = kFrames - kSettling;

struct UdpParityLoss : testing::TestWithParam<bool> {};

TEST_P(UdpParityLoss, FramesAreWholeAtFivePercent) {
  const Outcome outcome = run_frames({"", "", GetParam(), 0.05}, kFrames, kSettling);
  EXPECT_GE(outcome.whole, kCounted * 99 / 100);
  EXPECT_EQ(outcome.late, 0) << "no part is handed on twice";
  EXPECT_EQ(outcome.malformed, 0u);
}

TEST_P(UdpParityLoss, FramesAreWholeAtThirtyPercent) {
  const Outcome outcome = run_frames({"", "", GetParam(), 0.3}, kFrames, kSettling);
  EXPECT_GE(outcome.whole, kCounted * 90 / 100);
  EXPECT_EQ(outcome.malformed, 0u);
}

INSTANTIATE_TEST_SUITE_P(Transport, UdpParityLoss, testing::Bool(),
                         [](const auto& which) { return std::string(which.param ? "sealed" : "open"); });

TEST(UdpParityLink, NothingIsSentWithoutLoss) {
  const Outcome outcome = run_frames({}, 100, 0);
  EXPECT_EQ(outcome.whole, 100);
  EXPECT_LE(outcome.parity * 10, outcome.poses) << "a busy machine may lose some";
}

TEST(UdpParityLink, PercentageIsSentWithoutLoss) {
  const Outcome outcome = run_frames({"?parity=20", "", false, 0}, 100, 0);
  EXPECT_EQ(outcome.whole, 100);
  EXPECT_GT(outcome.parity, 100u);
  EXPECT_EQ(outcome.malformed, 0u);
}

TEST(UdpParityLink, RecordsBeyondTheWindowAreNamed) {
  EXPECT_TRUE(run_frames({"", "", true, 0, 50'000'000}, 100, 0).is_lateness_noted);
  EXPECT_FALSE(run_frames({"", "", true, 0.05}, 100, 0).is_lateness_noted) << "losses are not late";
}

TEST(UdpParityLink, EitherSideTurnsItOff) {
  for (const Lossy& lossy :
       {Lossy{"?parity=off", "", false, 0.05}, {"?parity=50", "?parity=off", false, 0.05}}) {
    const Outcome outcome = run_frames(lossy, 100, 0);
    EXPECT_EQ(outcome.parity, 0u);
    EXPECT_LT(outcome.whole, 90) << "negative control: frames are lost";
  }
}

}  // namespace
}  // namespace fire3dv::transport::test
