// udp:// with a pre-shared key: who is let in, and what an attacker on the way can do: lose datagrams, and
// nothing else.
#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <utility>

#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/transport/udp/udp_record.h"
#include "protocol/transport/udp/udp_session.h"
#include "tests/unit/protocol/transport/raw_socket.h"
#include "tests/unit/protocol/transport/secure_fixture.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::transport::test {
namespace {

constexpr const char* kAnyPort = "udp://127.0.0.1:0";

struct UdpKey : testing::Test {
  Secured secured;
  std::unique_ptr<impair::UdpRelay> relay_to(const Listener& listener,
                                             const impair::Impairment& impairment = {}) {
    auto relay = impair::UdpRelay::open(kAnyPort, listener.link->uri(), impairment);
    EXPECT_TRUE(relay.ok()) << relay.error().message;
    return std::move(*relay);
  }
  static bool is_sealed(std::span<const std::byte> datagram) {
    return udp::inspect_records(datagram).kind == udp::RecordDatagram::Kind::data;
  }
};

TEST_F(UdpKey, WrongKeyIsReportedOnBothSides) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  auto publisher = open_publisher_or_fail(listener.link->uri(), secured.keyed_publisher('2'));
  publisher->publish(message_of("pose"));
  EXPECT_NE(struct_error(*publisher).find("another key"), std::string::npos) << publisher->problem();
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw_part(Kind::note, "it has another key"); }));
  EXPECT_GT(rejected(listener.link->stats(), Cause::bad_key), 0u);
  EXPECT_EQ(listener.count(Kind::connected), 0u);
  for (const Event& event : listener.events) EXPECT_EQ(event.text.find("1111"), std::string::npos) << "a key";
  EXPECT_EQ(publisher->problem().find("2222"), std::string::npos) << "a key";
}

TEST_F(UdpKey, NoKeyIsRefused) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  auto publisher = open_publisher_or_fail(listener.link->uri());
  EXPECT_NE(struct_error(*publisher).find("requires a key"), std::string::npos) << publisher->problem();
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw_part(Kind::note, "it has no key"); }));
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

TEST_F(UdpKey, KeyedPublisherNeedsKeyedListener) {
  Listener listener(kAnyPort);
  auto publisher = open_publisher_or_fail(listener.link->uri(), secured.keyed_publisher('1'));
  EXPECT_NE(struct_error(*publisher).find("another key or none"), std::string::npos) << publisher->problem();
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

TEST_F(UdpKey, MessagesAreEncrypted) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  auto relay = relay_to(listener);
  std::atomic<int> readable{0}, seen{0};
  relay->set_filter([&](bool, std::span<std::byte> datagram) {
    ++seen;
    readable += text_of(datagram).find("FIND ME") != std::string::npos;
    return true;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of("FIND ME: description")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "FIND ME: pose"));
  listener.link->send(listener.peer(), bytes_of("FIND ME: reply"));
  ASSERT_TRUE(poll_until_reply(*publisher, "FIND ME: reply"));
  EXPECT_GT(seen, 8);
  EXPECT_EQ(readable, 0);
}

TEST_F(UdpKey, FlippedBitsAreCounted) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  auto relay = relay_to(listener);
  std::atomic<uint32_t> number{0}, flipped{0};
  relay->set_filter([&](bool, std::span<std::byte> datagram) {
    const uint32_t n = ++number;
    if (!is_sealed(datagram) || n % 3 != 0) return true;
    // In the record's number or behind its header: type, version and length lead elsewhere.
    const size_t place = n * 7 % (datagram.size() - 7);
    const size_t at = place < 6 ? 5 + place : 7 + place;
    datagram[at] ^= static_cast<std::byte>(1 << (n % 8));
    ++flipped;
    return true;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  std::string large(300'000, ' ');
  for (size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>('a' + i * i % 26);
  ASSERT_TRUE(publisher->set_description(bytes_of(large)));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  EXPECT_EQ(listener.last(Kind::control), large);
  for (const Event& event : listener.events) EXPECT_TRUE(event.kind != Kind::pose || event.text == "pose");
  EXPECT_GT(flipped, 10u);
  EXPECT_GT(rejected(listener.link->stats(), Cause::bad_key), 10u);
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
}

TEST_F(UdpKey, WhatIsReplayedIsDropped) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  impair::Impairment twice;
  twice.duplicate = 1;
  auto relay = relay_to(listener, twice);
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  ASSERT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::replayed) > 3; }));
  EXPECT_EQ(listener.count(Kind::control), 1u);
  EXPECT_EQ(listener.count(Kind::connected), 1u);
}

// Ping and pong have the same length: the publisher's own sealed datagram comes back to it instead of the
// answer.
TEST_F(UdpKey, ReflectedDatagramsAreForgeries) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  std::vector<std::byte> ping;  // outlives the relay, whose thread writes it
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    if (to_target && datagram.size() == udp::kDatagramBytes) return false;  // long pings: short ones follow
    if (!is_sealed(datagram) || datagram.size() != 1 + udp::kRecordOverheadBytes) return true;
    if (to_target) ping.assign(datagram.begin(), datagram.end());
    if (!to_target && ping.size() == datagram.size()) std::copy(ping.begin(), ping.end(), datagram.begin());
    return true;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  EXPECT_TRUE(listener.poll_until([&] { return rejected(publisher->stats(), Cause::bad_key) > 0; }));
  EXPECT_EQ(publisher->stats().peers, 1u);
}

// Anyone can write the two words of a reset. A sealed session probes the key holder.
TEST_F(UdpKey, ForgedResetKeepsSession) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  auto relay = relay_to(listener);
  std::atomic<int> forged{0};
  relay->set_filter([&, accepted = false](bool to_target, std::span<std::byte> datagram) mutable {
    const size_t bytes = datagram.size() - udp::kRecordOverheadBytes - 1;
    if (to_target || !is_sealed(datagram) || (bytes != 8 && bytes != udp::kHaveBytes))
      return true;  // accept, have
    if (!std::exchange(accepted, true)) return true;
    udp::write_header(datagram.data(), {udp::kTransportVersion, udp::Type::reset, 0, 0});
    ++forged;
    return true;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  publisher->publish(message_of("pose"));
  ASSERT_TRUE(listener.poll_until([&] { return forged >= 8; }));
  EXPECT_EQ(publisher->stats().peers, 1u);
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
}

// Datagrams and records that nobody of ours wrote: no peer, no crash, all of them counted.
TEST_F(UdpKey, RandomDatagramsAreCounted) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  RawSocket socket(listener.link->uri(), SOCK_DGRAM);
  std::mt19937 generator(5);
  uint64_t sent = 0;
  for (uint32_t i = 0; i < 2000; ++i) {
    std::vector<std::byte> datagram = random_bytes(generator() % 1300, i);
    if (datagram.size() >= udp::kHeaderBytes)
      udp::write_header(datagram.data(), {udp::kTransportVersion,
                                          static_cast<udp::Type>(2 + generator() % 14), generator(), i});
    if (i % 3 == 0 && datagram.size() >= udp::kRecordHeaderBytes) {
      const size_t length = datagram.size() - udp::kRecordHeaderBytes;
      const std::array<uint8_t, 3> start{static_cast<uint8_t>(19 + generator() % 6), 0xfe, 0xfd};
      std::copy_n(std::as_bytes(std::span(start)).begin(), 3, datagram.begin());
      datagram[3] = std::byte{0};
      datagram[4] = static_cast<std::byte>(generator() % 3);
      datagram[11] = static_cast<std::byte>(length >> 8);
      datagram[12] = static_cast<std::byte>(length);
    }
    sent += socket.send(datagram);
    if (i % 100 != 99) continue;  // a pause, so that none is lost for lack of room
    ASSERT_TRUE(listener.poll_until([&] { return listener.link->stats().rejected == sent; })) << sent;
  }
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

TEST_F(UdpKey, InvalidKeyFilesAreNamed) {
  const auto error_of = [](const std::string& file) {
    ListenerOptions options;
    options.key_file = file;
    const auto opened = open_listener(kAnyPort, options);
    EXPECT_FALSE(opened.ok());
    return opened.ok() ? std::string() : opened.error().message;
  };
  const auto& credentials = secured.credentials;
  const std::string key(64, '7');
  EXPECT_NE(error_of(credentials.file("open", key, 0644)).find("chmod 600"), std::string::npos);
  EXPECT_NE(error_of(credentials.file("group", key, 0620)).find("chmod 600"), std::string::npos);
  EXPECT_NE(error_of(credentials.file("short", key.substr(1), 0600)).find("64 hexadecimal digits"),
            std::string::npos);
  EXPECT_NE(error_of(credentials.file("long", std::string(70'000, '7'), 0600)).find("64 KiB"),
            std::string::npos);
  EXPECT_NE(error_of("/dev/null").find("not a regular file"), std::string::npos);
  EXPECT_NE(error_of("/nowhere").find("cannot be read"), std::string::npos);
  for (const char* name : {"open", "short"})
    EXPECT_EQ(error_of(credentials.file(name, key.substr(name[0] == 's'), name[0] == 's' ? 0600 : 0644))
                  .find("7777"),
              std::string::npos)
        << "a key in an error";
  EXPECT_FALSE(open_publisher("udp://127.0.0.1:9",
                              [&] {
                                PublisherOptions options;
                                options.key_file = credentials.file("open", key, 0644);
                                return options;
                              }())
                   .ok());
}

TEST_F(UdpKey, OtherAddressesNeedNoInsecure) {
  EXPECT_TRUE(open_listener("udp://0.0.0.0:0", secured.keyed_listener('1')).ok());
  EXPECT_FALSE(open_listener("udp://0.0.0.0:0").ok());
}

}  // namespace
}  // namespace fire3dv::transport::test
