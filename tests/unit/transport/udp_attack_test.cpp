// Attacks on sealed udp:// sessions: replay, downgrade, forged endings, amplification, fork. Attackers here
// read, change and write datagrams, and have no key unless the test says so.
#include <sys/wait.h>

#include <atomic>
#include <mutex>
#include <set>
#include <tuple>

#include "protocol/transport/clock.h"
#include "protocol/transport/udp_handshake.h"
#include "protocol/transport/udp_session.h"
#include "tests/unit/transport/raw_socket.h"
#include "tests/unit/transport/secure_fixture.h"
#include "tools/impair/udp_relay.h"

namespace fire3dv::transport::test {
namespace {

constexpr const char* kAnyPort = "udp://127.0.0.1:0";

// The key that Secured writes to a file of this digit.
udp::PreSharedKey key_of(char digit) {
  return udp::PreSharedKey(Secret(std::vector<std::byte>(32, static_cast<std::byte>((digit - '0') * 0x11))));
}

udp::Header header_of(std::span<const std::byte> datagram) {
  udp::Header header;
  EXPECT_TRUE(udp::read_header(datagram, header));
  return header;
}

// What a relay's filter uses has to be declared before the relay, whose thread ends last.

// A publisher that sends only what a test tells it to.
struct RawPublisher {
  explicit RawPublisher(const std::string& uri) : socket(uri, SOCK_DGRAM) {}
  RawSocket socket;
  udp::PreSharedKey key = key_of('1');
  uint64_t nonce = 77;
  udp::Random random = udp::make_random();
  udp::Hello hello{};  // the one with the cookie
  std::unique_ptr<udp::Session> session;

  udp::Header ask(std::span<const std::byte> question, std::vector<std::byte>& answer) {
    EXPECT_TRUE(socket.send(question));
    answer = socket.receive();
    return header_of(answer);
  }
  void greet() {
    std::vector<std::byte> answer;
    ASSERT_EQ(ask(udp::write_hello(nonce, 0, random, &key), answer).type, udp::Type::cookie);
    const auto cookie = udp::read_number(std::span(answer).subspan(udp::kHeaderBytes));
    hello = udp::write_hello(nonce, *cookie, random, &key);
    ASSERT_EQ(ask(hello, answer).type, udp::Type::accept);
    const auto accept = udp::read_accept(answer, random, &key);
    ASSERT_TRUE(accept);
    session = std::make_unique<udp::Session>(
        accept->session, 0,
        key.make_seal(udp::PreSharedKey::Side::publisher, accept->session, random, accept->random));
  }
  void ping() {
    session->emit_bare(udp::Type::ping, [&](auto datagram) { EXPECT_TRUE(socket.send(datagram)); });
  }
};

// A listener that sends only what a test tells it to.
struct RawListener {
  explicit RawListener(uint16_t at_port = 0) : fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(at_port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(fd.get(), reinterpret_cast<sockaddr*>(&address), length), 0);
    ::getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &length);
    port = ntohs(address.sin_port);
  }
  UniqueFd fd;
  uint16_t port = 0;
  sockaddr_in from{};
  std::vector<std::byte> datagram;

  std::string uri() const { return "udp://127.0.0.1:" + std::to_string(port); }
  udp::Header receive() {
    datagram.resize(udp::kMaxDatagramBytes);
    pollfd polled{fd.get(), POLLIN, 0};
    EXPECT_EQ(::poll(&polled, 1, 60'000), 1);
    socklen_t length = sizeof from;
    const ssize_t got = ::recvfrom(fd.get(), datagram.data(), datagram.size(), 0,
                                   reinterpret_cast<sockaddr*>(&from), &length);
    datagram.resize(got > 0 ? static_cast<size_t>(got) : 0);
    return header_of(datagram);
  }
  void send(std::span<const std::byte> bytes) const {
    ::sendto(fd.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&from), sizeof from);
  }
  // Accepts the next publisher with the key '1'.
  std::unique_ptr<udp::Session> accept(uint64_t id) {
    const udp::PreSharedKey key = key_of('1');
    while (true) {
      const udp::Header header = receive();
      if (header.type != udp::Type::hello) continue;
      const udp::HelloFields fields = udp::read_hello(datagram);
      if (fields.cookie == 0) {
        send(udp::write_answer(udp::Type::cookie, header.session, 5));
        continue;
      }
      const udp::Random random = udp::make_random();
      send(udp::write_accept(header.session, id, fields.random, random, &key));
      return std::make_unique<udp::Session>(
          id, 0, key.make_seal(udp::PreSharedKey::Side::listener, id, fields.random, random));
    }
  }
};

struct UdpAttack : testing::Test {
  Secured secured;
  std::unique_ptr<impair::UdpRelay> relay_to(const Listener& listener) {
    auto relay = impair::UdpRelay::open(kAnyPort, listener.link->uri(), {});
    EXPECT_TRUE(relay.ok()) << relay.error().message;
    return std::move(*relay);
  }
};

// --- handshake

TEST_F(UdpAttack, AReplayedAcceptIsRefused) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  std::vector<std::byte> recorded;
  std::atomic<int> replayed{0};
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    udp::Header header;
    if (to_target || !udp::read_header(datagram, header) || header.type != udp::Type::accept) return true;
    if (recorded.empty()) {
      recorded.assign(datagram.begin(), datagram.end());
    } else if (replayed < 3) {
      std::copy(recorded.begin(), recorded.end(), datagram.begin());
      // Once as it was, then for the publisher's new nonce.
      if (replayed++ != 0) udp::write_header(datagram.data(), header);
    }
    return true;
  });
  auto first = must_open_publisher(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publish_until_seen(*first, listener, "first"));
  first.reset();
  auto second = must_open_publisher(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publish_until_seen(*second, listener, "second"));
  EXPECT_EQ(replayed, 3);
}

TEST_F(UdpAttack, AnAcceptWithoutAProofDoesNotUnsealAPublisher) {
  Listener listener(kAnyPort);  // takes every session, unsealed
  std::atomic<int> accepts{0}, readable{0};
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    udp::Header header;
    if (!udp::read_header(datagram, header)) return true;
    readable += text_of(datagram).find("FIND ME") != std::string::npos;
    if (to_target && header.type == udp::Type::hello) datagram[udp::kHeaderBytes + 8] = std::byte{0};
    accepts += !to_target && header.type == udp::Type::accept;
    return true;
  });
  auto publisher = must_open_publisher(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of("FIND ME: description")));
  ASSERT_TRUE(listener.poll_until([&] {
    publisher->publish(message_of("FIND ME: pose"));
    return accepts >= 2 && rejected(publisher->stats(), Cause::bad_key) >= 2;
  }));
  EXPECT_EQ(publisher->stats().peers, 0u);
  EXPECT_EQ(readable, 0);
}

TEST_F(UdpAttack, AChangedLengthOfDatagramsIsNoProof) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  std::atomic<int> changed{0};
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    udp::Header header;
    if (!to_target || !udp::read_header(datagram, header) || header.type != udp::Type::hello) return true;
    datagram[udp::kHeaderBytes + 11] = std::byte{2};  // D = 744, and not 1000
    ++changed;
    return true;
  });
  auto publisher = must_open_publisher(relay->uri() + "?mtu=1000", secured.keyed_publisher('1'));
  ASSERT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::bad_key) > 0; }));
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

TEST_F(UdpAttack, AReplayedHelloMakesNoPeerAndNoNewSession) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  RawPublisher publisher(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(publisher.greet());
  publisher.ping();
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 1; }));
  EXPECT_EQ(header_of(publisher.socket.receive()).type, udp::Type::pong);
  for (int i = 0; i < 100; ++i) {
    std::vector<std::byte> answer;
    ASSERT_EQ(publisher.ask(publisher.hello, answer).type, udp::Type::accept);
    const auto accept = udp::read_accept(answer, publisher.random, &publisher.key);
    ASSERT_TRUE(accept);
    EXPECT_EQ(accept->session, publisher.session->id()) << "the session that is there";
  }
  RawSocket elsewhere(listener.link->uri(), SOCK_DGRAM);
  ASSERT_TRUE(elsewhere.send(publisher.hello));
  EXPECT_EQ(header_of(elsewhere.receive()).type, udp::Type::cookie) << "a cookie is of one address";
  listener.poll();
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
}

TEST_F(UdpAttack, AnotherAddressDoesNotTakeASessionOver) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  RawPublisher publisher(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(publisher.greet());
  publisher.ping();
  EXPECT_EQ(header_of(publisher.socket.receive()).type, udp::Type::pong);
  RawSocket elsewhere(listener.link->uri(), SOCK_DGRAM);
  for (const udp::Type type : {udp::Type::bye, udp::Type::ping})
    publisher.session->emit_bare(type, [&](auto datagram) { EXPECT_TRUE(elsewhere.send(datagram)); });
  EXPECT_EQ(header_of(elsewhere.receive()).type, udp::Type::reset);
  publisher.ping();
  EXPECT_EQ(header_of(publisher.socket.receive()).type, udp::Type::pong) << "the session goes on";
  listener.poll();
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
}

TEST_F(UdpAttack, NoMorePeersThanAllowedHoweverTheirSessionsBegin) {
  ListenerOptions options = secured.keyed_listener('1');
  options.max_peers = 1;
  Listener listener(kAnyPort, options);
  RawPublisher first(listener.link->uri()), second(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(first.greet());
  ASSERT_NO_FATAL_FAILURE(second.greet()) << "nobody has shown a seal yet";
  first.ping();
  EXPECT_EQ(header_of(first.socket.receive()).type, udp::Type::pong);
  second.ping();
  EXPECT_EQ(header_of(second.socket.receive()).type, udp::Type::bye);
  listener.poll();
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.link->stats().peers, 1u);
  EXPECT_EQ(rejected(listener.link->stats(), Cause::full), 1u);
}

// A question of each kind from an address that has proved nothing; whatever the answer is, it is not longer.
TEST_F(UdpAttack, NoAnswerIsLongerThanItsQuestion) {
  for (const bool keyed : {false, true}) {
    Listener listener(kAnyPort, keyed ? secured.keyed_listener('1') : ListenerOptions());
    RawSocket socket(listener.link->uri(), SOCK_DGRAM);
    const udp::Hello hello = udp::write_hello(9, 0);
    for (int type = 0; type < 32; ++type) {
      for (const uint8_t version : {udp::kTransportVersion, uint8_t{2}}) {
        for (const size_t bytes : {size_t{24}, size_t{25}, size_t{255}, size_t{256}, size_t{1200}}) {
          SCOPED_TRACE(testing::Message() << type << " " << int{version} << " " << bytes);
          std::vector<std::byte> question(bytes);
          udp::write_header(question.data(), {version, static_cast<udp::Type>(type), 1234, 1});
          ASSERT_TRUE(socket.send(question));
          // Answers keep their order: the cookie for this hello says that the question was dealt with.
          ASSERT_TRUE(socket.send(hello));
          size_t answers = 0;
          for (auto answer = socket.receive(); header_of(answer).session != 9; answer = socket.receive()) {
            EXPECT_LE(answer.size(), bytes);
            ++answers;
          }
          EXPECT_LE(answers, 1u);
        }
      }
    }
    EXPECT_LE(listener.link->stats().bytes_sent, listener.link->stats().bytes_received);
    EXPECT_EQ(listener.link->stats().peers, 0u);
  }
}

// --- sessions

TEST_F(UdpAttack, NoCounterIsSealedTwice) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  std::mutex mutex;
  std::set<std::tuple<bool, uint64_t, uint64_t>> counters;
  size_t datagrams = 0;
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    udp::Header header;
    if (!udp::read_header(datagram, header) || header.type <= udp::Type::refuse) return true;
    if (header.type == udp::Type::reset) return true;
    const std::lock_guard lock(mutex);
    ++datagrams;
    EXPECT_TRUE(counters.emplace(to_target, header.session, header.counter).second) << header.counter;
    return true;
  });
  auto publisher = must_open_publisher(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of(std::string(200'000, 'd'))));
  // Poses leave on this thread, everything else on the link's.
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  for (uint64_t i = 0; i < 200; ++i) {
    ASSERT_TRUE(publisher->put_state(i, std::make_shared<const wire::Bytes>(100)));
    publisher->publish(message_of("more"));
  }
  listener.link->send(listener.peer(), bytes_of(std::string(50'000, 'r')));
  ASSERT_TRUE(poll_until_reply(*publisher, std::string(50'000, 'r')));
  const std::lock_guard lock(mutex);
  EXPECT_GT(datagrams, 400u);
  EXPECT_EQ(counters.size(), datagrams);
}

// A port that is closed for a moment, or a forged ICMP error: the listener is asked, and the session goes on.
TEST_F(UdpAttack, AnIcmpErrorDoesNotEndASealedSession) {
  RawListener raw;
  auto publisher = must_open_publisher(raw.uri(), secured.keyed_publisher('1'));
  for (uint64_t id = 1; id <= 20; ++id) {
    publisher->publish(message_of("first"));
    auto session = raw.accept(id);
    while (raw.receive().type != udp::Type::pose) {
    }
    raw.fd = UniqueFd();
    // The first is refused, which the next one learns.
    for (int i = 0; i < 3; ++i) publisher->publish(message_of("nobody listens"));
    const sockaddr_in from = raw.from;
    raw = RawListener(raw.port);
    raw.from = from;
    session->emit_bare(udp::Type::pong, [&](auto datagram) { raw.send(datagram); });
    int of_session = 0;
    udp::Header header = raw.receive();
    for (; header.type != udp::Type::hello && of_session < 20; header = raw.receive()) {
      ++of_session;
      publisher->publish(message_of("here again"));
    }
    if (of_session == 20) return;  // else this test was held up for longer than a doubt takes
  }
  FAIL() << "each session ended";
}

// A listener that was started anew answers each ping by a reset.
TEST_F(UdpAttack, ResetsAreNotAnsweredOneByOne) {
  RawListener raw;
  auto publisher = must_open_publisher(raw.uri(), secured.keyed_publisher('1'));
  raw.accept(17);
  std::byte reset[udp::kHeaderBytes];
  udp::write_header(reset, {udp::kTransportVersion, udp::Type::reset, 17, 0});
  int pings = 0;
  raw.send(reset);
  for (udp::Header header = raw.receive(); header.type != udp::Type::hello; header = raw.receive()) {
    pings += header.type == udp::Type::ping;
    for (int i = 0; i < 10; ++i) raw.send(reset);
  }
  EXPECT_GE(pings, 1) << "who has the key is asked";
  EXPECT_LE(pings, 10);
}

// --- fork

// Runs `body` in a forked child; its result.
int in_child(const std::function<int()>& body) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(body());
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(UdpAttack, AForkedChildSealsNothing) {
  for (const bool keyed : {false, true}) {
    Listener listener(kAnyPort, keyed ? secured.keyed_listener('1') : ListenerOptions());
    auto publisher =
        must_open_publisher(listener.link->uri(), keyed ? secured.keyed_publisher('1') : PublisherOptions());
    ASSERT_TRUE(publish_until_seen(*publisher, listener, "before"));
    EXPECT_EQ(in_child([&] {
                int sent = 0;
                for (int i = 0; i < 100; ++i) sent += publisher->publish(message_of("of the child"));
                const wire::MessagePieces whole = message_of("whole, of the child");
                sent += publisher->publish_partial(message_of("some"), {&whole, 1});
                publisher->send_control(bytes_of("control of the child"));
                std::vector<std::byte> reply;
                sent += publisher->poll(reply);
                sent += publisher->set_description(bytes_of("d")).ok();
                sent += publisher->put_state(1, std::make_shared<const wire::Bytes>(100)).ok();
                sent += publisher->problem().find("before fork()") == std::string::npos;
                publisher.reset();
                return sent;
              }),
              0);
    ASSERT_TRUE(publish_until_seen(*publisher, listener, "after"));
    EXPECT_FALSE(listener.saw_part(Kind::pose, "child"));
    EXPECT_FALSE(listener.saw_part(Kind::control, "child"));
    EXPECT_EQ(rejected(listener.link->stats(), Cause::replayed), 0u) << "a counter came twice";
    EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  }
}

TEST_F(UdpAttack, AForkedChildPublishesToNoGroup) {
  auto publisher = must_open_publisher("udp://239.255.11.7:7399");
  EXPECT_TRUE(publisher->publish(message_of("of the parent"))) << "kept, if it cannot be sent";
  EXPECT_EQ(in_child([&] { return publisher->publish(message_of("of the child")) ? 1 : 0; }), 0);
}

TEST_F(UdpAttack, RandomsDifferInAForkedChild) {
  udp::make_random();  // whatever a generator may keep, the child inherits
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const UniqueFd out(ends[0]), in(ends[1]);
  ASSERT_EQ(in_child([&] {
              const udp::Random random = udp::make_random();
              return ::write(in.get(), random.data(), random.size()) == sizeof random ? 0 : 1;
            }),
            0);
  udp::Random childs;
  ASSERT_EQ(::read(out.get(), childs.data(), childs.size()), static_cast<ssize_t>(sizeof childs));
  std::set<udp::Random> randoms{childs};
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(randoms.insert(udp::make_random()).second);
}

// --- scene edits

// One record that is no message makes its bundle damaged: nothing of it is handed on, and the peer ends once.
TEST_F(UdpAttack, ABundleOfEmptyStatesEndsItsSenderOnce) {
  Listener listener(kAnyPort, secured.keyed_listener('1'));
  RawPublisher publisher(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(publisher.greet());
  publisher.session->state_sender().push(udp::ControlSender::prepare(std::vector<std::byte>(1 << 20)),
                                         SIZE_MAX);
  size_t datagrams = 0;
  while (publisher.session->state_sender().waiting_messages() != 0) {
    publisher.session->emit_due(monotonic_ns(), [&](auto datagram) {
      EXPECT_TRUE(publisher.socket.send(datagram));
      ++datagrams;
    });
    listener.poll();
    if (listener.count(Kind::disconnected) != 0) break;
    auto answer = publisher.socket.receive(10);
    if (answer.empty()) continue;
    const udp::Header header = header_of(answer);
    std::span<const std::byte> payload;
    if (header.type != udp::Type::state_ack) continue;
    ASSERT_EQ(publisher.session->hear(header, answer, monotonic_ns(), payload), udp::Session::Heard::payload);
    publisher.session->control(header, payload, SIZE_MAX, monotonic_ns());
  }
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  EXPECT_TRUE(listener.saw_part(Kind::disconnected, "damaged bundle"));
  EXPECT_EQ(listener.count(Kind::control), 0u) << "131,072 empty records";
  EXPECT_EQ(rejected(listener.link->stats(), Cause::malformed), 1u);
  EXPECT_GT(datagrams, 900u);
}

}  // namespace
}  // namespace fire3dv::transport::test
