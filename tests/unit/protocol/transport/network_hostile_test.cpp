// Security test of network listeners: arbitrary input of untrusted peers leaves a live stream intact, and
// every refusal is counted.
#include "protocol/transport/tcp/tcp_frame.h"
#include "protocol/transport/udp/udp_handshake.h"
#include "tests/unit/protocol/transport/link_fixture.h"
#include "tests/unit/protocol/transport/raw_socket.h"

namespace fire3dv::transport::test {
namespace {

// A listener with one live publisher, whose stream must survive the test.
struct Victim {
  explicit Victim(const std::string& uri, ListenerOptions options = {}) : listener(uri, options) {
    publisher = open_publisher_or_fail(listener.link->uri());
    EXPECT_TRUE(publisher->set_description(bytes_of("description")));
    EXPECT_TRUE(publish_until_seen(*publisher, listener, "before"));
    rejected_before = listener.link->stats().rejected;
  }
  void expect_alive() {
    EXPECT_TRUE(publish_until_seen(*publisher, listener, "after"));
    EXPECT_EQ(listener.count(Kind::disconnected), strangers_let_in);
  }
  uint64_t rejected() const { return listener.link->stats().rejected - rejected_before; }

  Listener listener;
  std::unique_ptr<PublisherLink> publisher;
  uint64_t rejected_before = 0;
  size_t strangers_let_in = 0;
};

const std::string kTcp = "tcp://127.0.0.1:0";
const std::string kUdp = "udp://127.0.0.1:0";

TEST(TcpHostile, RandomBytes) {
  Victim victim(kTcp);
  for (uint32_t seed = 0; seed < 50; ++seed) {
    RawSocket stranger(victim.listener.link->uri(), SOCK_STREAM);
    ASSERT_TRUE(stranger.connected());
    stranger.send(random_bytes(16 + seed * 37, seed));
    EXPECT_TRUE(stranger.closed_by_peer());
  }
  EXPECT_TRUE(victim.listener.poll_until([&] { return victim.rejected() == 50; }));
  victim.expect_alive();
  EXPECT_GE(victim.listener.count(Kind::note), 1u);
  EXPECT_LT(victim.listener.count(Kind::note), 25u) << "equal notes are counted, not repeated";
}

TEST(TcpHostile, OtherVersionIsAnsweredAndClosed) {
  Victim victim(kTcp);
  RawSocket stranger(victim.listener.link->uri(), SOCK_STREAM);
  tcp::Preface preface;
  preface.version = 99;
  stranger.send(tcp::write_preface(preface));
  const auto answer = stranger.receive();
  ASSERT_EQ(answer.size(), tcp::kPrefaceBytes);
  tcp::Preface theirs;
  ASSERT_TRUE(tcp::read_preface(std::span<const std::byte, tcp::kPrefaceBytes>(answer), theirs));
  EXPECT_EQ(theirs.version, tcp::kTransportVersion);
  EXPECT_EQ(theirs.status, tcp::PrefaceStatus::version_mismatch);
  EXPECT_TRUE(stranger.closed_by_peer());
  victim.expect_alive();
  EXPECT_TRUE(victim.listener.saw_part(Kind::note, "transport version 99"));
}

// Connects with a valid preface.
RawSocket let_in(Victim& victim) {
  RawSocket stranger(victim.listener.link->uri(), SOCK_STREAM);
  stranger.send(tcp::write_preface({}));
  EXPECT_EQ(stranger.receive().size(), tcp::kPrefaceBytes);
  ++victim.strangers_let_in;
  return stranger;
}

TEST(TcpHostile, BrokenFramesEndTheirConnection) {
  Victim victim(kTcp);
  RawSocket oversize = let_in(victim);
  oversize.send(tcp::write_frame_header(tcp::FrameKind::pose, UINT32_MAX));
  EXPECT_TRUE(oversize.closed_by_peer());
  RawSocket damaged = let_in(victim);
  auto header = tcp::write_frame_header(tcp::FrameKind::pose, 10);
  header[0] ^= std::byte{4};
  damaged.send(header);
  EXPECT_TRUE(damaged.closed_by_peer());
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.listener.count(Kind::disconnected) == 2; }));
  EXPECT_TRUE(victim.listener.saw_part(Kind::disconnected, "more than 256 MiB"));
  EXPECT_TRUE(victim.listener.saw_part(Kind::disconnected, "damaged frame header"));
  EXPECT_EQ(victim.rejected(), 2u);
  victim.expect_alive();
}

TEST(TcpHostile, ClaimedLengthTakesNoMemory) {
  Victim victim(kTcp);
  std::vector<RawSocket> strangers;
  for (int i = 0; i < 20; ++i) {
    strangers.push_back(let_in(victim));
    strangers.back().send(tcp::write_frame_header(tcp::FrameKind::pose, 255u << 20));
    strangers.back().send(random_bytes(1000, 1));
  }
  victim.strangers_let_in = 0;
  victim.expect_alive();
  std::FILE* status = std::fopen("/proc/self/statm", "r");
  unsigned long virtual_pages = 0, resident_pages = 0;
  ASSERT_EQ(std::fscanf(status, "%lu %lu", &virtual_pages, &resident_pages), 2);
  std::fclose(status);
  EXPECT_LT(resident_pages * 4096, 1000ul << 20) << "20 claims of 255 MiB";
}

TEST(TcpHostile, ControlFloodEndsOneConnection) {
  Victim victim(kTcp);
  RawSocket stranger = let_in(victim);
  std::vector<std::byte> flood;
  for (int i = 0; i < 300; ++i) {
    const auto header = tcp::write_frame_header(tcp::FrameKind::control, 0);
    flood.insert(flood.end(), header.begin(), header.end());
  }
  stranger.send(flood);
  EXPECT_TRUE(stranger.closed_by_peer());
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.listener.count(Kind::disconnected) == 1; }));
  EXPECT_TRUE(victim.listener.saw_part(Kind::disconnected, "more control messages than were read"));
  victim.expect_alive();
}

TEST(TcpHostile, SilentConnectionsAreReplaced) {
  Victim victim(kTcp);
  std::vector<RawSocket> silent;
  for (int i = 0; i < 200; ++i) silent.emplace_back(victim.listener.link->uri(), SOCK_STREAM);
  auto another = open_publisher_or_fail(victim.listener.link->uri());
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.listener.count(Kind::connected) == 2; }));
  EXPECT_TRUE(silent.front().closed_by_peer());
  victim.expect_alive();
}

TEST(TcpHostile, UnknownKindIsPassedOver) {
  Victim victim(kTcp);
  RawSocket stranger = let_in(victim);
  stranger.send(tcp::write_frame_header(static_cast<tcp::FrameKind>(77), 5));
  stranger.send(bytes_of("later"));
  stranger.send(tcp::write_frame_header(tcp::FrameKind::pose, 4));
  stranger.send(bytes_of("pose"));
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.listener.saw(Kind::pose, "pose"); }));
  EXPECT_EQ(victim.rejected(), 1u);
}

// An invalid server must not keep a publisher from finding the right one later.
TEST(TcpHostile, PublisherSurvivesNonsense) {
  std::string uri;
  {
    Listener taken(kTcp);
    uri = taken.link->uri();
  }
  auto publisher = open_publisher_or_fail(uri);
  {
    const UniqueFd server(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(parse_uri(uri)->port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    ::setsockopt(server.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ASSERT_EQ(::bind(server.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(server.get(), 5), 0);
    for (uint32_t seed = 0; seed < 3; ++seed) {
      const UniqueFd connection(::accept(server.get(), nullptr, nullptr));
      const auto nonsense = random_bytes(100, seed);
      ::send(connection.get(), nonsense.data(), nonsense.size(), MSG_NOSIGNAL);
    }
  }
  EXPECT_GE(publisher->stats().rejected, 2u);
  Listener listener(uri);
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose"));
}

// A greeting and a frame cost an attacker nothing, so only an accepted description holds a place.
TEST(Hostile, UndescribedPeersAreReplaced) {
  ListenerOptions two;
  two.max_peers = 2;
  Victim tcp(kTcp, two), udp(kUdp, two);
  for (Victim* victim : {&tcp, &udp}) victim->listener.link->accept(victim->listener.peer());
  RawSocket silent = let_in(tcp);
  silent.send(tcp::write_frame_header(tcp::FrameKind::pose, 0));
  silent.send(tcp::write_frame_header(tcp::FrameKind::control, 0));
  RawSocket stranger(udp.listener.link->uri(), SOCK_DGRAM);
  stranger.send(udp::write_hello(7, 0));
  const auto cookie = stranger.receive();
  stranger.send(udp::write_hello(7, *udp::read_number(std::span(cookie).subspan(udp::kHeaderBytes))));
  ASSERT_TRUE(udp.listener.poll_until([&] { return udp.listener.count(Kind::connected) == 2; }));
  std::byte pose[udp::kHeaderBytes + udp::kPoseHeaderBytes];
  const auto accept = stranger.receive();
  const auto session = udp::read_number(std::span(accept).subspan(udp::kHeaderBytes));
  udp::write_header(pose, {udp::kTransportVersion, udp::Type::pose, *session, 1});
  udp::write_pose_header(pose + udp::kHeaderBytes, {1, 0, true});
  stranger.send(pose);
  for (Victim* victim : {&tcp, &udp})
    ASSERT_TRUE(victim->listener.poll_until([&] { return victim->listener.saw(Kind::pose, ""); }));
  udp.strangers_let_in = 1;
  for (Victim* victim : {&tcp, &udp}) {
    auto honest = open_publisher_or_fail(victim->listener.link->uri());
    ASSERT_TRUE(honest->set_description(bytes_of("honest")));
    ASSERT_TRUE(victim->listener.poll_until([&] { return victim->listener.saw(Kind::control, "honest"); }));
    EXPECT_TRUE(victim->listener.saw_part(Kind::disconnected, "its slot was needed"));
    EXPECT_EQ(victim->listener.link->stats().rejected_by_cause[static_cast<size_t>(Cause::silent)], 1u);
    for (const Event& event : victim->listener.events)
      if (event.text == "honest") victim->listener.link->accept(event.peer);
    // Two described streams keep their places, however long they are silent.
    auto third = open_publisher_or_fail(victim->listener.link->uri());
    ASSERT_TRUE(victim->listener.poll_until([&] { return !third->problem().empty(); }));
    EXPECT_NE(third->problem().find("as many publishers as it allows"), std::string::npos);
    victim->expect_alive();
  }
}

// A hostile server in place of a renderer: excessive replies end its connection and use no memory.
TEST(TcpHostile, ExcessRepliesEndConnection) {
  const UniqueFd server(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(::bind(server.get(), reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(::listen(server.get(), 5), 0);
  ASSERT_EQ(::getsockname(server.get(), reinterpret_cast<sockaddr*>(&address), &length), 0);
  auto publisher = open_publisher_or_fail("tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  const auto reply = [&](const auto& say) {
    const UniqueFd connection(::accept(server.get(), nullptr, nullptr));
    const auto preface = tcp::write_preface({});
    ::send(connection.get(), preface.data(), preface.size(), MSG_NOSIGNAL);
    say(connection.get());
    std::byte byte;  // the publisher's bytes, then the end
    while (::recv(connection.get(), &byte, 1, 0) > 0) {
    }
  };
  reply([](int fd) {  // larger than the limit of one reply
    const auto header = tcp::write_frame_header(tcp::FrameKind::control, 200u << 20);
    ::send(fd, header.data(), header.size(), MSG_NOSIGNAL);
    const std::vector<std::byte> some(1 << 20);
    for (int i = 0; i < 200; ++i)
      if (::send(fd, some.data(), some.size(), MSG_NOSIGNAL) < 0) return;
  });
  reply([](int fd) {
    const auto header = tcp::write_frame_header(tcp::FrameKind::control, UINT32_MAX);
    ::send(fd, header.data(), header.size(), MSG_NOSIGNAL);
  });
  const LinkStats stats = publisher->stats();
  EXPECT_EQ(stats.rejected_by_cause[static_cast<size_t>(Cause::no_memory)], 1u);
  EXPECT_EQ(stats.rejected_by_cause[static_cast<size_t>(Cause::oversize)], 1u);
}

// Many whole unread replies: the oldest are dropped.
TEST(TcpHostile, UnreadRepliesAreBounded) {
  Listener listener(kTcp);
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  const std::vector<std::byte> large(3 << 20);
  for (uint64_t sent = 1; sent <= 30; ++sent) {  // one at a time: a listener buffers less than 90 MiB
    listener.link->send(listener.peer(), large);
    ASSERT_TRUE(listener.poll_until([&] { return publisher->stats().messages_received == sent; }));
  }
  EXPECT_EQ(publisher->stats().rejected_by_cause[static_cast<size_t>(Cause::unread)], 30u - 21u);
  std::vector<std::byte> message;
  size_t kept = 0;
  while (publisher->poll(message)) ++kept;
  EXPECT_EQ(kept, 21u) << "64 MiB";
}

TEST(UdpHostile, RandomDatagrams) {
  Victim victim(kUdp);
  RawSocket stranger(victim.listener.link->uri(), SOCK_DGRAM);
  for (uint32_t seed = 0; seed < 500; ++seed) {
    auto bytes = random_bytes(seed * 3, seed);
    if (seed % 2 == 0 && bytes.size() >= udp::kHeaderBytes)  // half of them with a valid header
      udp::write_header(bytes.data(), {1, static_cast<udp::Type>(seed % 16), seed, seed});
    stranger.send(bytes);
  }
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.rejected() >= 300; }));
  victim.expect_alive();
}

TEST(UdpHostile, AnswersDoNotAmplify) {
  Victim victim(kUdp);
  RawSocket stranger(victim.listener.link->uri(), SOCK_DGRAM);
  for (size_t bytes = 0; bytes <= udp::kHelloBytes; bytes += 8) {
    auto hello = udp::write_hello(1 + bytes, 0);
    for (int type = 0; type < 13; ++type) {
      hello[5] = static_cast<std::byte>(type);
      stranger.send(std::span(hello).first(bytes));
      for (auto answer = stranger.receive(bytes < udp::kHelloBytes ? 1 : 20); !answer.empty();
           answer = stranger.receive(1))
        EXPECT_LE(answer.size(), bytes);
    }
  }
  EXPECT_EQ(victim.listener.count(Kind::connected), 1u) << "nobody got in without the cookie";
  victim.expect_alive();
}

std::optional<uint64_t> number_of(const std::vector<std::byte>& answer, udp::Type type) {
  udp::Header header;
  if (!udp::read_header(answer, header) || header.type != type) return {};
  return udp::read_number(std::span(answer).subspan(udp::kHeaderBytes));
}

TEST(UdpHostile, CookieBindsAddressAndNonce) {
  Victim victim(kUdp);
  RawSocket first(victim.listener.link->uri(), SOCK_DGRAM);
  RawSocket second(victim.listener.link->uri(), SOCK_DGRAM);
  first.send(udp::write_hello(7, 0));
  const auto cookie = number_of(first.receive(), udp::Type::cookie);
  ASSERT_TRUE(cookie);
  second.send(udp::write_hello(7, *cookie));
  EXPECT_TRUE(number_of(second.receive(), udp::Type::cookie)) << "cookie requested again, not accepted";
  first.send(udp::write_hello(8, *cookie));
  EXPECT_TRUE(number_of(first.receive(), udp::Type::cookie));
  first.send(udp::write_hello(7, *cookie));
  const auto session = number_of(first.receive(), udp::Type::accept);
  ASSERT_TRUE(session);
  first.send(udp::write_hello(7, *cookie));
  EXPECT_EQ(number_of(first.receive(), udp::Type::accept), session) << "a repeated hello is the same session";
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.listener.count(Kind::connected) == 2; }));
  // The session is bound to the address that started it.
  std::byte pose[udp::kHeaderBytes + udp::kPoseHeaderBytes];
  udp::write_header(pose, {udp::kTransportVersion, udp::Type::pose, *session, 1});
  udp::write_pose_header(pose + udp::kHeaderBytes, {1, 0, true});
  second.send(pose);
  udp::Header header;
  ASSERT_TRUE(udp::read_header(second.receive(), header));
  EXPECT_EQ(header.type, udp::Type::reset);
  first.send(pose);
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.listener.saw(Kind::pose, ""); }));
  const uint64_t rejected = victim.rejected();
  first.send(pose);  // a replayed datagram
  ASSERT_TRUE(victim.listener.poll_until([&] { return victim.rejected() > rejected; }));
  size_t empty_poses = 0;
  for (const Event& event : victim.listener.events)
    empty_poses += event.kind == Kind::pose && event.text.empty();
  EXPECT_EQ(empty_poses, 1u);
  victim.expect_alive();
}

TEST(UdpHostile, AnotherVersionIsAnswered) {
  Victim victim(kUdp);
  RawSocket stranger(victim.listener.link->uri(), SOCK_DGRAM);
  auto hello = udp::write_hello(7, 0);
  hello[4] = std::byte{9};
  stranger.send(hello);
  const auto reason = number_of(stranger.receive(), udp::Type::refuse);
  EXPECT_EQ(reason, static_cast<uint64_t>(udp::Refusal::version_mismatch));
  victim.expect_alive();
  EXPECT_TRUE(victim.listener.saw_part(Kind::note, "transport version 9"));
}

// An admitted peer with damaged datagrams of every type affects only itself.
TEST(UdpHostile, AFuzzedSession) {
  Victim victim(kUdp);
  RawSocket stranger(victim.listener.link->uri(), SOCK_DGRAM);
  stranger.send(udp::write_hello(7, 0));
  const auto cookie = number_of(stranger.receive(), udp::Type::cookie);
  ASSERT_TRUE(cookie);
  stranger.send(udp::write_hello(7, *cookie));
  const auto session = number_of(stranger.receive(), udp::Type::accept);
  ASSERT_TRUE(session);
  std::mt19937_64 generator(5);
  for (uint32_t i = 1; i < 5000; ++i) {
    auto bytes = random_bytes(udp::kHeaderBytes + generator() % (1200 - udp::kHeaderBytes), i);
    const auto type = static_cast<udp::Type>(5 + generator() % 5);
    udp::write_header(bytes.data(), {udp::kTransportVersion, type, *session, i});
    if (type == udp::Type::fragment && bytes.size() > udp::kHeaderBytes + udp::kFragmentHeaderBytes) {
      udp::FragmentHeader fragment{1, static_cast<uint32_t>(generator() % 300), 60'000, 60'000 * 1136u, 1};
      if (generator() % 2 == 0)
        bytes.resize(udp::kHeaderBytes + udp::kFragmentHeaderBytes + udp::kFragmentBytes);
      udp::write_fragment_header(bytes.data() + udp::kHeaderBytes, fragment);
    }
    stranger.send(bytes);
    if (i % 50 == 0) victim.listener.poll();
  }
  victim.publisher->publish(message_of("after"));
  EXPECT_TRUE(publish_until_seen(*victim.publisher, victim.listener, "after"));
  EXPECT_GT(victim.rejected(), 0u);
}

}  // namespace
}  // namespace fire3dv::transport::test
