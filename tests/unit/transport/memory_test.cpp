// What strangers may make a listener hold, and what happens when there is no memory at all.
#include <new>

#include "protocol/transport/tcp_frame.h"
#include "tests/unit/transport/link_fixture.h"
#include "tests/unit/transport/raw_socket.h"
#include "tests/unit/transport/scarce_memory.h"

namespace fire3dv::transport::test {
namespace {

uint64_t rejected(const ListenerLink& link, Cause cause) {
  return link.stats().rejected_by_cause[static_cast<size_t>(cause)];
}

// A TCP peer that greets, claims a message of this length, and then sends as much of it as it is told.
struct Claimer {
  RawSocket socket;
  explicit Claimer(const std::string& uri, uint32_t claimed) : socket(uri, SOCK_STREAM) {
    socket.send(tcp::write_preface({}));
    EXPECT_EQ(socket.receive().size(), tcp::kPrefaceBytes);
    socket.send(tcp::write_frame_header(tcp::FrameKind::pose, claimed));
  }
  void send(size_t bytes) {
    const std::vector<std::byte> some(64 << 10);
    for (size_t sent = 0; sent < bytes; sent += some.size()) socket.send(some);
  }
};

TEST(Memory, UnfinishedMessagesOfAllPeersShareOneBudget) {
  ListenerOptions options;
  options.max_memory_bytes = 4 << 20;
  Listener listener("tcp://127.0.0.1:0", options);
  std::vector<std::unique_ptr<Claimer>> claimers;
  for (int i = 0; i < 3; ++i) {
    claimers.push_back(std::make_unique<Claimer>(listener.link->uri(), 200u << 20));
    claimers.back()->send(2 << 20);
  }
  ASSERT_TRUE(
      listener.poll_until([&] { return listener.saw_part(Kind::disconnected, "all peers together"); }));
  EXPECT_GE(rejected(*listener.link, Cause::no_memory), 1u);
  auto publisher = must_open_publisher(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose")) << "others go on";
}

TEST(Memory, APeerWhoseMessageFindsNoMemoryIsEndedAndOthersGoOn) {
  Listener listener("tcp://127.0.0.1:0");
  Claimer claimer(listener.link->uri(), 100u << 20);
  {
    const NoMemoryAbove limit(8 << 20);
    claimer.send(20 << 20);
    ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  }
  EXPECT_TRUE(listener.saw_part(Kind::disconnected, "no memory"));
  EXPECT_EQ(rejected(*listener.link, Cause::no_memory), 1u);
  auto publisher = must_open_publisher(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose"));
}

TEST(Memory, WhatNobodyPollsIsBoundedToo) {
  ListenerOptions options;
  options.max_memory_bytes = 1 << 20;
  Listener listener("tcp://127.0.0.1:0", options);
  std::vector<std::unique_ptr<PublisherLink>> publishers;
  const std::string frame(600'000, '.');
  for (int i = 0; i < 3; ++i) {
    publishers.push_back(must_open_publisher(listener.link->uri()));
    ASSERT_TRUE(publishers.back()->set_description(bytes_of("d")));
  }
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::control) == 3; }));
  const auto until = std::chrono::steady_clock::now() + kHangLimit;
  while (rejected(*listener.link, Cause::no_memory) < 2 && std::chrono::steady_clock::now() < until) {
    for (auto& publisher : publishers) publisher->publish(message_of(frame));
    ::usleep(1000);
  }
  EXPECT_GE(rejected(*listener.link, Cause::no_memory), 2u);
  listener.events.clear();
  listener.poll();
  EXPECT_LE(listener.count(Kind::pose), 1u);
}

TEST(Memory, ADescriptionThatFindsNoMemoryLeavesTheEarlierOneInForce) {
  const std::string uri = unique_shm_uri("memory");
  auto publisher = must_open_publisher(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("first")));
  const std::string large(300'000, 'x');
  {
    const NoMemoryAbove limit(100'000);
    EXPECT_THROW((void)publisher->set_description(bytes_of(large)), std::bad_alloc);
  }
  const std::string frame(200'000, '.');  // the segment has to grow, and the description goes with it
  ASSERT_TRUE(publisher->publish(message_of(frame)));
  Listener listener(uri);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) == 1; }));
  EXPECT_EQ(listener.last(Kind::control), "first");
}

}  // namespace
}  // namespace fire3dv::transport::test
