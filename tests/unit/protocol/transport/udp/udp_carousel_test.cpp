// Test of the multicast carousel: a listener that joins at any time receives the whole state, in order and
// within bounds.
#include <algorithm>
#include <random>

#include "protocol/transport/udp/multicast/udp_group.h"
#include "tests/unit/protocol/transport/link_fixture.h"

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

TEST(Carousel, JoinerGetsAllInOrder) {
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
    EXPECT_EQ(receiver.buffered_bytes(), 0u);
  }
}

TEST(Carousel, NewDescriptionReplacesAllBeforeIt) {
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

TEST(Carousel, OverflowIsCounted) {
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

TEST(Carousel, NewestOfEachKeyRepeats) {
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
  EXPECT_LT(carousel.offer().last - carousel.offer().first, udp::kMaxGroupMessages);
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

TEST(Carousel, StatesKeepPutOrder) {
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

TEST(Carousel, FastKeyIsSeenToChange) {
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

TEST(Carousel, NumbersRestartInTime) {
  constexpr uint32_t kMaxNumbers = 500;
  std::mt19937 random(17);
  Carousel carousel(kDatagramBytes, kMaxNumbers);
  CarouselReceiver receiver(udp::fragment_bytes_of(kDatagramBytes));
  carousel.describe(prepared("d"));
  EXPECT_TRUE(carousel.put(1, prepared("still")));
  EXPECT_TRUE(carousel.add(prepared("said once")));
  const std::string large(5000, 'x');
  int sessions = 1;
  std::vector<std::string> got;
  for (int i = 0; i < 3000; ++i) {
    EXPECT_TRUE(carousel.put(2, prepared(large + std::to_string(i))));
    if (carousel.consume_renumbering()) {
      ++sessions;
      EXPECT_EQ(carousel.offer().description, 1u);
      receiver = CarouselReceiver(udp::fragment_bytes_of(kDatagramBytes));
      got.clear();
    }
    EXPECT_LE(carousel.offer().last, kMaxNumbers + 1);
    if (i % 100 == 0)
      for (auto& message : round_to(carousel, receiver, 0.2, random)) got.push_back(message);
    carousel.next();  // also in the middle of a message
  }
  EXPECT_GE(sessions, 6);
  for (int round = 0; round < 2; ++round)
    for (auto& message : round_to(carousel, receiver, 0, random)) got.push_back(message);
  EXPECT_EQ(got.front(), "d");
  EXPECT_EQ(got.back(), large + "2999");
  for (const char* once : {"d", "still", "said once"}) EXPECT_EQ(std::count(got.begin(), got.end(), once), 1);
}

TEST(Carousel, ContradictionIsCorrupt) {
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
  EXPECT_EQ(fresh().fragment(sound, piece, SIZE_MAX), Outcome::accepted);
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
  ASSERT_EQ(receiver.fragment(sound, piece, SIZE_MAX), Outcome::accepted);
  udp::FragmentHeader other = sound;
  other.index = 1;
  other.hash = 8;
  EXPECT_EQ(receiver.fragment(other, piece, SIZE_MAX), Outcome::corrupt) << "another hash";
  other = sound;
  other.index = 1;
  ASSERT_EQ(receiver.fragment(other, piece, SIZE_MAX), Outcome::accepted);
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

}  // namespace
}  // namespace fire3dv::transport::test
