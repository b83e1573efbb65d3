// Test of keyed control messages (states): every joining reader gets the newest value of each key, in order,
// for any number of keys.
#include <signal.h>
#include <sys/wait.h>

#include <map>
#include <random>

#include "protocol/transport/core/keyed_states.h"
#include "protocol/transport/udp/udp_control.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {
namespace {

SharedBytes shared(std::string_view text) {
  const auto bytes = bytes_of(text);
  return std::make_shared<const wire::Bytes>(bytes.begin(), bytes.end());
}

// Pads to the minimum message length.
std::string padded(std::string_view text) {
  std::string state(text);
  state.resize(std::max(state.size(), udp::kLeastStateBytes), '.');
  return state;
}

class States : public testing::TestWithParam<const char*> {
 protected:
  std::string listener_uri() const {
    const std::string scheme = GetParam();
    return scheme == "shm" ? unique_shm_uri("states") : scheme + "://127.0.0.1:0";
  }
  static void put(PublisherLink& publisher, uint64_t key, std::string_view text) {
    const auto taken = publisher.put_state(key, shared(padded(text)));
    EXPECT_TRUE(taken.ok()) << taken.error().message;
  }
  static std::vector<std::string> texts(const Listener& listener) {
    std::vector<std::string> result;
    for (const Event& event : listener.events)
      if (event.kind == Kind::control || event.kind == Kind::pose)
        result.push_back(event.text.substr(0, event.text.find_last_not_of('.') + 1));
    return result;
  }
};

TEST_P(States, JoinerGetsStatesBeforePoses) {
  Listener listener(listener_uri());
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  put(*publisher, 1, "1 old");
  put(*publisher, 2, "2");
  put(*publisher, 3, "3");
  put(*publisher, 1, "1 new");
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, padded("1 new")); }));
  publisher->publish(message_of("pose"));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "pose"); }));
  std::vector<std::string> got = texts(listener);
  std::erase(got, "1 old");  // may be in transit when it is replaced
  EXPECT_EQ(got, (std::vector<std::string>{"d", "2", "3", "1 new", "pose"}));
}

TEST_P(States, WhoComesLaterGetsASnapshot) {
  const std::string scheme = GetParam();
  auto first = std::make_unique<Listener>(listener_uri());
  const std::string uri = first->link->uri();
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  for (int i = 0; i < 100; ++i) put(*publisher, static_cast<uint64_t>(i % 7), std::to_string(i));
  ASSERT_TRUE(first->poll_until([&] { return first->saw(Kind::control, padded("99")); }));
  first.reset();
  Listener second(uri);
  ASSERT_TRUE(second.poll_until([&] { return second.saw(Kind::control, padded("99")); }));
  // Shared memory may still contain replaced values before the newer ones.
  std::vector<std::string> got = texts(second);
  ASSERT_GE(got.size(), 8u);
  EXPECT_EQ(got[0], "d");
  EXPECT_EQ((std::vector<std::string>{got.end() - 7, got.end()}),
            (std::vector<std::string>{"93", "94", "95", "96", "97", "98", "99"}));
  if (scheme != "shm") {
    EXPECT_EQ(got.size(), 8u);
  }
  put(*publisher, 2, "100");
  ASSERT_TRUE(second.poll_until([&] { return second.saw(Kind::control, padded("100")); }));
}

TEST_P(States, SlowPollerGetsAllStates) {
  Listener listener(listener_uri());
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  constexpr uint64_t kKeys = 3000;
  for (uint64_t i = 0; i < kKeys; ++i) put(*publisher, i, std::to_string(i));
  put(*publisher, 0, std::string(300'000, 'x'));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, std::string(300'000, 'x')); }));
  for (uint64_t i = 1; i < kKeys; ++i)
    ASSERT_TRUE(listener.saw(Kind::control, padded(std::to_string(i)))) << i;
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  EXPECT_EQ(listener.link->stats().rejected, 0u);
}

TEST_P(States, ADescriptionEndsThem) {
  Listener listener(listener_uri());
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  put(*publisher, 1, "1");
  put(*publisher, 2, "2");
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, padded("2")); }));
  ASSERT_TRUE(publisher->set_description(bytes_of("e")));
  put(*publisher, 1, "1 again");
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, padded("1 again")); }));
  EXPECT_EQ(texts(listener), (std::vector<std::string>{"d", "1", "2", "e", "1 again"}));
}

TEST_P(States, PartialFollowsWholeFrame) {
  Listener listener(listener_uri());
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "d"); }));
  const auto partial = [&](std::string_view some, const std::string& all_of_it) {
    const wire::MessagePieces whole = message_of(all_of_it);
    return publisher->publish_partial(message_of(some), {&whole, 1});
  };
  // The first frame is whole, and so is one at a busy socket.
  const bool shm = std::string(GetParam()) == "shm";
  int published = 0;
  ASSERT_TRUE(listener.poll_until([&] {
    ++published;
    partial("some", "all of " + std::to_string(published));
    return shm ? published == 10 : listener.saw(Kind::pose, "some");
  }));
  EXPECT_NE(listener.last(Kind::pose), "");
  EXPECT_EQ(listener.saw(Kind::pose, "some"), !shm);
  for (const Event& event : listener.events)
    if (event.kind == Kind::pose) {
      EXPECT_NE(event.text, "some") << "nothing to build on";
      break;
    }
  // A datagram link may lose the last frame without a newer one; the whole frame follows then.
  const std::string all = "all of " + std::to_string(published);
  if (std::string(GetParam()) != "tcp") {
    EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, all); }));
  }
}

INSTANTIATE_TEST_SUITE_P(Links, States, testing::Values("shm", "tcp", "udp"),
                         [](const auto& test) { return std::string(test.param); });

TEST(StatesTcp, DroppedPartialBecomesWhole) {
  Listener listener("tcp://127.0.0.1:0");
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "d"); }));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "base"));
  // An unpolled listener stops reading at this number of states, and a state beyond the socket buffers then
  // blocks poses: a newer pose replaces the waiting one.
  for (uint64_t key = 0; key < 300; ++key) ASSERT_TRUE(publisher->put_state(key, shared("s")).ok());
  ASSERT_TRUE(publisher->put_state(300, std::make_shared<const wire::Bytes>(size_t{32} << 20)).ok());
  for (int i = 0; i < 3; ++i) {
    const std::string all = "all of " + std::to_string(i);
    const wire::MessagePieces whole = message_of(all);
    publisher->publish_partial(message_of("some"), {&whole, 1});
  }
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "all of 2"); }));
  EXPECT_FALSE(listener.saw(Kind::pose, "some"));
  EXPECT_FALSE(listener.saw(Kind::pose, "all of 1"));
}

TEST(StatesBatches, BatchAlwaysEnds) {
  KeyedStates states;
  StateBatches batches;
  const auto put = [&](uint64_t key, std::string_view text) { states.put(key, shared(text)); };
  put(1, "a");
  put(2, "b");
  put(3, "c");
  std::vector<std::string> sent;
  for (int i = 0; i < 6; ++i) {
    const KeyedState* next = batches.next(states);
    ASSERT_NE(next, nullptr);
    sent.push_back(text_of(*next->message));
    batches.pop();
    put(2, "b" + std::to_string(i));  // continuous replacement
  }
  EXPECT_EQ(sent, (std::vector<std::string>{"a", "b", "c", "b2", "b3", "b4"}));
  EXPECT_EQ(states.count(), 3u);
  EXPECT_EQ(states.bytes(), 4u);
}

wire::Bytes bundle_of(size_t records, size_t message_bytes) {
  const KeyedState record = udp::make_record(wire::Bytes(message_bytes, std::byte{7}));
  wire::Bytes bundle;
  for (size_t i = 0; i < records; ++i)
    bundle.insert(bundle.end(), record.message->begin(), record.message->end());
  return bundle;
}

TEST(StatesUdp, DamagedBundleIsNotOpened) {
  wire::Bytes two = bundle_of(2, 13);
  const auto opened = udp::open_bundle(two);
  ASSERT_TRUE(opened);
  ASSERT_EQ(opened->size(), 2u);
  EXPECT_EQ((*opened)[1].size(), 13u);
  for (size_t cut = 1; cut < two.size(); ++cut)
    if (cut != two.size() / 2) {
      EXPECT_FALSE(udp::open_bundle(std::span(two).first(cut))) << cut;
    }
  two[0] = std::byte{200};
  EXPECT_FALSE(udp::open_bundle(two));
}

TEST(StatesUdp, BundleHolds256RecordsAtMost) {
  EXPECT_EQ(udp::open_bundle(bundle_of(256, 12))->size(), 256u);
  EXPECT_FALSE(udp::open_bundle(bundle_of(257, 12)));
  EXPECT_FALSE(udp::open_bundle(bundle_of(1, 11)));
  EXPECT_FALSE(udp::open_bundle(wire::Bytes(size_t{16} << 20))) << "two million empty records";
  EXPECT_EQ(udp::open_bundle(bundle_of(1, 1 << 20))->size(), 1u) << "long states are states";
}

TEST(StatesUdp, BundleHolds256) {
  KeyedStates states;
  for (uint64_t key = 0; key < 1000; ++key) {
    KeyedState record = udp::make_record(wire::Bytes(12, std::byte{7}));
    states.put(key, std::move(record.message), record.hash);
  }
  udp::StateSender feeder;
  udp::ControlSender sender;
  std::vector<size_t> records;
  for (feeder.feed(sender, states); const auto piece = sender.next(1); feeder.feed(sender, states)) {
    records.push_back(piece->header.message_bytes / 20);
    while (sender.next(1)) {
    }
    sender.acknowledge({piece->header.message, piece->header.count, {}}, 1);
  }
  EXPECT_EQ(records, (std::vector<size_t>{256, 256, 256, 232}));
}

// Values of one key come as a series if the reader polls before the log has been compacted twice.
TEST(StatesShm, FastReaderGetsEachValue) {
  Listener listener(unique_shm_uri("series"));
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  constexpr int kRounds = 40, kPerRound = 150;
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < kPerRound; ++i)
      ASSERT_TRUE(
          publisher->put_state(1, shared(std::string(300, 'x') + std::to_string(round * kPerRound + i))));
    const std::string last = std::string(300, 'x') + std::to_string((round + 1) * kPerRound - 1);
    ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, last); }));
  }
  std::vector<std::string> got, expected{"d"};
  for (const Event& event : listener.events)
    if (event.kind == Kind::control) got.push_back(event.text);
  for (int i = 0; i < kRounds * kPerRound; ++i) expected.push_back(std::string(300, 'x') + std::to_string(i));
  EXPECT_EQ(got, expected);
}

TEST(StatesShm, LappedReaderGetsNewest) {
  const std::string uri = unique_shm_uri("lap");
  Listener listener(uri);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  std::mt19937 generator(5);
  std::map<uint64_t, std::string> model, seen;
  for (int i = 0; i < 5000; ++i) {
    const uint64_t key = generator() % 50;
    // Sizes that make the log wrap often, and the segment grow now and then.
    model[key] = std::to_string(key) + ":" + std::string(generator() % (i < 2500 ? 300u : 3000u), 'x') +
                 std::to_string(i);
    ASSERT_TRUE(publisher->put_state(key, shared(model[key])).ok());
    if (generator() % 40 == 0) listener.poll();
  }
  const std::string last = model.begin()->second + "!";
  model.begin()->second = last;
  ASSERT_TRUE(publisher->put_state(model.begin()->first, shared(last)).ok());
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, last); }));
  for (const Event& event : listener.events)
    if (event.kind == Kind::control && event.text != "d") seen[std::stoull(event.text)] = event.text;
  EXPECT_EQ(seen, model);
  EXPECT_EQ(listener.count(Kind::connected), 1u) << "growth is not another publisher";
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
}

TEST(StatesShm, KilledWriterLeavesOrder) {
  const std::string uri = unique_shm_uri("kill-states");
  std::mt19937 generator(11);
  for (uint64_t run = 0; run < 20; ++run) {
    Listener listener(uri);
    const pid_t child = ::fork();
    if (child == 0) {
      auto publisher = open_publisher(uri);
      if (!publisher || !(*publisher)->set_description(bytes_of("d"))) ::_exit(1);
      for (uint64_t i = 1;; ++i) {
        // A version, followed by equal bytes.
        const std::string text =
            std::to_string(i) + ":" + std::string(i * 37 % 5000, static_cast<char>('a' + i % 26));
        if (!(*publisher)->put_state(i % 9, shared(text))) ::_exit(1);
      }
    }
    uint64_t newest = 0, states = 0;
    const uint64_t wanted = 1 + generator() % 300;
    const auto look = [&] {
      for (const Event& event : listener.events) {
        if (event.kind != Kind::control || event.text == "d") continue;
        const uint64_t number = std::stoull(event.text);
        const std::string body = event.text.substr(event.text.find(':') + 1);
        ASSERT_EQ(body, std::string(number * 37 % 5000, static_cast<char>('a' + number % 26)));
        ASSERT_GT(number, newest);
        newest = number;
        ++states;
      }
      listener.events.clear();
    };
    EXPECT_TRUE(listener.poll_until([&] {
      look();
      return states >= wanted || HasFatalFailure();
    }));
    ::usleep(generator() % 1000);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_TRUE(listener.poll_until([&] {
      const bool over = listener.count(Kind::disconnected) != 0;
      look();
      return over || HasFatalFailure();
    }));
    ASSERT_FALSE(HasFailure()) << "run " << run;
  }
  open_publisher_or_fail(uri);  // its destructor removes the dead publisher's file
}

}  // namespace
}  // namespace fire3dv::transport::test
