// Test of the behaviour common to TCP and UDP, plain and secured: start order, restarts, latest frame,
// refusals.
#include <algorithm>

#include "tests/unit/protocol/transport/secure_fixture.h"

namespace fire3dv::transport::test {
namespace {

class Network : public testing::TestWithParam<const char*> {
 protected:
  std::string scheme() const { return std::string(GetParam()).substr(0, 3); }
  std::string any_port() const { return scheme() + "://127.0.0.1:0"; }
  bool is_sealed() const { return std::string(GetParam()) == "udp_key"; }
  ListenerOptions listener_options() const {
    if (scheme() == "tls") return secured.tls_listener();
    return is_sealed() ? secured.keyed_listener('5') : ListenerOptions{};
  }
  PublisherOptions publisher_options() const {
    if (scheme() == "tls") return secured.tls_publisher();
    return is_sealed() ? secured.keyed_publisher('5') : PublisherOptions{};
  }
  Secured secured;
};

TEST_P(Network, ListenerFirst) {
  Listener listener(any_port(), listener_options());
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  EXPECT_EQ(listener.events[0].kind, Kind::connected);
  EXPECT_EQ(listener.events[1].kind, Kind::control);
  EXPECT_EQ(listener.events[1].text, "description");
  EXPECT_EQ(publisher->stats().peers, 1u);
  EXPECT_EQ(listener.link->stats().peers, 1u);
}

TEST_P(Network, ObserverHasEveryPoseOfAnUnpolledListener) {
  constexpr size_t kPoses = 100;
  Arrivals arrivals;
  ListenerOptions options = listener_options();
  options.on_arrival = arrivals.observer();
  Listener listener(any_port(), options);
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  ASSERT_TRUE(
      listener.poll_until([&] { return !arrivals.poses().empty() && arrivals.poses().back() == "pose"; }));
  std::vector<std::string> published;
  for (size_t i = 0; i < kPoses; ++i) {
    published.push_back(std::to_string(i));
    publisher->publish(message_of(published.back()));
    ASSERT_TRUE(Arrivals::wait_until([&] { return arrivals.poses().back() == published.back(); }));
  }
  const std::vector<std::string> arrived = arrivals.poses();  // of "pose", any number
  ASSERT_GT(arrived.size(), kPoses);
  EXPECT_TRUE(std::equal(published.begin(), published.end(), arrived.end() - kPoses));
  const auto polled = static_cast<size_t>(
      std::ranges::count_if(listener.events, [](const Event& event) { return event.kind == Kind::pose; }));
  uint64_t overtaken = 0;
  size_t poses = 0;
  std::string newest;
  ASSERT_TRUE(Arrivals::wait_until([&] {
    listener.link->poll([&](const LinkEvent& event) {
      overtaken += event.overtaken;
      poses += event.kind == Kind::pose;
      if (event.kind == Kind::pose) newest = text_of(event.message);
    });
    return newest == published.back();
  }));
  EXPECT_GE(poses + overtaken, kPoses);
  EXPECT_LE(poses + overtaken, arrived.size() - polled);
  publisher.reset();
  EXPECT_TRUE(Arrivals::wait_until([&] { return arrivals.ends() == 1; }));
}

TEST_P(Network, PublisherFirst) {
  std::string uri;
  {
    Listener taken(any_port(), listener_options());
    uri = taken.link->uri();
  }
  auto publisher = open_publisher_or_fail(uri, publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  for (int i = 0; i < 1000; ++i) publisher->publish(message_of(std::to_string(i)));
  EXPECT_EQ(publisher->stats().poses_dropped, 999u) << "the newest one waits for a renderer";
  Listener listener(uri, listener_options());
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "999"); }));
  EXPECT_EQ(listener.count(Kind::pose), 1u);
  EXPECT_TRUE(listener.saw(Kind::control, "description"));
}

TEST_P(Network, PublisherRestarts) {
  Listener listener(any_port(), listener_options());
  PeerId earlier = 0;
  for (int run = 0; run < 3; ++run) {
    auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
    ASSERT_TRUE(publisher->set_description(bytes_of("d" + std::to_string(run))));
    ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
    EXPECT_EQ(listener.count(Kind::connected), 1u);
    EXPECT_TRUE(listener.saw(Kind::control, "d" + std::to_string(run)));
    EXPECT_GT(listener.peer(), earlier);
    earlier = listener.peer();
    publisher.reset();
    ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
    listener.events.clear();
  }
}

TEST_P(Network, ListenerRestarts) {
  auto first = std::make_unique<Listener>(any_port(), listener_options());
  const std::string uri = first->link->uri();
  auto publisher = open_publisher_or_fail(uri, publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  ASSERT_TRUE(publish_until_seen(*publisher, *first, "pose"));
  first.reset();
  for (int run = 0; run < 3; ++run) {
    Listener listener(uri, listener_options());
    ASSERT_TRUE(publish_until_seen(*publisher, listener, "again" + std::to_string(run)));
    EXPECT_TRUE(listener.saw(Kind::control, "description"));
  }
}

// A renderer that connects later gets the last pose of a paused or lockstep simulator.
TEST_P(Network, NextListenerGetsLastPose) {
  auto listener = std::make_unique<Listener>(any_port(), listener_options());
  const std::string uri = listener->link->uri();
  auto publisher = open_publisher_or_fail(uri, publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(listener->poll_until([&] { return listener->saw(Kind::control, "d"); }));
  publisher->publish(message_of("the last one"));
  for (int restart = 0; restart < 3; ++restart) {
    ASSERT_TRUE(listener->poll_until([&] { return listener->saw(Kind::pose, "the last one"); })) << restart;
    EXPECT_EQ(listener->count(Kind::pose), 1u);
    listener.reset();
    listener = std::make_unique<Listener>(uri, listener_options());
  }
  EXPECT_EQ(publisher->stats().frames_dropped, 0u);
  // A new description discards the last pose of the previous one.
  ASSERT_TRUE(listener->poll_until([&] { return listener->saw(Kind::pose, "the last one"); }));
  listener.reset();
  ASSERT_TRUE(publisher->set_description(bytes_of("e")));
  listener = std::make_unique<Listener>(uri, listener_options());
  ASSERT_TRUE(listener->poll_until([&] { return listener->saw(Kind::control, "e"); }));
  publisher->publish(message_of("of e"));
  ASSERT_TRUE(listener->poll_until([&] { return listener->saw(Kind::pose, "of e"); }));
  EXPECT_FALSE(listener->saw(Kind::pose, "the last one"));
  EXPECT_EQ(publisher->stats().frames_dropped, 0u);
}

TEST_P(Network, ReplyOrderIsKept) {
  ListenerOptions options = listener_options();
  options.delivery = Delivery::all;
  Listener listener(any_port(), options);
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::control) == 1; }));
  const PeerId peer = listener.peer();
  for (int i = 0; i < 100; ++i) listener.link->send(peer, bytes_of("reply" + std::to_string(i)));
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(poll_until_reply(*publisher, "reply" + std::to_string(i)));
  for (int i = 0; i < 100; ++i) publisher->send_control(bytes_of("control" + std::to_string(i)));
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::control) == 101; }));
  int next = 0;
  for (const Event& event : listener.events)
    if (event.kind == Kind::control && event.text != "description") {
      EXPECT_EQ(event.text, "control" + std::to_string(next++));
    }
}

TEST_P(Network, ALargeDescriptionArrivesWhole) {
  Listener listener(any_port(), listener_options());
  std::string large(3'000'000, ' ');
  for (size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>('a' + i * i % 26);
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of(large)));
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::control) == 1; }));
  EXPECT_EQ(listener.last(Kind::control), large);
  ASSERT_TRUE(publisher->set_description(bytes_of("another")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  EXPECT_TRUE(listener.saw(Kind::control, "another"));
}

TEST_P(Network, SlowListenerGetsNewest) {
  Listener listener(any_port(), listener_options());
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "first"));
  const std::string filler(1000, '.');
  for (int i = 0; i < 20'000; ++i) publisher->publish(message_of(std::to_string(i) + filler));
  const std::string last = "last";
  listener.events.clear();
  // A datagram link may lose the last frame, so it repeats; it must not wait behind 20,000 others.
  ASSERT_TRUE(listener.poll_until([&] {
    publisher->publish(message_of(last));
    return listener.saw(Kind::pose, last);
  }));
  EXPECT_LT(listener.count(Kind::pose), 2000u);
}

TEST_P(Network, LockstepLosesNothing) {
  ListenerOptions options = listener_options();
  options.delivery = Delivery::all;
  Listener listener(any_port(), options);
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  for (int i = 0; i < 300; ++i) {
    const std::string text = "frame" + std::to_string(i);
    publisher->publish(message_of(text));
    ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, text); })) << i;
    listener.link->send(listener.peer(), bytes_of("ack" + std::to_string(i)));
    ASSERT_TRUE(poll_until_reply(*publisher, "ack" + std::to_string(i))) << i;
  }
  EXPECT_EQ(listener.count(Kind::pose), 300u);
}

TEST_P(Network, OverIpv6) {
  Listener listener(scheme() + "://[::1]:0", listener_options());
  EXPECT_NE(listener.link->uri().find("://[::1]:"), std::string::npos);
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose"));
}

TEST_P(Network, ByName) {
  Listener listener(any_port(), listener_options());
  const std::string uri = listener.link->uri();
  auto publisher =
      open_publisher_or_fail(scheme() + "://localhost" + uri.substr(uri.rfind(':')), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose"));
}

TEST_P(Network, UsedPortNamesUri) {
  Listener listener(any_port(), listener_options());
  const auto second = open_listener(listener.link->uri(), listener_options());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().message.find(listener.link->uri() + ": the port is in use"), 0u)
      << second.error().message;
}

TEST_P(Network, OnlyLoopbackWithoutInsecure) {
  for (const char* host : {"0.0.0.0", "[::]"}) {
    const std::string uri = scheme() + "://" + host + ":0";
    const auto refused = open_listener(uri);
    ASSERT_FALSE(refused.ok());
    const char* remedy = scheme() == "tls" ? "needs a certificate" : "--insecure";
    EXPECT_NE(refused.error().message.find(remedy), std::string::npos) << refused.error().message;
    ListenerOptions insecure = listener_options();
    insecure.insecure = true;
    EXPECT_TRUE(open_listener(uri, insecure).ok());
  }
}

TEST_P(Network, ForeignAddressesAreRefused) {
  ListenerOptions insecure = listener_options();
  insecure.insecure = true;
  const auto refused = open_listener(scheme() + "://192.0.2.1:0", insecure);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("not one of this machine"), std::string::npos)
      << refused.error().message;
  EXPECT_FALSE(open_publisher(any_port(), publisher_options()).ok()) << "a publisher needs a port";
}

TEST_P(Network, NoMorePeersThanAllowed) {
  ListenerOptions options = listener_options();
  options.max_peers = 2;
  Listener listener(any_port(), options);
  auto first = open_publisher_or_fail(listener.link->uri(), publisher_options());
  auto second = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 2; }));
  auto third = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw_part(Kind::note, "as many peers as allowed"); }));
  EXPECT_EQ(listener.count(Kind::connected), 2u);
  first.reset();
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 3; })) << "its turn comes";
}

// Frames of many parts, as large scenes have them on a datagram link: whole frames supersede, and no part is
// missing.
TEST(UdpFrames, PollGivesNewestWholeFrame) {
  Listener listener("udp://127.0.0.1:0");
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "d"); }));
  constexpr int kParts = 20, kFrames = 50;
  const auto wait_for = [](const std::function<bool()>& done) {
    const auto until = std::chrono::steady_clock::now() + kHangLimit;
    while (!done() && std::chrono::steady_clock::now() < until) ::usleep(100);
    return done();
  };
  for (int frame = 1; frame <= kFrames; ++frame) {
    for (int part = 0; part < kParts; ++part)
      EXPECT_TRUE(publisher->publish(message_of(std::to_string(frame) + "/" + std::to_string(part)),
                                     part + 1 == kParts));
    // Loopback loses nothing within the socket's buffer, so each frame arrives before the next one is sent.
    ASSERT_TRUE(
        wait_for([&] { return listener.link->stats().bytes_received >= publisher->stats().bytes_sent; }));
  }
  // The last drop is counted when the last frame is whole.
  const auto dropped = [&] {
    return listener.link->stats().poses_dropped + publisher->stats().poses_dropped;
  };
  ASSERT_TRUE(wait_for([&] { return dropped() == uint64_t{kParts} * (kFrames - 1); })) << dropped();
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) >= kParts; }));
  EXPECT_EQ(listener.count(Kind::pose), static_cast<size_t>(kParts));
  for (int part = 0; part < kParts; ++part)
    EXPECT_TRUE(listener.saw(Kind::pose, std::to_string(kFrames) + "/" + std::to_string(part))) << part;
}

INSTANTIATE_TEST_SUITE_P(Transport, Network, testing::Values("tcp", "tls", "udp", "udp_key"),
                         [](const auto& link) { return std::string(link.param); });

}  // namespace
}  // namespace fire3dv::transport::test
