// Multicast groups over an interface: a joiner receives all control messages and never sends.
#include <net/if.h>

#include <algorithm>
#include <random>

#include "protocol/transport/core/link_factories.h"
#include "protocol/transport/udp/multicast/udp_group.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/transport/udp/udp_group_socket.h"
#include "tests/unit/protocol/transport/network_namespace.h"
#include "tests/unit/protocol/transport/raw_socket.h"
#include "tests/unit/protocol/transport/secure_fixture.h"

namespace fire3dv::transport::test {
namespace {

struct Group : testing::TestWithParam<const char*> {
  const std::string uri = [] {
    static int number = 0;
    return "udp://" + std::string(GetParam()) + ":" +
           std::to_string(20'000 + (::getpid() * 7 + ++number) % 10'000) +
           "?interface=" + OwnNetwork::interface();
  }();
  static ListenerOptions insecure() {
    ListenerOptions options;
    options.insecure = true;
    return options;
  }
};

TEST_P(Group, JoiningListenersGetEverything) {
  Listener early(uri, insecure());
  auto publisher = open_publisher_or_fail(uri);
  const std::string description(300'000, 'd');
  ASSERT_TRUE(publisher->set_description(bytes_of(description)));
  publisher->send_control(bytes_of("afterwards"));
  ASSERT_TRUE(publish_until_seen(*publisher, early, "one"));
  Listener late(uri, insecure());
  ASSERT_TRUE(late.poll_until([&] { return late.saw(Kind::pose, "one"); }))
      << "the frame of before the pause";
  publisher->publish(message_of("two"));
  for (Listener* listener : {&early, &late}) {
    ASSERT_TRUE(listener->poll_until([&] { return listener->saw(Kind::pose, "two"); }));
    ASSERT_TRUE(listener->poll_until([&] { return listener->count(Kind::control) == 2; }));
    std::vector<std::string> controls;
    for (const Event& event : listener->events)
      if (event.kind == Kind::control) controls.push_back(event.text);
    EXPECT_EQ(controls, (std::vector<std::string>{description, "afterwards"}));
    EXPECT_EQ(listener->count(Kind::connected), 1u);
    listener->link->send(listener->peer(), bytes_of("a reply"));
    EXPECT_EQ(listener->link->stats().bytes_sent, 0u);
    EXPECT_EQ(listener->link->stats().peers, 1u);
  }
  std::vector<std::byte> message;
  EXPECT_FALSE(publisher->poll(message));
  publisher.reset();
  ASSERT_TRUE(early.poll_until([&] { return early.saw_part(Kind::disconnected, "closed the link"); }));
}

TEST_P(Group, JoinerGetsNewestOfEachKey) {
  const auto shared = [](std::string_view text) {
    const auto bytes = bytes_of(text);
    return std::make_shared<const wire::Bytes>(bytes.begin(), bytes.end());
  };
  Listener early(uri, insecure());
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publisher->put_state(1, shared("1 old")).ok());
  ASSERT_TRUE(publisher->put_state(2, shared("2")).ok());
  ASSERT_TRUE(early.poll_until([&] { return early.saw(Kind::control, "2"); }));
  ASSERT_TRUE(publisher->put_state(1, shared("1 new")).ok());
  ASSERT_TRUE(early.poll_until([&] { return early.saw(Kind::control, "1 new"); }));
  Listener late(uri, insecure());
  ASSERT_TRUE(late.poll_until([&] { return late.saw(Kind::control, "1 new"); }));
  std::vector<std::string> controls;
  for (const Event& event : late.events)
    if (event.kind == Kind::control) controls.push_back(event.text);
  EXPECT_EQ(controls, (std::vector<std::string>{"d", "2", "1 new"}));
  // A new description ends them.
  ASSERT_TRUE(publisher->set_description(bytes_of("e")));
  ASSERT_TRUE(publisher->put_state(2, shared("2 again")).ok());
  for (Listener* listener : {&early, &late})
    ASSERT_TRUE(listener->poll_until([&] { return listener->saw(Kind::control, "2 again"); }));
  EXPECT_EQ(late.count(Kind::control), 5u);
}

TEST_P(Group, ExhaustedNumbersMakeNewPeer) {
  constexpr uint32_t kMaxNumbers = 40;
  Listener listener(uri, insecure());
  const auto parsed = parse_uri(uri);
  ASSERT_TRUE(parsed.ok());
  auto made = udp::make_group_publisher(*parsed, *udp::group_of(*parsed), {}, kMaxNumbers);
  ASSERT_TRUE(made.ok()) << made.error().message;
  PublisherLink& publisher = **made;
  ASSERT_TRUE(publisher.set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(publisher, listener, "before"));
  const auto newest = bytes_of("newest"), older = bytes_of("older");
  for (uint32_t i = 0; i < 2 * kMaxNumbers; ++i)
    ASSERT_TRUE(publisher.put_state(1, std::make_shared<const wire::Bytes>(older.begin(), older.end())).ok());
  ASSERT_TRUE(publisher.put_state(1, std::make_shared<const wire::Bytes>(newest.begin(), newest.end())).ok());
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw_part(Kind::disconnected, "closed the link"); }));
  ASSERT_TRUE(listener.poll_until([&] { return listener.last(Kind::control) == "newest"; }));
  EXPECT_TRUE(publish_until_seen(publisher, listener, "after"));
  EXPECT_GE(listener.count(Kind::connected), 2u);
  EXPECT_EQ(listener.link->stats().peers, 1u);
}

TEST_P(Group, LargeFramesArriveWhole) {
  Listener listener(uri, insecure());
  for (int life = 1; life <= 2; ++life) {
    auto publisher = open_publisher_or_fail(uri + "&mtu=576");
    ASSERT_TRUE(publisher->set_description(bytes_of("life " + std::to_string(life))));
    const std::string part(publisher->max_pose_message_bytes(), static_cast<char>('0' + life));
    ASSERT_TRUE(listener.poll_until([&] {
      for (int i = 0; i < 20; ++i) publisher->publish(message_of(part), i == 19);
      size_t parts = 0;
      for (const Event& event : listener.events) parts += event.kind == Kind::pose && event.text == part;
      return parts >= 20;
    }));
    EXPECT_EQ(listener.last(Kind::control), "life " + std::to_string(life));
  }
  EXPECT_EQ(listener.count(Kind::connected), 2u);
}

// A lossy bridge between two groups: of each frame three pose datagrams are lost.
TEST_P(Group, ParityRestoresLostParts) {
  constexpr int kParts = 15;
  const auto from = parse_uri(uri);
  Uri to = *from;
  to.port = static_cast<uint16_t>(from->port + 10'000);
  const auto received = udp::open_group_receiver(*from, *udp::group_of(*from));
  const auto sender = udp::open_group_sender(to, *udp::group_of(to));
  ASSERT_TRUE(received.ok() && sender.ok());
  ListenerOptions options = insecure();
  options.delivery = Delivery::all;
  Listener listener(uri_text(to), options);
  auto publisher = open_publisher_or_fail(uri + "&parity=40");
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  size_t lost = 0;
  const auto forward = [&] {
    std::byte datagram[udp::kMaxDatagramBytes];
    for (ssize_t got; (got = ::recv(received->get(), datagram, sizeof datagram, MSG_DONTWAIT)) > 0;) {
      udp::Header header;
      udp::PoseHeader pose;
      const std::span<const std::byte> bytes(datagram, static_cast<size_t>(got));
      const bool is_lost = udp::read_header(bytes, header) && header.type == udp::Type::pose &&
                           udp::read_pose_header(bytes.subspan(udp::kHeaderBytes), pose) &&
                           pose.part % 5 == pose.frame % 5;
      lost += is_lost;
      if (!is_lost) ::send(sender->get(), datagram, static_cast<size_t>(got), MSG_DONTWAIT);
    }
  };
  const std::string part(700, 'p');
  ASSERT_TRUE(listener.poll_until([&] {
    for (int i = 0; i < kParts; ++i)
      publisher->publish(message_of(std::to_string(i) + part), i + 1 == kParts);
    forward();
    for (int i = 0; i < kParts; ++i)
      if (!listener.saw(Kind::pose, std::to_string(i) + part)) return false;
    return listener.count(Kind::pose) >= size_t{10} * kParts;
  }));
  EXPECT_GT(lost, 10u);
  std::vector<int> counts(kParts);
  for (const Event& event : listener.events)
    if (event.kind == Kind::pose) ++counts[static_cast<size_t>(std::stoi(event.text))];
  const auto [least, most] = std::ranges::minmax(counts);
  EXPECT_LE(most - least, 2) << "all parts of nearly every frame, although each frame lost three of them";
  EXPECT_EQ(rejected(listener.link->stats(), Cause::malformed), 0u);
}

TEST_P(Group, StrangersAreCountedAndHarmNobody) {
  ListenerOptions options = insecure();
  options.max_peers = 3;
  Listener listener(uri, options);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "before"));
  // Datagrams of a stranger, sent through a link of our own without a description.
  const auto parsed = parse_uri(uri);
  const bool v6 = parsed->host.find(':') != std::string::npos;
  const UniqueFd fd(::socket(v6 ? AF_INET6 : AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int interface = static_cast<int>(::if_nametoindex(OwnNetwork::interface().c_str()));
  if (v6) {
    sockaddr_in6 to{};
    to.sin6_family = AF_INET6;
    to.sin6_port = htons(parsed->port);
    to.sin6_scope_id = static_cast<uint32_t>(interface);
    ::inet_pton(AF_INET6, parsed->host.c_str(), &to.sin6_addr);
    ::setsockopt(fd.get(), IPPROTO_IPV6, IPV6_MULTICAST_IF, &interface, sizeof interface);
    ASSERT_EQ(::connect(fd.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  } else {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(parsed->port);
    ::inet_pton(AF_INET, parsed->host.c_str(), &to.sin_addr);
    ip_mreqn way{};
    way.imr_ifindex = interface;
    ::setsockopt(fd.get(), IPPROTO_IP, IP_MULTICAST_IF, &way, sizeof way);
    ASSERT_EQ(::connect(fd.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  }
  std::mt19937_64 random(6);
  for (uint32_t i = 1; i <= 3000; ++i) {
    auto bytes = random_bytes(random() % 1400, i);
    if (bytes.size() >= udp::kHeaderBytes + udp::kGroupOfferBytes && i % 4 != 0) {
      const uint64_t session = random() % 6;
      udp::write_header(bytes.data(),
                        {udp::kTransportVersion, static_cast<udp::Type>(5 + random() % 12), session, i});
      if (random() % 2 == 0) {
        udp::write_header(bytes.data(), {udp::kTransportVersion, udp::Type::group, session, i});
        udp::write_group_offer(bytes.data() + udp::kHeaderBytes, {1, 2, 1, 1200});
      } else if (random() % 2 == 0 && bytes.size() > 100) {
        udp::write_header(bytes.data(), {udp::kTransportVersion, udp::Type::fragment, session, i});
        udp::write_fragment_header(bytes.data() + udp::kHeaderBytes, {1, 0, 60'000, 60'000 * 1136u, 1});
      }
    }
    ::send(fd.get(), bytes.data(), bytes.size(), 0);
    if (i % 50 == 0) listener.poll();
  }
  ASSERT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::full) > 0; }));
  EXPECT_GT(rejected(listener.link->stats(), Cause::malformed), 100u);
  EXPECT_GT(rejected(listener.link->stats(), Cause::unknown_session), 0u);
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "after"));
  EXPECT_EQ(listener.link->stats().bytes_sent, 0u);
}

INSTANTIATE_TEST_SUITE_P(Transport, Group, testing::Values("239.255.77.3", "[ff15::f3d]"),
                         [](const auto& which) { return std::string(which.param[0] == '[' ? "v6" : "v4"); });

TEST(GroupRules, KeyPortAndConsentAreRequired) {
  const Secured secured;
  const auto listener_error = [](const std::string& uri, const ListenerOptions& options) {
    const auto opened = open_listener(uri, options);
    EXPECT_FALSE(opened.ok()) << uri;
    return opened.ok() ? std::string() : opened.error().message;
  };
  ListenerOptions insecure;
  insecure.insecure = true;
  const std::string group = "udp://239.255.77.3:7345";
  EXPECT_NE(listener_error(group, {}).find("--insecure"), std::string::npos);
  ListenerOptions keyed = secured.keyed_listener('1');
  keyed.insecure = true;
  EXPECT_NE(listener_error(group, keyed).find("cannot be sealed"), std::string::npos);
  EXPECT_NE(listener_error("udp://239.255.77.3:0", insecure).find("name one"), std::string::npos);
  EXPECT_NE(listener_error(group + "?interface=nowhere9", insecure).find("no interface 'nowhere9'"),
            std::string::npos);
  EXPECT_NE(listener_error("udp://127.0.0.1:0?ttl=3", insecure).find("multicast"), std::string::npos);
  const auto publisher = open_publisher(group, secured.keyed_publisher('1'));
  ASSERT_FALSE(publisher.ok());
  EXPECT_NE(publisher.error().message.find("cannot be sealed"), std::string::npos);
  EXPECT_FALSE(open_publisher("udp://127.0.0.1:9?interface=lo").ok());
  auto nowhere = open_publisher_or_fail(group + "?interface=nowhere9");
  EXPECT_NE(struct_error(*nowhere).find("no interface 'nowhere9'"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::transport::test
