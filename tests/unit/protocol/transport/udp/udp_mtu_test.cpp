// udp:// with ?mtu=: datagrams of other lengths than the usual one, agreed upon and kept to.
#include <atomic>

#include "protocol/transport/udp/udp_handshake.h"
#include "tests/unit/protocol/transport/raw_socket.h"
#include "tests/unit/protocol/transport/secure_fixture.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::transport::test {
namespace {

struct UdpMtu : testing::TestWithParam<bool> {
  Secured secured;
  ListenerOptions listener_options() const {
    return GetParam() ? secured.keyed_listener('1') : ListenerOptions();
  }
  PublisherOptions publisher_options() const {
    return GetParam() ? secured.keyed_publisher('1') : PublisherOptions();
  }
};

// Datagram lengths that the relay has seen.
struct Lengths {
  std::atomic<size_t> longest_out{0}, longest_back{0};
  void see(bool to_target, size_t bytes) {
    std::atomic<size_t>& longest = to_target ? longest_out : longest_back;
    if (bytes > longest) longest = bytes;
  }
};

TEST_P(UdpMtu, PublishersMtuIsKept) {
  for (const size_t mtu : {size_t{576}, size_t{1200}, size_t{8952}, size_t{9000}}) {
    SCOPED_TRACE(mtu);
    Listener listener("udp://127.0.0.1:0", listener_options());
    auto relay = std::move(*impair::UdpRelay::open("udp://127.0.0.1:0", listener.link->uri(), {}));
    Lengths lengths;
    relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
      lengths.see(to_target, datagram.size());
      return true;
    });
    auto publisher =
        open_publisher_or_fail(relay->uri() + "?mtu=" + std::to_string(mtu), publisher_options());
    const std::string description(50'000, 'd'), reply(40'000, 'r');
    ASSERT_TRUE(publisher->set_description(bytes_of(description)));
    const std::string pose(publisher->max_pose_message_bytes(), 'p');
    EXPECT_GT(pose.size() + 64, mtu);
    ASSERT_TRUE(publish_until_seen(*publisher, listener, pose));
    EXPECT_EQ(listener.last(Kind::control), description);
    listener.link->send(listener.peer(), bytes_of(reply));
    ASSERT_TRUE(poll_until_reply(*publisher, reply));
    EXPECT_LE(lengths.longest_out, mtu);
    EXPECT_LE(lengths.longest_back, mtu);
    // The room for header and tag; of a sealed datagram, whose header is shorter, 10 bytes are left.
    const size_t room = udp::kHeaderBytes + udp::kTagBytes;
    EXPECT_GE(lengths.longest_out,
              mtu - room + (GetParam() ? 1 + udp::kRecordOverheadBytes : udp::kHeaderBytes));
    EXPECT_FALSE(publisher->publish(message_of(pose + "x"))) << "longer than fits";
  }
}

TEST_P(UdpMtu, LargerMtuIsRefusedOnBothSides) {
  Listener listener("udp://127.0.0.1:0?mtu=1000", listener_options());
  EXPECT_TRUE(listener.link->uri().ends_with("?mtu=1000")) << "who copies this address gets in";
  const std::string bare = listener.link->uri().substr(0, listener.link->uri().find('?'));
  for (const char* options : {"", "?mtu=1001"}) {
    auto publisher = open_publisher_or_fail(bare + options, publisher_options());
    EXPECT_NE(struct_error(*publisher).find("at most 1000 bytes"), std::string::npos) << publisher->problem();
    EXPECT_GT(rejected(publisher->stats(), Cause::oversize), 0u);
  }
  EXPECT_TRUE(
      listener.poll_until([&] { return listener.saw_part(Kind::note, "at most 1000 are taken here"); }));
  EXPECT_GT(rejected(listener.link->stats(), Cause::oversize), 1u);
  EXPECT_EQ(listener.count(Kind::connected), 0u);
  auto publisher = open_publisher_or_fail(listener.link->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose"));
}

// A path that drops longer datagrams without a word, while short ones pass: handshakes and pings.
TEST_P(UdpMtu, ShorterDatagramsAreTriedInBlackHoles) {
  Listener listener("udp://127.0.0.1:0", listener_options());
  impair::Impairment impairment;
  impairment.mtu = 600;
  auto relay = std::move(*impair::UdpRelay::open("udp://127.0.0.1:0", listener.link->uri(), impairment));
  auto publisher = open_publisher_or_fail(relay->uri() + "?mtu=9000", publisher_options());
  const std::string description(20'000, 'd');
  ASSERT_TRUE(publisher->set_description(bytes_of(description)));
  ASSERT_TRUE(listener.poll_until([&] {
    publisher->publish(
        message_of(std::string(std::min<size_t>(publisher->max_pose_message_bytes(), 1000), 'p')));
    return listener.saw(Kind::control, description) && listener.saw_part(Kind::pose, "ppp");
  }));
  EXPECT_LT(publisher->max_pose_message_bytes(), 576u);
  EXPECT_TRUE(listener.saw_part(Kind::note, "bytes from 127.0.0.1"));
  EXPECT_TRUE(listener.saw_part(Kind::note, "(?mtu=576 in its URI begins with them)"));
}

// Losses alone shorten nothing.
TEST_P(UdpMtu, LossyPathsKeepTheirDatagrams) {
  Listener listener("udp://127.0.0.1:0", listener_options());
  impair::Impairment impairment;
  impairment.loss = 0.1;
  auto relay = std::move(*impair::UdpRelay::open("udp://127.0.0.1:0", listener.link->uri(), impairment));
  auto publisher = open_publisher_or_fail(relay->uri(), publisher_options());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  const std::string pose(publisher->max_pose_message_bytes(), 'p');
  for (int i = 0; i < 300; ++i) {
    publisher->publish(message_of(pose));
    ::usleep(10'000);
    listener.poll();
  }
  EXPECT_EQ(publisher->max_pose_message_bytes(), pose.size());
  EXPECT_EQ(listener.count(Kind::connected), 1u);
}

INSTANTIATE_TEST_SUITE_P(Transport, UdpMtu, testing::Bool(),
                         [](const auto& which) { return std::string(which.param ? "sealed" : "open"); });

// Lengths that no publisher of ours would name, and datagrams that are longer than was said.
TEST(UdpMtuHostile, InvalidLengthsAreDropped) {
  Listener listener("udp://127.0.0.1:0");
  RawSocket stranger(listener.link->uri(), SOCK_DGRAM);
  const auto greet = [&](uint64_t nonce, uint16_t datagram_bytes) {
    udp::Header header;
    stranger.send(udp::write_hello(nonce, 0, datagram_bytes));
    const auto asked = stranger.receive();
    const auto cookie = udp::read_number(std::span(asked).subspan(udp::kHeaderBytes));
    stranger.send(udp::write_hello(nonce, *cookie, datagram_bytes));
    const auto answer = stranger.receive();
    EXPECT_TRUE(udp::read_header(answer, header));
    const auto number = udp::read_number(std::span(answer).subspan(udp::kHeaderBytes));
    return std::pair(header.type, *number);
  };
  for (const uint16_t wild : {1, 24, 575, 9001, 65535}) {
    const auto [type, number] = greet(wild, wild);
    EXPECT_EQ(type, udp::Type::refuse) << wild;
    EXPECT_EQ(number, 9000u << 16 | static_cast<uint64_t>(udp::Refusal::datagram_bytes));
  }
  EXPECT_EQ(rejected(listener.link->stats(), Cause::oversize), 5u);
  const auto [type, session] = greet(7, 576);
  ASSERT_EQ(type, udp::Type::accept);
  std::vector<std::byte> pose(577);
  udp::write_header(pose.data(), {udp::kTransportVersion, udp::Type::pose, session, 1});
  udp::write_pose_header(pose.data() + udp::kHeaderBytes, {1, 0, true});
  stranger.send(pose);
  ASSERT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::oversize) == 6; }));
  pose.pop_back();
  stranger.send(pose);
  EXPECT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) == 1; }));
}

}  // namespace
}  // namespace fire3dv::transport::test
