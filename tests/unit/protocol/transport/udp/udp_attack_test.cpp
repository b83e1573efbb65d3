// Attacks on sealed udp:// sessions: replay, downgrade, forged endings, amplification, fork. Attackers here
// read, change and write datagrams, and have no key unless the test says so.
#include <openssl/rand.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <set>
#include <tuple>

#include "base/clock.h"
#include "tests/unit/protocol/transport/udp/sealed_peers.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::transport::test {
namespace {

constexpr const char* kAnyAttackPort = "udp://127.0.0.1:0";

// State of a relay's filter is declared before the relay, whose thread ends last.

struct UdpAttack : testing::Test {
  Secured secured;
  std::unique_ptr<impair::UdpRelay> relay_to(const Listener& listener) {
    auto relay = impair::UdpRelay::open(kAnyAttackPort, listener.link->uri(), {});
    EXPECT_TRUE(relay.ok()) << relay.error().message;
    return std::move(*relay);
  }
};

// --- handshake

// The flights that a listener has sent to somebody else are of no use: each handshake has its own randoms.
TEST_F(UdpAttack, ReplayedFlightIsRefused) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  std::vector<std::byte> recorded;
  std::atomic<int> replayed{0};
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    // The answer to the ClientHello with the cookie; the cookie itself is shorter.
    if (to_target || kind_of(datagram) != RecordKind::handshake || datagram.size() < 100) return true;
    if (recorded.empty()) {
      recorded.assign(datagram.begin(), datagram.end());
    } else if (replayed == 0 && recorded.size() == datagram.size()) {
      std::copy(recorded.begin(), recorded.end(), datagram.begin());
      ++replayed;
    }
    return true;
  });
  auto first = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publish_until_seen(*first, listener, "first"));
  first.reset();
  auto second = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publish_until_seen(*second, listener, "second"));
  EXPECT_EQ(replayed, 1);
}

TEST_F(UdpAttack, PlainAcceptIsIgnored) {
  Listener listener(kAnyAttackPort);  // takes every session, unsealed
  std::atomic<int> accepts{0}, readable{0};
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    readable += text_of(datagram).find("FIND ME") != std::string::npos;
    const auto header = header_of(datagram);
    readable += to_target && header;
    if (to_target || !header || header->type != udp::Type::refuse) return true;
    datagram[5] = static_cast<std::byte>(udp::Type::accept);
    ++accepts;
    return true;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of("FIND ME: description")));
  ASSERT_TRUE(listener.poll_until([&] {
    publisher->publish(message_of("FIND ME: pose"));
    return accepts >= 2;
  }));
  EXPECT_EQ(publisher->stats().peers, 0u);
  EXPECT_EQ(readable, 0);
}

// A sender that has not seen the ClientHello does not know its random.
TEST_F(UdpAttack, OffPathRefusalIsIgnored) {
  RawListener raw;
  auto publisher = open_publisher_or_fail(raw.uri(), secured.keyed_publisher('1'));
  ASSERT_EQ(raw.receive(), RecordKind::client_hello);
  for (const uint64_t guessed : {uint64_t{0}, uint64_t{1}, udp::inspect_records(raw.datagram).nonce + 1})
    raw.send(udp::write_answer(udp::Type::refuse, guessed, udp::refusal_number(udp::Refusal::bad_key)));
  raw.accept();
  while (publisher->stats().peers == 0) ::usleep(1000);
  EXPECT_EQ(rejected(publisher->stats(), Cause::bad_key), 0u);
  // In a session nobody is refused in the open.
  raw.send(udp::write_answer(udp::Type::refuse, 1, udp::refusal_number(udp::Refusal::bad_key)));
  publisher->publish(message_of("pose"));
  while (raw.hear() != udp::Type::pose) {
    ASSERT_EQ(publisher->stats().peers, 1u);
  }
}

// Version, suites, extensions, randoms, public keys, the key's name: the last message of the handshake holds
// them.
TEST_F(UdpAttack, ChangedHandshakeMakesNoPeer) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  for (const size_t from_end : {size_t{1}, size_t{5}, size_t{40}}) {
    for (const bool of_publisher : {true, false}) {
      SCOPED_TRACE(testing::Message()
                   << from_end << (of_publisher ? " of the publisher" : " of the listener"));
      std::atomic<int> changed{0};
      auto relay = relay_to(listener);
      relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
        const RecordKind kind = kind_of(datagram);
        const bool is_flight = kind == RecordKind::client_hello || kind == RecordKind::handshake;
        if (to_target != of_publisher || !is_flight || datagram.size() < 100) return true;
        datagram[datagram.size() - from_end] ^= std::byte{1};
        ++changed;
        return true;
      });
      RawPublisher publisher(relay->uri());
      EXPECT_FALSE(publisher.shake_hands(300));
      EXPECT_GT(changed, 0);
    }
  }
  listener.poll();
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

TEST_F(UdpAttack, NobodyWithoutKeyBecomesPeer) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  RawPublisher publisher(listener.link->uri());
  publisher.key = guess_of('1');
  EXPECT_FALSE(publisher.shake_hands(300)) << "the last message does not open";
  EXPECT_GE(publisher.sent.size(), 3u) << "two ClientHellos, and what the key should have sealed";
  listener.poll();
  EXPECT_EQ(listener.count(Kind::connected), 0u);
  RawListener raw;
  auto honest = open_publisher_or_fail(raw.uri(), secured.keyed_publisher('2'));
  // Its flight ends here: a listener that does not have the key cannot write the answer.
  const auto key = guess_of('2');
  const udp::Dtls::Cookies cookies{[] { return uint64_t{5}; }, [](uint64_t) { return true; }};
  auto dtls = key->listen();
  bool greeted = false;
  for (int i = 0; i < 4; ++i) {
    if (raw.receive() == RecordKind::client_hello) {
      greeted = greeted || dtls->check_client_hello(raw.datagram, cookies);
      if (greeted) dtls->handshake({});
    } else {
      EXPECT_NE(dtls->handshake(raw.datagram), udp::Dtls::Progress::established);
    }
    for (const auto& answer : dtls->take_outgoing()) raw.send(answer);
  }
  EXPECT_TRUE(greeted);
  EXPECT_EQ(honest->stats().peers, 0u);
}

TEST_F(UdpAttack, ReplayedHelloIsRefused) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  RawPublisher publisher(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(publisher.greet());
  publisher.ping();
  EXPECT_EQ(publisher.hear(), udp::Type::pong);
  const auto with_cookie =
      std::find_if(publisher.sent.begin(), publisher.sent.end(),
                   [](const auto& datagram) { return udp::inspect_records(datagram).has_cookie; });
  ASSERT_NE(with_cookie, publisher.sent.end());
  const std::vector<std::byte> hello = *with_cookie;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(publisher.socket.send(hello));
  publisher.ping();
  EXPECT_EQ(publisher.hear(), udp::Type::pong) << "the session goes on, and nothing else was answered";
  EXPECT_EQ(rejected(listener.link->stats(), Cause::replayed), 100u);
  RawSocket elsewhere(listener.link->uri(), SOCK_DGRAM);
  ASSERT_TRUE(elsewhere.send(hello));
  EXPECT_EQ(elsewhere.receive().size(), 36u) << "a cookie is of one address";
  listener.poll();
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  // When the session is over, a handshake begins that only the key can end.
  publisher.session->emit_bare(udp::Type::bye, [&](auto datagram) { publisher.socket.send(datagram); });
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  for (const auto& datagram : publisher.sent) ASSERT_TRUE(publisher.socket.send(datagram));
  publisher.ping();
  ASSERT_TRUE(
      listener.poll_until([&] { return rejected(listener.link->stats(), Cause::unknown_session) > 0; }));
  EXPECT_EQ(listener.count(Kind::connected), 1u);
}

// RFC 6347, 4.2.8: a forged greeting must not end the session of its address.
TEST_F(UdpAttack, SessionEndsOnlyWithKey) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  RawPublisher publisher(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(publisher.greet());
  publisher.key = guess_of('1');
  EXPECT_FALSE(publisher.shake_hands(300));
  publisher.key = key_of('3');
  EXPECT_FALSE(publisher.shake_hands()) << "refused, since the key has another name";
  publisher.ping();
  EXPECT_EQ(publisher.hear(), udp::Type::pong) << "the session goes on";
  publisher.key = key_of('1');
  ASSERT_TRUE(publisher.shake_hands());
  publisher.ping();
  EXPECT_EQ(publisher.hear(), udp::Type::pong) << "until the new one has said hello";
  ASSERT_EQ(publisher.say_hello().type, udp::Type::accept);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 2; }));
  EXPECT_TRUE(listener.saw_part(Kind::disconnected, "was restarted"));
  EXPECT_EQ(listener.link->stats().peers, 1u);
}

TEST_F(UdpAttack, ForeignAddressIsIgnored) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  RawPublisher publisher(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(publisher.greet());
  publisher.ping();
  EXPECT_EQ(publisher.hear(), udp::Type::pong);
  RawSocket elsewhere(listener.link->uri(), SOCK_DGRAM);
  for (const udp::Type type : {udp::Type::bye, udp::Type::ping}) {
    publisher.session->emit_bare(type, [&](auto datagram) { EXPECT_TRUE(elsewhere.send(datagram)); });
    const auto answer = elsewhere.receive();
    ASSERT_TRUE(header_of(answer));
    EXPECT_EQ(header_of(answer)->type, udp::Type::reset);
    EXPECT_LT(answer.size(), 30u) << "shorter than the question";
  }
  publisher.ping();
  EXPECT_EQ(publisher.hear(), udp::Type::pong) << "the session goes on";
  listener.poll();
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
}

TEST_F(UdpAttack, PeersAreLimited) {
  ListenerOptions options = secured.keyed_listener('1');
  options.max_peers = 1;
  Listener listener(kAnyAttackPort, options);
  RawPublisher first(listener.link->uri()), second(listener.link->uri());
  ASSERT_TRUE(first.shake_hands());
  ASSERT_TRUE(second.shake_hands()) << "nobody has said hello yet";
  EXPECT_EQ(first.say_hello().type, udp::Type::accept);
  EXPECT_EQ(first.say_hello().type, udp::Type::accept) << "the answer may be lost";
  const udp::SealedNumber answer = second.say_hello();
  EXPECT_EQ(answer.type, udp::Type::refuse);
  EXPECT_EQ(answer.number, udp::refusal_number(udp::Refusal::full));
  listener.poll();
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.link->stats().peers, 1u);
  EXPECT_EQ(rejected(listener.link->stats(), Cause::full), 1u);
}

TEST_F(UdpAttack, InvalidParametersAreRefused) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  struct Case {
    udp::Parameters parameters;
    uint64_t refusal;
  };
  for (const auto& [parameters, refusal] :
       {Case{{2, 1, 1200}, udp::refusal_number(udp::Refusal::version_mismatch)},
        Case{{1, 0, 1200}, udp::refusal_number(udp::Refusal::version_mismatch)},
        Case{{1, 1, 575}, udp::refusal_number(udp::Refusal::datagram_bytes, 9000)},
        Case{{1, 1, 9001}, udp::refusal_number(udp::Refusal::datagram_bytes, 9000)}}) {
    RawPublisher publisher(listener.link->uri());
    ASSERT_TRUE(publisher.shake_hands());
    const udp::SealedNumber answer = publisher.say_hello(parameters);
    EXPECT_EQ(answer.type, udp::Type::refuse);
    EXPECT_EQ(answer.number, refusal);
  }
  listener.poll();
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

// Each of both sides' flights is lost once, and comes again.
TEST_F(UdpAttack, ALostFlightIsRepeated) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  std::set<std::pair<bool, size_t>> lost;
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    // Flights differ in length; the hello and its answer are 38 bytes.
    if (kind_of(datagram) == RecordKind::data && datagram.size() != 38) return true;
    return !lost.emplace(to_target, datagram.size()).second;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  EXPECT_EQ(listener.count(Kind::connected), 1u);
}

// Requests of each kind from an unproved address: no answer is longer than its request.
TEST_F(UdpAttack, AnswersDoNotAmplify) {
  const auto client = key_of('1')->connect();
  client->handshake({});
  const std::vector<std::byte> client_hello = client->take_outgoing().at(0);
  for (const bool keyed : {false, true}) {
    Listener listener(kAnyAttackPort, keyed ? secured.keyed_listener('1') : ListenerOptions());
    RawSocket socket(listener.link->uri(), SOCK_DGRAM);
    const udp::Hello hello = udp::write_hello(9, 0);
    const auto ask = [&](std::span<const std::byte> question) {
      ASSERT_TRUE(socket.send(question));
      // Answers keep their order: the cookie for this hello says that the question was dealt with.
      ASSERT_TRUE(socket.send(hello));
      size_t answers = 0;
      for (auto answer = socket.receive(); !header_of(answer) || header_of(answer)->session != 9;
           answer = socket.receive()) {
        ASSERT_FALSE(answer.empty());
        EXPECT_LE(answer.size(), question.size());
        ++answers;
      }
      EXPECT_LE(answers, 1u);
    };
    for (int type = 0; type < 32; ++type) {
      for (const size_t bytes : {size_t{24}, size_t{25}, size_t{255}, size_t{256}, size_t{1200}}) {
        for (const uint8_t version : {udp::kTransportVersion, uint8_t{2}}) {
          SCOPED_TRACE(testing::Message() << type << " " << int{version} << " " << bytes);
          std::vector<std::byte> question(bytes);
          udp::write_header(question.data(), {version, static_cast<udp::Type>(type), 1234, 1});
          ask(question);
        }
        for (const int epoch : {0, 1}) {
          SCOPED_TRACE(testing::Message() << "record " << type << " of epoch " << epoch << ", " << bytes);
          std::vector<std::byte> question(bytes);
          question[0] = static_cast<std::byte>(type);
          question[1] = std::byte{0xfe};
          question[2] = std::byte{0xfd};
          question[4] = static_cast<std::byte>(epoch);
          question[11] = static_cast<std::byte>((bytes - 13) >> 8);
          question[12] = static_cast<std::byte>(bytes - 13);
          ask(question);
        }
      }
    }
    ask(client_hello);
    // The shortest that is heard: nothing behind its cookie. Its lengths are in its headers three times.
    for (size_t bytes = 13; bytes < client_hello.size(); ++bytes) {
      std::vector<std::byte> cut(client_hello.begin(),
                                 client_hello.begin() + static_cast<std::ptrdiff_t>(bytes));
      cut[11] = std::byte{0};
      cut[12] = static_cast<std::byte>(bytes - 13);
      for (const size_t at : {size_t{14}, size_t{22}}) {
        if (bytes < 25) break;
        cut[at] = cut[at + 1] = std::byte{0};
        cut[at + 2] = static_cast<std::byte>(bytes - 25);
      }
      ask(cut);
    }
    EXPECT_LE(listener.link->stats().bytes_sent, listener.link->stats().bytes_received);
    EXPECT_EQ(listener.link->stats().peers, 0u);
  }
}

// --- sessions

TEST_F(UdpAttack, RecordNumbersAreUnique) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  std::mutex mutex;
  std::set<std::pair<bool, uint64_t>> numbers;
  size_t datagrams = 0;
  auto relay = relay_to(listener);
  relay->set_filter([&](bool to_target, std::span<std::byte> datagram) {
    const auto about = udp::inspect_records(datagram);
    if (about.kind != RecordKind::data) return true;
    const std::lock_guard lock(mutex);
    ++datagrams;
    EXPECT_TRUE(numbers.emplace(to_target, about.record_number).second) << about.record_number;
    return true;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of(std::string(200'000, 'd'))));
  // Poses leave on this thread, everything else on the link's.
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  for (uint64_t i = 0; i < 200; ++i) {
    ASSERT_TRUE(publisher->put_state(i, std::make_shared<const wire::Bytes>(100)));
    publisher->publish(message_of("more"));
  }
  listener.link->send(listener.peer(), bytes_of(std::string(50'000, 'r')));
  ASSERT_TRUE(poll_until_reply(*publisher, std::string(50'000, 'r')));
  EXPECT_EQ(listener.count(Kind::connected), 1u) << "one session";
  EXPECT_EQ(rejected(listener.link->stats(), Cause::bad_key), 0u) << "two threads sealed concurrently";
  const std::lock_guard lock(mutex);
  EXPECT_GT(datagrams, 400u);
  EXPECT_EQ(numbers.size(), datagrams);
}

// Alerts of DTLS, in the open and not, fatal and not: nobody heeds them.
TEST_F(UdpAttack, ForgedAlertsEndNothing) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
  std::atomic<int> forged{0};
  auto relay = relay_to(listener);
  // Each fourth datagram of both directions becomes an alert with its record number, handshakes included.
  relay->set_filter([&, number = 0](bool, std::span<std::byte> datagram) mutable {
    if (++number % 4 != 0 || kind_of(datagram) == RecordKind::none) return true;
    datagram[0] = std::byte{21};
    const size_t length = datagram.size() - udp::kRecordHeaderBytes;
    datagram[11] = static_cast<std::byte>(length >> 8);
    datagram[12] = static_cast<std::byte>(length);
    datagram[13] = std::byte{2};   // fatal
    datagram[14] = std::byte{40};  // handshake failure
    ++forged;
    return true;
  });
  auto publisher = open_publisher_or_fail(relay->uri(), secured.keyed_publisher('1'));
  ASSERT_TRUE(publisher->set_description(bytes_of(std::string(100'000, 'd'))));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  EXPECT_GT(forged, 20);
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  RawPublisher raw(listener.link->uri());
  ASSERT_NO_FATAL_FAILURE(raw.greet());
  for (const uint8_t level : {1, 2}) {
    for (int what = 0; what < 256; ++what) {
      const std::array<uint8_t, 15> alert{21,
                                          0xfe,
                                          0xfd,
                                          0,
                                          0,
                                          0,
                                          0,
                                          0,
                                          0,
                                          1,
                                          static_cast<uint8_t>(what),
                                          0,
                                          2,
                                          level,
                                          static_cast<uint8_t>(what)};
      ASSERT_TRUE(raw.socket.send(std::as_bytes(std::span(alert))));
    }
    raw.ping();
    EXPECT_EQ(raw.hear(), udp::Type::pong);
  }
  listener.poll();
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
}

// A port that is closed for a moment, or a forged ICMP error: the listener is probed, and the session
// continues.
TEST_F(UdpAttack, IcmpErrorKeepsSession) {
  RawListener raw;
  auto publisher = open_publisher_or_fail(raw.uri(), secured.keyed_publisher('1'));
  for (int attempt = 0; attempt < 20; ++attempt) {
    publisher->publish(message_of("first"));
    raw.accept();
    while (raw.hear() != udp::Type::pose) {
    }
    raw.fd = UniqueFd();
    // The first is refused, which the next one learns.
    for (int i = 0; i < 3; ++i) publisher->publish(message_of("nobody listens"));
    raw.fd = std::move(RawListener(raw.port).fd);
    raw.emit(udp::Type::pong);
    int of_session = 0;
    for (udp::Type type = raw.hear(); type != udp::Type::hello && of_session < 20; type = raw.hear()) {
      ++of_session;
      publisher->publish(message_of("here again"));
    }
    if (of_session == 20) return;  // else this test was held up for longer than a doubt takes
  }
  FAIL() << "each session ended";
}

// A restarted listener answers each ping by a reset.
TEST_F(UdpAttack, ResetsAreRateLimited) {
  RawListener raw;
  auto publisher = open_publisher_or_fail(raw.uri(), secured.keyed_publisher('1'));
  raw.accept();
  std::byte reset[udp::kHeaderBytes];
  udp::write_header(reset, {udp::kTransportVersion, udp::Type::reset, 17, 0});
  int pings = 0;
  raw.send(reset);
  for (udp::Type type = raw.hear(); type != udp::Type::hello; type = raw.hear()) {
    pings += type == udp::Type::ping;
    for (int i = 0; i < 10; ++i) raw.send(reset);
  }
  EXPECT_GE(pings, 1) << "the key holder is probed";
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
    Listener listener(kAnyAttackPort, keyed ? secured.keyed_listener('1') : ListenerOptions());
    auto publisher = open_publisher_or_fail(listener.link->uri(),
                                            keyed ? secured.keyed_publisher('1') : PublisherOptions());
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
    EXPECT_EQ(rejected(listener.link->stats(), Cause::replayed), 0u) << "a record number came twice";
    EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  }
}

TEST_F(UdpAttack, ForkedChildPublishesNothing) {
  auto publisher = open_publisher_or_fail("udp://239.255.11.7:7399");
  EXPECT_TRUE(publisher->publish(message_of("of the parent"))) << "kept, if it cannot be sent";
  EXPECT_EQ(in_child([&] { return publisher->publish(message_of("of the child")) ? 1 : 0; }), 0);
}

// The handshake's randoms and secrets are OpenSSL's.
TEST_F(UdpAttack, RandomsDifferInForkedChild) {
  using Random = std::array<unsigned char, 32>;
  const auto make_random = [] {
    Random random{};
    EXPECT_EQ(::RAND_bytes(random.data(), static_cast<int>(random.size())), 1);
    return random;
  };
  make_random();  // the child inherits the state of a generator
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const UniqueFd out(ends[0]), in(ends[1]);
  ASSERT_EQ(in_child([&] {
              const Random random = make_random();
              return ::write(in.get(), random.data(), random.size()) == sizeof random ? 0 : 1;
            }),
            0);
  Random childs;
  ASSERT_EQ(::read(out.get(), childs.data(), childs.size()), static_cast<ssize_t>(sizeof childs));
  std::set<Random> randoms{childs};
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(randoms.insert(make_random()).second);
}

// --- scene edits

// One record that is no message makes its bundle damaged: nothing of it is handed on, and the peer ends once.
TEST_F(UdpAttack, EmptyBundleEndsSender) {
  Listener listener(kAnyAttackPort, secured.keyed_listener('1'));
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
    const auto about = udp::inspect_records(answer);
    if (about.kind != RecordKind::data) continue;
    udp::Type type{};
    std::span<const std::byte> payload;
    ASSERT_EQ(publisher.session->open(about, answer, monotonic_ns(), type, payload),
              udp::Session::Received::payload);
    if (type == udp::Type::state_ack) publisher.session->control(type, payload, SIZE_MAX, monotonic_ns());
  }
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  EXPECT_TRUE(listener.saw_part(Kind::disconnected, "damaged bundle"));
  EXPECT_EQ(listener.count(Kind::control), 0u) << "131,072 empty records";
  EXPECT_EQ(rejected(listener.link->stats(), Cause::malformed), 1u);
  EXPECT_GT(datagrams, 900u);
}

}  // namespace
}  // namespace fire3dv::transport::test
