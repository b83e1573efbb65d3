// Multicast groups: whoever joins, whenever, learns all there is to know, and sends nothing.
#include "protocol/transport/udp_group.h"

#include <net/if.h>

#include <algorithm>
#include <random>

#include "protocol/transport/udp_group_publisher.h"
#include "protocol/transport/udp_group_socket.h"
#include "tests/unit/transport/own_network.h"
#include "tests/unit/transport/raw_socket.h"
#include "tests/unit/transport/secure_fixture.h"

namespace fire3dv::transport::test {
namespace {

using udp::Carousel;
using udp::CarouselReceiver;
using udp::ControlSender;
using udp::GroupOffer;
using udp::kDatagramBytes;

ControlSender::Prepared prepared(std::string_view text) {
  return ControlSender::prepare(bytes_of(text));
}

// One round to a receiver, through a network that loses some of it.
std::vector<std::string> round_to(Carousel& carousel, CarouselReceiver& receiver, double loss,
                                  std::mt19937& random, size_t skip = 0, uint32_t* gone = nullptr) {
  std::vector<std::string> got;
  carousel.start_round();
  std::uniform_real_distribution<double> draw(0, 1);
  if (draw(random) >= loss) {
    const uint32_t lapped = receiver.offered(carousel.offer());
    if (gone != nullptr) *gone += lapped;
  }
  for (auto fragment = carousel.next(); fragment; fragment = carousel.next()) {
    if (skip > 0 && skip-- > 0) continue;
    if (draw(random) < loss) continue;
    EXPECT_NE(receiver.fragment(fragment->header, fragment->data, SIZE_MAX),
              CarouselReceiver::Outcome::corrupt);
    while (auto message = receiver.take()) got.push_back(text_of(*message));
  }
  return got;
}

TEST(Carousel, AJoinerGetsAllInOrderWhateverTheLoss) {
  std::mt19937 random(3);
  Carousel carousel(kDatagramBytes);
  const std::string description(20'000, 'd');
  carousel.describe(prepared(description));
  std::vector<std::string> sent{description};
  for (const size_t bytes : {0, 1, 5000, 1136}) {
    sent.push_back(std::string(bytes, 'a') + std::to_string(bytes));
    EXPECT_TRUE(carousel.add(prepared(sent.back())));
  }
  for (const double loss : {0.0, 0.3, 0.7}) {
    CarouselReceiver receiver(udp::fragment_bytes_of(kDatagramBytes));
    std::vector<std::string> got;
    for (int round = 0; round < 200 && got.size() < sent.size(); ++round)
      for (auto& message : round_to(carousel, receiver, loss, random, round == 0 ? 7 : 0))
        got.push_back(message);
    EXPECT_EQ(got, sent) << loss;
    EXPECT_TRUE(round_to(carousel, receiver, 0, random).empty()) << "once each";
    EXPECT_EQ(receiver.held_bytes(), 0u);
  }
}

TEST(Carousel, ANewDescriptionReplacesAllBeforeIt) {
  std::mt19937 random(4);
  Carousel carousel(kDatagramBytes);
  CarouselReceiver receiver(udp::fragment_bytes_of(kDatagramBytes));
  carousel.describe(prepared("first"));
  carousel.add(prepared("of the first"));
  EXPECT_EQ(round_to(carousel, receiver, 0, random).size(), 2u);
  const GroupOffer late = carousel.offer();
  carousel.describe(prepared("second"));
  EXPECT_EQ(round_to(carousel, receiver, 0, random), std::vector<std::string>{"second"});
  receiver.offered(late);  // late on its way
  carousel.add(prepared("of the second"));
  EXPECT_EQ(round_to(carousel, receiver, 0, random), std::vector<std::string>{"of the second"});
}

TEST(Carousel, WhatIsTooMuchToRepeatGoesAndIsCounted) {
  std::mt19937 random(5);
  Carousel carousel(kDatagramBytes);
  CarouselReceiver early(udp::fragment_bytes_of(kDatagramBytes)), late = early;
  carousel.describe(prepared("d"));
  carousel.add(prepared("1"));
  EXPECT_EQ(round_to(carousel, early, 0, random).size(), 2u);
  bool all_kept = true;
  for (int i = 2; i <= 20'000; ++i) all_kept &= carousel.add(prepared(std::to_string(i)));
  EXPECT_FALSE(all_kept);
  for (CarouselReceiver* receiver : {&early, &late}) {
    uint32_t gone = 0;
    std::vector<std::string> got;
    for (int round = 0; round < 2; ++round)  // a joiner learns what is gone once it is described
      for (auto& message : round_to(carousel, *receiver, 0, random, 0, &gone)) got.push_back(message);
    EXPECT_EQ(got.back(), "20000");
    if (receiver == &early) {
      EXPECT_EQ(gone + got.size(), 19'999u);
      EXPECT_GT(gone, 1000u);
    } else {
      EXPECT_EQ(gone, 0u) << "of before it joined";
    }
  }
  // By bytes, too.
  Carousel heavy(kDatagramBytes);
  const std::string large(3 << 20, 'l');
  heavy.describe(prepared(large));
  EXPECT_TRUE(heavy.add(prepared(large))) << "the description does not count";
  EXPECT_FALSE(heavy.add(prepared(large)));
  EXPECT_EQ(heavy.offer().first, heavy.offer().last);
}

TEST(Carousel, OfEachKeyTheNewestIsRepeatedForEver) {
  std::mt19937 random(7);
  Carousel carousel(kDatagramBytes);
  CarouselReceiver early(udp::fragment_bytes_of(kDatagramBytes));
  carousel.describe(prepared("d"));
  const std::string large(5000, 'x');
  EXPECT_TRUE(carousel.put(1, prepared("still")));
  EXPECT_TRUE(carousel.put(2, prepared(large)));
  round_to(carousel, early, 0.5, random);  // in the middle of a message that is replaced
  std::string newest;
  for (int i = 0; i < 20'000; ++i) {
    newest = large + std::to_string(i);
    EXPECT_TRUE(carousel.put(2, prepared(newest)));
    if (i % 400 == 0) round_to(carousel, early, 0.3, random);
  }
  EXPECT_LT(carousel.offer().last - carousel.offer().first, udp::kMostGroupMessages);
  CarouselReceiver late(udp::fragment_bytes_of(kDatagramBytes));
  for (CarouselReceiver* receiver : {&early, &late}) {
    std::vector<std::string> got;
    for (int round = 0; round < 2; ++round)
      for (auto& message : round_to(carousel, *receiver, 0, random)) got.push_back(message);
    EXPECT_EQ(std::count(got.begin(), got.end(), newest), 1);
    if (receiver == &early) continue;
    EXPECT_EQ(std::count(got.begin(), got.end(), "still"), 1);
    EXPECT_EQ(got.size(), 3u);
  }
  for (uint64_t key = 3; key < 3 + 4094; ++key) EXPECT_TRUE(carousel.put(key, prepared("s")));
  EXPECT_FALSE(carousel.put(9999, prepared("one too many")));
  EXPECT_TRUE(carousel.put(3, prepared("again")));
}

TEST(Carousel, WhoJoinsGetsStatesInTheOrderInWhichTheyWerePut) {
  std::mt19937 random(13);
  Carousel carousel(kDatagramBytes);
  carousel.describe(prepared("d"));
  EXPECT_TRUE(carousel.put(1, prepared("000001 lens")));
  EXPECT_TRUE(carousel.put(2, prepared("000002 added")));
  for (int version = 3; version < 30'000; ++version) {
    char text[32];
    std::snprintf(text, sizeof text, "%06d", version);
    EXPECT_TRUE(carousel.put(version == 4001 ? 3 : version % 7 == 0 ? 4 : 5, prepared(text)));
    if (version % 1500 != 0) continue;
    carousel.start_round();
    CarouselReceiver late(udp::fragment_bytes_of(kDatagramBytes));
    std::vector<std::string> got;
    for (int round = 0; round < 2; ++round)
      for (auto& message : round_to(carousel, late, 0, random)) got.push_back(message);
    EXPECT_TRUE(std::is_sorted(got.begin() + 1, got.end())) << version;
    for (const char* state : {"000001 lens", "000002 added"})
      EXPECT_EQ(std::count(got.begin(), got.end(), state), 1) << version;
    EXPECT_EQ(std::count(got.begin(), got.end(), "004001"), version > 4001) << version;
    EXPECT_LT(carousel.offer().last - carousel.offer().first, 300u) << "rounds stay short";
  }
}

TEST(Carousel, AKeyThatChangesFasterThanItIsSentIsSeenToChange) {
  std::mt19937 random(11);
  Carousel carousel(kDatagramBytes);
  CarouselReceiver receiver(udp::fragment_bytes_of(kDatagramBytes));
  carousel.describe(prepared("d"));
  std::vector<std::string> got;
  const auto hear = [&](const udp::ControlSender::Fragment& fragment) {
    receiver.fragment(fragment.header, fragment.data, 1 << 20);
    while (auto message = receiver.take())
      got.emplace_back(reinterpret_cast<const char*>(message->data()), message->size());
  };
  const std::string large(20000, 'x');
  for (int i = 0; i < 200; ++i) {
    EXPECT_TRUE(carousel.put(1, prepared(large + std::to_string(i))));
    receiver.offered(carousel.offer());
    for (int piece = 0; piece < 5; ++piece)  // of some twenty
      if (const auto fragment = carousel.next()) hear(*fragment);
    if (carousel.round_is_over()) carousel.start_round();
  }
  ASSERT_GE(got.size(), 20u);
  EXPECT_EQ(std::adjacent_find(got.begin() + 1, got.end(),
                               [](const auto& earlier, const auto& later) { return later == earlier; }),
            got.end());
  for (auto& message : round_to(carousel, receiver, 0, random)) got.push_back(message);
  for (auto& message : round_to(carousel, receiver, 0, random)) got.push_back(message);
  EXPECT_EQ(got.back(), large + "199");
}

TEST(Carousel, NumbersBeginAnewBeforeTheyRunOut) {
  constexpr uint32_t kMostNumbers = 500;
  std::mt19937 random(17);
  Carousel carousel(kDatagramBytes, kMostNumbers);
  CarouselReceiver receiver(udp::fragment_bytes_of(kDatagramBytes));
  carousel.describe(prepared("d"));
  EXPECT_TRUE(carousel.put(1, prepared("still")));
  EXPECT_TRUE(carousel.add(prepared("said once")));
  const std::string large(5000, 'x');
  int sessions = 1;
  std::vector<std::string> got;
  for (int i = 0; i < 3000; ++i) {
    EXPECT_TRUE(carousel.put(2, prepared(large + std::to_string(i))));
    if (carousel.take_begun_anew()) {
      ++sessions;
      EXPECT_EQ(carousel.offer().description, 1u);
      receiver = CarouselReceiver(udp::fragment_bytes_of(kDatagramBytes));
      got.clear();
    }
    EXPECT_LE(carousel.offer().last, kMostNumbers + 1);
    if (i % 100 == 0)
      for (auto& message : round_to(carousel, receiver, 0.2, random)) got.push_back(message);
    carousel.next();  // anew in the middle of a message, too
  }
  EXPECT_GE(sessions, 6);
  for (int round = 0; round < 2; ++round)
    for (auto& message : round_to(carousel, receiver, 0, random)) got.push_back(message);
  EXPECT_EQ(got.front(), "d");
  EXPECT_EQ(got.back(), large + "2999");
  for (const char* once : {"d", "still", "said once"}) EXPECT_EQ(std::count(got.begin(), got.end(), once), 1);
}

TEST(Carousel, WhoContradictsItselfIsCorruptAndMemoryIsBounded) {
  using Outcome = CarouselReceiver::Outcome;
  constexpr size_t kPiece = udp::fragment_bytes_of(kDatagramBytes);
  const std::vector<std::byte> piece(kPiece);
  const udp::FragmentHeader sound{1, 0, 3, static_cast<uint32_t>(2 * kPiece + 5), 9};
  const auto fresh = [] {
    CarouselReceiver receiver(kPiece);
    receiver.offered({1, 2, 1, kDatagramBytes});
    return receiver;
  };
  EXPECT_EQ(CarouselReceiver(kPiece).fragment(sound, piece, SIZE_MAX), Outcome::ignored)
      << "nothing was offered";
  EXPECT_EQ(fresh().fragment(sound, piece, SIZE_MAX), Outcome::kept);
  EXPECT_EQ(fresh().fragment(sound, piece, kPiece), Outcome::ignored) << "over the budget";
  for (const auto spoil :
       {+[](udp::FragmentHeader& h) { h.count = 4; }, +[](udp::FragmentHeader& h) { h.index = 2; },
        +[](udp::FragmentHeader& h) { h.index = 3; },
        +[](udp::FragmentHeader& h) { h.message_bytes = UINT32_MAX; }}) {
    udp::FragmentHeader bad = sound;
    spoil(bad);
    EXPECT_EQ(fresh().fragment(bad, piece, SIZE_MAX), Outcome::corrupt);
  }
  CarouselReceiver receiver = fresh();
  ASSERT_EQ(receiver.fragment(sound, piece, SIZE_MAX), Outcome::kept);
  udp::FragmentHeader other = sound;
  other.index = 1;
  other.hash = 8;
  EXPECT_EQ(receiver.fragment(other, piece, SIZE_MAX), Outcome::corrupt) << "another hash";
  other = sound;
  other.index = 1;
  ASSERT_EQ(receiver.fragment(other, piece, SIZE_MAX), Outcome::kept);
  other.index = 2;
  EXPECT_EQ(receiver.fragment(other, std::span(piece).first(5), SIZE_MAX), Outcome::corrupt)
      << "the wrong hash";
  udp::FragmentHeader far = sound;
  far.message = 1'000'000;
  EXPECT_EQ(fresh().fragment(far, piece, SIZE_MAX), Outcome::ignored);
  GroupOffer offer;
  std::byte bytes[udp::kGroupOfferBytes];
  for (const GroupOffer& bad :
       {GroupOffer{1, 1, 1, 1200}, GroupOffer{1, 5, 3, 1200}, GroupOffer{1, 2, 20000, 1200},
        GroupOffer{1, 2, 1, 575}, GroupOffer{1, 2, 1, 9001}, GroupOffer{1, 0, UINT32_MAX, 1200}}) {
    udp::write_group_offer(bytes, bad);
    EXPECT_FALSE(udp::read_group_offer(bytes, offer)) << bad.first << " " << bad.last;
  }
  EXPECT_FALSE(udp::read_group_offer(std::span(bytes).first(15), offer));
}

// --- over an interface

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

TEST_P(Group, EveryListenerGetsEverythingWhenItJoinsAndNothingIsSentBack) {
  Listener early(uri, insecure());
  auto publisher = must_open_publisher(uri);
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

TEST_P(Group, WhoeverJoinsGetsTheNewestOfEachKey) {
  const auto shared = [](std::string_view text) {
    const auto bytes = bytes_of(text);
    return std::make_shared<const wire::Bytes>(bytes.begin(), bytes.end());
  };
  Listener early(uri, insecure());
  auto publisher = must_open_publisher(uri);
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

TEST_P(Group, APublisherWhoseNumbersAreUsedUpGoesOnAsAnotherPeer) {
  constexpr uint32_t kMostNumbers = 40;
  Listener listener(uri, insecure());
  const auto parsed = parse_uri(uri);
  ASSERT_TRUE(parsed.ok());
  auto made = udp::make_group_publisher(*parsed, *udp::group_of(*parsed), {}, kMostNumbers);
  ASSERT_TRUE(made.ok()) << made.error().message;
  PublisherLink& publisher = **made;
  ASSERT_TRUE(publisher.set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(publisher, listener, "before"));
  const auto newest = bytes_of("newest"), older = bytes_of("older");
  for (uint32_t i = 0; i < 2 * kMostNumbers; ++i)
    ASSERT_TRUE(publisher.put_state(1, std::make_shared<const wire::Bytes>(older.begin(), older.end())).ok());
  ASSERT_TRUE(publisher.put_state(1, std::make_shared<const wire::Bytes>(newest.begin(), newest.end())).ok());
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw_part(Kind::disconnected, "closed the link"); }));
  ASSERT_TRUE(listener.poll_until([&] { return listener.last(Kind::control) == "newest"; }));
  EXPECT_TRUE(publish_until_seen(publisher, listener, "after"));
  EXPECT_GE(listener.count(Kind::connected), 2u);
  EXPECT_EQ(listener.link->stats().peers, 1u);
}

TEST_P(Group, PublishersComeAndGoAndFramesOfManyPartsArriveWhole) {
  Listener listener(uri, insecure());
  for (int life = 1; life <= 2; ++life) {
    auto publisher = must_open_publisher(uri + "&mtu=576");
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

TEST_P(Group, StrangersAreCountedAndHarmNobody) {
  ListenerOptions options = insecure();
  options.max_peers = 3;
  Listener listener(uri, options);
  auto publisher = must_open_publisher(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "before"));
  // What a stranger may send: through a link of our own that is told nothing, by its socket's address.
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

TEST(GroupRules, NoKeyNoPortNoConsentNoLink) {
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
  auto nowhere = must_open_publisher(group + "?interface=nowhere9");
  EXPECT_NE(problem_of(*nowhere).find("no interface 'nowhere9'"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::transport::test
