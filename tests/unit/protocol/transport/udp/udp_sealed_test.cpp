// The parts of sealed udp:// sessions without a network: the handshakes of a listener are bounded, late
// records are dropped, publishing takes no memory.
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "protocol/transport/udp/udp_handshake.h"
#include "protocol/transport/udp/udp_poses.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/protocol/transport/udp/sealed_peers.h"

namespace fire3dv::transport::test {
namespace {

using udp::Acceptor;
using udp::Dtls;
using Datagrams = std::vector<std::vector<std::byte>>;

Address address_of(uint8_t host, uint16_t port) {
  Address address;
  sockaddr_in ipv4{};
  ipv4.sin_family = AF_INET;
  ipv4.sin_port = htons(port);
  ipv4.sin_addr.s_addr = htonl(0x0a000000u | host);
  std::memcpy(&address.storage, &ipv4, sizeof ipv4);
  address.length = sizeof ipv4;
  return address;
}

// An acceptor, and publishers that greet it.
struct Door {
  explicit Door(size_t max_pending)
      : acceptor(key_of('1'), max_pending,
                 {[this](const Address&, auto datagram) {
                    answers.emplace_back(datagram.begin(), datagram.end());
                  },
                  [this](const Address&, uint64_t, auto) { ++failed; }, [this] { ++ended; }}) {}
  Datagrams answers;
  size_t failed = 0, ended = 0, busy = 0;
  Acceptor acceptor;
  int64_t now_ns = 1'000'000'000;

  void hear(const Address& from, const Datagrams& datagrams) {
    for (const auto& datagram : datagrams) {
      const auto about = udp::inspect_records(datagram);
      const auto outcome = about.kind == RecordKind::client_hello
                               ? acceptor.client_hello(from, about, datagram, now_ns)
                               : acceptor.handshake(from, about, datagram);
      busy += outcome == Acceptor::Outcome::busy;
    }
  }
  // The publisher's flights until its ClientHello has a cookie and is heard.
  std::unique_ptr<Dtls> begin(const Address& from, char key = '1') {
    auto publisher = key_of(key)->connect();
    publisher->handshake({});
    answers.clear();
    hear(from, publisher->take_outgoing());
    for (const auto& answer : std::exchange(answers, {})) publisher->handshake(answer);
    acceptor.tick(now_ns);  // restores the time budget
    hear(from, publisher->take_outgoing());
    return publisher;
  }
  bool finish(Dtls& publisher, const Address& from) {
    for (int i = 0; i < 100 && !publisher.established() && acceptor.has(from); ++i) {
      for (const auto& answer : std::exchange(answers, {})) publisher.handshake(answer);
      acceptor.tick(now_ns);
      hear(from, publisher.take_outgoing());
    }
    return publisher.established() && acceptor.established(from) != nullptr;
  }
};

TEST(UdpSealed, HandshakeNeedsCookieAndKey) {
  Door door(4);
  const Address from = address_of(1, 1000);
  auto publisher = key_of('1')->connect();
  publisher->handshake({});
  for (int i = 0; i < 1000; ++i) {
    Datagrams hello = key_of('1')->connect()->take_outgoing();
    door.hear(address_of(1, static_cast<uint16_t>(i)), hello);
  }
  door.hear(from, publisher->take_outgoing());
  EXPECT_EQ(door.acceptor.size(), 0u) << "nothing is kept of who has not returned a cookie";
  publisher = door.begin(from);
  EXPECT_EQ(door.acceptor.size(), 1u);
  EXPECT_TRUE(door.finish(*publisher, from));
  const Address other = address_of(2, 1000);
  publisher = door.begin(other, '2');
  EXPECT_FALSE(door.finish(*publisher, other));
  EXPECT_EQ(door.failed, 1u);
  EXPECT_EQ(door.acceptor.size(), 1u);
}

TEST(UdpSealed, PendingHandshakesAreBounded) {
  Door door(8);
  const Address honest = address_of(1, 1000);
  auto publisher = door.begin(honest);
  const Datagrams flight = std::exchange(door.answers, {});
  for (uint16_t port = 1; port <= 100; ++port) {
    door.begin(address_of(2, port));
    EXPECT_LE(door.acceptor.size(), 8u);
  }
  EXPECT_EQ(door.ended, 93u) << "who opens many takes places from itself";
  ASSERT_TRUE(door.acceptor.has(honest));
  door.answers = flight;
  EXPECT_TRUE(door.finish(*publisher, honest));
  door.now_ns += 9 * kSecondNs;
  door.acceptor.tick(door.now_ns);
  EXPECT_EQ(door.acceptor.size(), 8u);
  door.now_ns += 2 * kSecondNs;
  door.acceptor.tick(door.now_ns);
  EXPECT_EQ(door.acceptor.size(), 0u) << "also one that is done, and never says hello";
}

// Offers of our ClientHello, and a listener's choice from a foreign one.
TEST(UdpSealed, OneVersionAndSuite) {
  constexpr size_t kVersionAt = 25, kSessionAt = 59;
  constexpr std::array kOurs{std::byte{0xcc}, std::byte{0xac}};
  const auto suites_at = [](const std::vector<std::byte>& hello) {
    const size_t cookie_at = kSessionAt + 1 + std::to_integer<size_t>(hello[kSessionAt]);
    return cookie_at + 1 + std::to_integer<size_t>(hello[cookie_at]);
  };
  auto publisher = key_of('1')->connect();
  publisher->handshake({});
  const std::vector<std::byte> hello = publisher->take_outgoing().at(0);
  EXPECT_EQ(hello[kVersionAt], std::byte{0xfe});
  EXPECT_EQ(hello[kVersionAt + 1], std::byte{0xfd});
  const size_t at = suites_at(hello);
  // RFC 5746: a second suite that is a sign, or, since OpenSSL 3.4, an empty extension (0xff01).
  constexpr std::array kRenegotiation{std::byte{0xff}, std::byte{0x01}, std::byte{0}, std::byte{1},
                                      std::byte{0}};
  const bool has_extension =
      std::search(hello.begin(), hello.end(), kRenegotiation.begin(), kRenegotiation.end()) != hello.end();
  EXPECT_EQ(hello[at + 1], std::byte{has_extension ? uint8_t{2} : uint8_t{4}}) << "one suite";
  EXPECT_TRUE(std::equal(kOurs.begin(), kOurs.end(), hello.begin() + static_cast<std::ptrdiff_t>(at + 2)));

  Door door(100);
  uint16_t port = 0;
  const auto refused = [&](const std::function<void(std::vector<std::byte>&)>& change) {
    const Address from = address_of(1, ++port);
    auto other = key_of('1')->connect();
    other->handshake({});
    door.hear(from, other->take_outgoing());
    for (const auto& answer : std::exchange(door.answers, {})) other->handshake(answer);
    Datagrams second = other->take_outgoing();
    change(second.at(0));
    door.failed = 0;
    door.acceptor.tick(door.now_ns);
    door.hear(from, {second[0]});
    return door.failed == 1 && !door.acceptor.has(from);
  };
  EXPECT_FALSE(refused([](auto&) {})) << "unchanged";
  // PSK, DHE_PSK and ECDHE_PSK with AES or ChaCha20; RSA and ECDHE_RSA.
  for (const unsigned suite :
       {0x00a8u, 0x00a9u, 0x00aau, 0xc035u, 0xc036u, 0xccabu, 0xccadu, 0x009cu, 0xcca8u})
    EXPECT_TRUE(refused([&](auto& changed) {
      changed[suites_at(changed) + 2] = static_cast<std::byte>(suite >> 8);
      changed[suites_at(changed) + 3] = static_cast<std::byte>(suite);
    })) << suite;
  EXPECT_TRUE(refused([&](auto& changed) { changed[kVersionAt + 1] = std::byte{0xff}; })) << "DTLS 1.0";
}

// Junk that its sender repeats for as long as it likes: each handshake hears only so much of it.
TEST(UdpSealed, HandshakeDatagramsAreBounded) {
  Door door(4);
  for (const int epoch : {0, 1}) {
    const Address from = address_of(1, static_cast<uint16_t>(1000 + epoch));
    door.begin(from);
    ASSERT_TRUE(door.acceptor.has(from));
    int heard = 0;
    for (; door.acceptor.has(from) && heard < 1000; ++heard) {
      std::vector<std::byte> junk = random_bytes(60, static_cast<uint32_t>(heard));
      const std::array<uint8_t, 13> header{
          22, 0xfe, 0xfd, 0, static_cast<uint8_t>(epoch), 0, 0, 0, 0, 1, static_cast<uint8_t>(heard), 0, 47};
      std::copy_n(std::as_bytes(std::span(header)).begin(), header.size(), junk.begin());
      junk[13] = std::byte{16};  // a ClientKeyExchange
      door.acceptor.tick(door.now_ns);
      door.hear(from, {junk});
    }
    EXPECT_LE(heard, epoch == 0 ? 33 : 9);
  }
}

// Strangers' handshakes get a share of the thread that receives, and no more.
TEST(UdpSealed, HandshakeTimeIsLimited) {
  Door door(1000);
  std::vector<std::pair<Address, Datagrams>> greetings;
  for (uint16_t port = 1; port <= 500; ++port) {
    const Address from = address_of(1, port);
    auto publisher = key_of('1')->connect();
    publisher->handshake({});
    door.hear(from, publisher->take_outgoing());
    for (const auto& answer : std::exchange(door.answers, {})) publisher->handshake(answer);
    greetings.emplace_back(from, publisher->take_outgoing());
  }
  for (const auto& [from, datagrams] : greetings) door.hear(from, datagrams);
  EXPECT_GT(door.acceptor.size(), 0u);
  EXPECT_GT(door.busy, 0u) << "500 key exchanges in 2 ms";
  const size_t begun = door.acceptor.size();
  door.acceptor.tick(door.now_ns);
  for (const auto& [from, datagrams] : greetings) door.hear(from, datagrams);
  EXPECT_GT(door.acceptor.size(), begun) << "they come again";
}

// Two ends that have shaken hands.
struct Pair {
  std::unique_ptr<Dtls> from = key_of('1')->connect(), to = key_of('1')->listen();
  Pair() {
    const Dtls::Cookies cookies{[] { return uint64_t{5}; }, [](uint64_t cookie) { return cookie == 5; }};
    bool greeted = false;
    from->handshake({});
    for (int i = 0; i < 1000 && !(from->established() && to->established()); ++i) {
      for (const auto& datagram : from->take_outgoing()) {
        if (!greeted) {
          greeted = to->check_client_hello(datagram, cookies);
          if (greeted) to->handshake({});
        } else {
          to->handshake(datagram);
        }
      }
      for (const auto& datagram : to->take_outgoing()) from->handshake(datagram);
      from->repeat_flight();
      to->repeat_flight();
    }
    EXPECT_TRUE(from->established() && to->established());
  }
  std::vector<std::byte> seal(uint64_t number) { return udp::seal_number(*from, udp::Type::pose, number); }
  Dtls::Opened open(std::vector<std::byte> datagram) {
    std::span<const std::byte> plaintext;
    return to->open(datagram, udp::inspect_records(datagram).record_number, plaintext);
  }
};

// OpenSSL's window has 64 records: one that is overtaken by 63 is taken, one that is overtaken by 64 is late.
TEST(UdpSealed, RecordBeyondWindowIsLate) {
  Pair pair;
  for (const size_t distance : {1, 8, 32, 63, 64, 65, 128, 512}) {
    Datagrams datagrams;
    for (size_t i = 0; i <= distance; ++i) datagrams.push_back(pair.seal(i));
    for (size_t i = 1; i <= distance; ++i) EXPECT_EQ(pair.open(datagrams[i]), Dtls::Opened::plaintext);
    EXPECT_EQ(pair.open(datagrams[0]), distance < 64 ? Dtls::Opened::plaintext : Dtls::Opened::repeated)
        << distance;
  }
}

// Shuffled within blocks of 64, everything arrives, and once.
TEST(UdpSealed, RecordsOpenOnceWithinWindow) {
  Pair pair;
  std::mt19937 generator(7);
  for (int block = 0; block < 50; ++block) {
    Datagrams datagrams;
    for (uint64_t i = 0; i < 64; ++i) datagrams.push_back(pair.seal(i));
    std::shuffle(datagrams.begin(), datagrams.end(), generator);
    for (const auto& datagram : datagrams) {
      auto forged = datagram;
      forged[13 + generator() % (forged.size() - 13)] ^= std::byte{4};
      EXPECT_EQ(pair.open(forged), Dtls::Opened::forged);
      EXPECT_EQ(pair.open(datagram), Dtls::Opened::plaintext);
      EXPECT_EQ(pair.open(datagram), Dtls::Opened::repeated);
    }
  }
  EXPECT_FALSE(pair.to->broken());
}

// Anything at all, sealed by nobody, in the middle of a session.
TEST(UdpSealed, RandomRecordsAreHarmless) {
  Pair pair;
  for (uint32_t i = 0; i < 20'000; ++i) {
    auto datagram = random_bytes(13 + i % 90, i);
    const size_t length = datagram.size() - 13;
    const std::array<uint8_t, 5> start{static_cast<uint8_t>(i % 2 == 0 ? 23 : 22), 0xfe, 0xfd, 0, 1};
    std::copy_n(std::as_bytes(std::span(start)).begin(), start.size(), datagram.begin());
    datagram[11] = std::byte{0};
    datagram[12] = static_cast<std::byte>(length);
    const auto about = udp::inspect_records(datagram);
    std::span<const std::byte> plaintext;
    if (about.kind == RecordKind::data) {
      EXPECT_EQ(pair.to->open(datagram, about.record_number, plaintext), Dtls::Opened::forged);
    }
    if (about.kind == RecordKind::handshake) pair.to->receive_handshake(datagram);
  }
  EXPECT_TRUE(pair.to->take_outgoing().empty());
  EXPECT_EQ(pair.open(pair.seal(1)), Dtls::Opened::plaintext);
}

// As a publisher sends poses. OpenSSL 3.5 allocates memory for each record, 3.0 does not: only what sealing
// itself takes is allowed.
TEST(UdpSealed, PublishingTakesNoMemory) {
  Pair pair, sealing;
  std::vector<std::byte> record(udp::kDatagramBytes);
  const auto seal = [&] { EXPECT_GT(sealing.from->seal(record, udp::kRecordHeaderBytes, 1000), 0u); };
  for (int i = 0; i < 10; ++i) seal();
  const uint64_t before_sealing = fire3dv::test::allocations_of_this_thread();
  for (int i = 0; i < 1000; ++i) seal();
  const uint64_t of_sealing = fire3dv::test::allocations_of_this_thread() - before_sealing;
  const auto sockets = [] {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends.data()), 0);
    return std::pair(UniqueFd(ends[0]), UniqueFd(ends[1]));
  }();
  udp::Session session(1, 0, std::move(pair.from));
  udp::PoseSender sender(udp::kDatagramBytes, udp::ParityRate(40, false));
  const std::string pose(udp::pose_bytes_of(udp::kDatagramBytes), 'p');
  const auto publish = [&] {
    udp::PoseSender::Drops drops;
    for (int part = 0; part < 5; ++part)
      EXPECT_EQ(sender.publish(sockets.first.get(), &session, message_of(pose), part == 4, 0, drops),
                udp::PoseSender::Outcome::sent);
    std::byte byte;
    while (::recv(sockets.second.get(), &byte, 1, MSG_DONTWAIT) > 0) {
    }
  };
  for (int i = 0; i < 10; ++i) publish();
  const uint64_t before = fire3dv::test::allocations_of_this_thread();
  ASSERT_GT(before, 0u) << "the counter counts nothing";
  for (int i = 0; i < 1000; ++i) publish();
  constexpr uint64_t kDatagrams = 5 + 2;  // parts and parity
  EXPECT_EQ(fire3dv::test::allocations_of_this_thread() - before, kDatagrams * of_sealing);
}

}  // namespace
}  // namespace fire3dv::transport::test
