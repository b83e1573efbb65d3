// Test of memory limits of listeners: budgets of untrusted peers, and failed allocations.
#include <algorithm>
#include <new>

#include "protocol/transport/tcp/tcp_frame.h"
#include "tests/unit/protocol/transport/allocation_fault.h"
#include "tests/unit/protocol/transport/link_fixture.h"
#include "tests/unit/protocol/transport/raw_socket.h"

namespace fire3dv::transport::test {
namespace {

uint64_t rejected(const ListenerLink& link, Cause cause) {
  return link.stats().rejected_by_cause[static_cast<size_t>(cause)];
}

// A TCP peer that sends a valid greeting, claims a message length, and sends a part of it.
struct Claimer {
  RawSocket socket;
  explicit Claimer(const std::string& uri, uint32_t claimed, tcp::FrameKind kind = tcp::FrameKind::pose)
      : socket(uri, SOCK_STREAM) {
    socket.send(tcp::write_preface({}));
    EXPECT_EQ(socket.receive().size(), tcp::kPrefaceBytes);
    socket.send(tcp::write_frame_header(kind, claimed));
  }
  void send(size_t bytes) {
    const std::vector<std::byte> some(64 << 10);
    for (size_t sent = 0; sent < bytes; sent += some.size()) socket.send(some);
  }
};

// Budgets of a few MiB, so that tests reach them fast.
std::shared_ptr<BudgetPool> small_budgets(uint64_t per_peer, uint64_t reserved, uint64_t shared) {
  PeerLimits limits;
  for (const Resource resource : {Resource::received_bytes, Resource::queued_bytes}) {
    const auto i = static_cast<size_t>(resource);
    limits.per_peer[i] = per_peer;
    limits.reserved[i] = reserved;
    limits.shared[i] = shared;
  }
  return BudgetPool::create(limits);
}
constexpr uint64_t kMiB = 1 << 20;

TEST(Memory, UnfinishedMessageEndsItsPeer) {
  ListenerOptions options;
  options.budgets = small_budgets(8 * kMiB, kMiB, 2 * kMiB);
  Listener listener("tcp://127.0.0.1:0", options);
  std::vector<std::unique_ptr<Claimer>> claimers;
  for (int i = 0; i < 3; ++i) {
    claimers.push_back(std::make_unique<Claimer>(listener.link->uri(), 200u << 20, tcp::FrameKind::control));
    claimers.back()->send(2 << 20);
  }
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) >= 1; }));
  EXPECT_TRUE(listener.saw_part(Kind::disconnected, "--peer-limit shared-received-bytes=VALUE"));
  EXPECT_GE(rejected(*listener.link, Cause::no_memory), 1u);
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  const std::string frame(500'000, '.');
  EXPECT_TRUE(publish_until_seen(*publisher, listener, frame)) << "within its reserve";
}

TEST(Memory, PoseBeyondBudgetIsSkipped) {
  ListenerOptions options;
  options.budgets = small_budgets(kMiB, kMiB, kMiB);
  Listener listener("tcp://127.0.0.1:0", options);
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  const std::string large(3 * kMiB, '.');
  ASSERT_TRUE(listener.poll_until([&] {
    publisher->publish(message_of(large));
    return rejected(*listener.link, Cause::no_memory) > 0;
  }));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "small"));
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  EXPECT_GT(listener.link->stats().poses_dropped, 0u);
}

// Images of 512 KiB to peers that do not read fill their budgets and the shared amount. Each image of a third
// peer arrives, from its reserve.
TEST(Memory, UnreadImagesUseOwnBudget) {
  constexpr size_t kPixels = 512 << 10, kImages = 25, kRequests = 40;
  ListenerOptions options;
  options.budgets = small_budgets(16 * kMiB, 2 * kMiB, 20 * kMiB);
  Listener listener("tcp://127.0.0.1:0", options);
  std::vector<std::unique_ptr<Claimer>> greedy;
  std::vector<PeerId> greedy_peers;
  for (size_t i = 0; i < 2; ++i) {
    greedy.push_back(std::make_unique<Claimer>(listener.link->uri(), 1));
    ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == i + 1; }));
    greedy_peers.push_back(listener.peer());
  }
  const auto fill = [](std::span<std::byte> pixels) { std::ranges::fill(pixels, std::byte{1}); };
  for (uint64_t request = 1; request <= kRequests; ++request)
    for (const PeerId peer : greedy_peers)
      listener.link->send_image(peer, request, bytes_of("head"), kPixels, fill);
  EXPECT_GT(options.budgets->used(Resource::queued_bytes), 20 * kMiB);
  EXPECT_LE(options.budgets->used(Resource::queued_bytes), 24 * kMiB);
  EXPECT_GT(listener.link->stats().images_dropped, 0u);

  auto victim = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(victim->set_description(bytes_of("victim")));
  ASSERT_TRUE(victim->make_room_for_images(2 * kPixels, 2));
  ASSERT_TRUE(publish_until_seen(*victim, listener, "pose"));
  PeerId peer = 0;
  for (const Event& event : listener.events)
    if (event.text == "victim") peer = event.peer;
  for (size_t image = 1; image <= kImages; ++image) {
    for (const PeerId other : greedy_peers)
      listener.link->send_image(other, image, bytes_of("head"), kPixels, fill);
    ASSERT_TRUE(listener.link->send_image(peer, 1, bytes_of("head"), kPixels, fill)) << image;
    ASSERT_TRUE(listener.poll_until([&] { return victim->poll_image().has_value(); })) << image;
  }
  greedy.clear();
  victim.reset();
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 3; }));
  // The link's thread reports the end of a peer before it drops the peer's queue.
  EXPECT_TRUE(listener.poll_until([&] {
    return options.budgets->used(Resource::queued_bytes) == 0 &&
           options.budgets->used(Resource::received_bytes) == 0;
  }));
}

TEST(Memory, OutOfMemoryEndsOnePeer) {
  Listener listener("tcp://127.0.0.1:0");
  Claimer claimer(listener.link->uri(), 100u << 20);
  {
    const ScopedAllocationLimit limit(8 << 20);
    claimer.send(20 << 20);
    ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  }
  EXPECT_TRUE(listener.saw_part(Kind::disconnected, "no memory"));
  EXPECT_EQ(rejected(*listener.link, Cause::no_memory), 1u);
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose"));
}

TEST(Memory, UnpolledMessagesAreBounded) {
  ListenerOptions options;
  options.budgets = small_budgets(kMiB, kMiB, kMiB);
  options.delivery = Delivery::all;
  Listener listener("tcp://127.0.0.1:0", options);
  std::vector<std::unique_ptr<PublisherLink>> publishers;
  const std::string frame(300'000, '.');
  for (int i = 0; i < 2; ++i) {
    publishers.push_back(open_publisher_or_fail(listener.link->uri()));
    ASSERT_TRUE(publishers.back()->set_description(bytes_of("d")));
  }
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::control) == 2; }));
  const auto until = std::chrono::steady_clock::now() + kHangLimit;
  while (rejected(*listener.link, Cause::no_memory) < 2 && std::chrono::steady_clock::now() < until) {
    publishers[0]->publish(message_of(frame));
    ::usleep(1000);
  }
  EXPECT_GE(rejected(*listener.link, Cause::no_memory), 2u);
  EXPECT_LE(options.budgets->used(Resource::received_bytes), kMiB);
  publishers[1]->publish(message_of("other"));
  listener.events.clear();
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "other"); }));
  EXPECT_LE(listener.count(Kind::pose), 4u + 1u);
}

TEST(Memory, OutOfMemoryKeepsDescription) {
  const std::string uri = unique_shm_uri("memory");
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("first")));
  const std::string large(300'000, 'x');
  {
    const ScopedAllocationLimit limit(100'000);
    EXPECT_THROW((void)publisher->set_description(bytes_of(large)), std::bad_alloc);
  }
  const std::string frame(200'000, '.');  // the segment must grow, and the description moves with it
  ASSERT_TRUE(publisher->publish(message_of(frame)));
  Listener listener(uri);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) == 1; }));
  EXPECT_EQ(listener.last(Kind::control), "first");
}

}  // namespace
}  // namespace fire3dv::transport::test
