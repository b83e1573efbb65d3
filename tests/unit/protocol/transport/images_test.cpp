// Test of image transfer from renderer to client: integrity, ownership of slots, the newest image per
// request, and isolation of slow or dead peers.
#include <sys/wait.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <random>
#include <thread>

#include "protocol/transport/tcp/tcp_send_queue.h"
#include "protocol/wire/image.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {
namespace {

constexpr size_t kPixelBytes = 20'000;

class Images : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const bool shm = GetParam() == "shm";
    listener_.emplace(shm ? unique_shm_uri("images") : "tcp://127.0.0.1:0");
    publisher_ = open_publisher_or_fail(listener_->link->uri());
    ASSERT_TRUE(publisher_->set_description(bytes_of("description")).ok());
  }
  void make_room(size_t requests) {
    const auto room = publisher_->make_room_for_images(wire::max_block_bytes(kPixelBytes), requests);
    ASSERT_TRUE(room.ok()) << room.error().message;
    ASSERT_TRUE(publish_until_seen(*publisher_, *listener_, "pose"));  // in the segment with the image slots
  }
  PeerId peer() {
    for (const Event& event : listener_->events)
      if (event.kind == Kind::connected) peer_ = event.peer;
    return peer_;
  }

  // An image whose bytes follow from its number.
  static std::byte byte_of(uint64_t number, size_t at) {
    return static_cast<std::byte>(number * 31 + at * 7);
  }
  bool send(uint64_t request, uint64_t number) {
    const std::string head = std::to_string(number);
    return listener_->link->send_image(peer(), request, bytes_of(head), kPixelBytes,
                                       [&](std::span<std::byte> pixels) {
                                         ASSERT_EQ(pixels.size(), kPixelBytes);
                                         for (size_t i = 0; i < pixels.size(); ++i)
                                           pixels[i] = byte_of(number, i);
                                       });
  }
  // Returns the number of an image after checking all its bytes.
  static uint64_t number_of(const PublisherLink::Image& image, uint64_t& request) {
    const auto block = wire::read_image_block(image.block);
    EXPECT_TRUE(block.ok()) << block.error().message;
    if (!block) return 0;
    const uint64_t number = std::stoull(text_of(block->head));
    EXPECT_EQ(block->pixels.size(), kPixelBytes);
    bool same = true;
    for (size_t i = 0; i < block->pixels.size(); ++i) same = same && block->pixels[i] == byte_of(number, i);
    EXPECT_TRUE(same) << "image " << number << " was written over";
    request = block->request;
    return number;
  }
  std::optional<PublisherLink::Image> next() {
    const auto until = std::chrono::steady_clock::now() + kHangLimit;
    while (std::chrono::steady_clock::now() < until) {
      if (auto image = publisher_->poll_image()) return image;
      ::usleep(100);
    }
    return {};
  }

  std::optional<Listener> listener_;
  std::unique_ptr<PublisherLink> publisher_;
  PeerId peer_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Links, Images, ::testing::Values("shm", "tcp"));

TEST_P(Images, ImagesAndRepliesInterleave) {
  make_room(4);
  for (uint64_t number = 1; number <= 200; ++number) {
    ASSERT_TRUE(send(number, number));
    listener_->link->send(peer(), bytes_of("reply"));
    const auto image = next();
    ASSERT_TRUE(image) << number;
    uint64_t request = 0;
    EXPECT_EQ(number_of(*image, request), number);
    EXPECT_EQ(request, number);
  }
  EXPECT_TRUE(poll_until_reply(*publisher_, "reply"));
  EXPECT_EQ(listener_->link->stats().images_dropped, 0u);
  EXPECT_EQ(publisher_->stats().images_received, 200u);
}

TEST_P(Images, HeldImagesAreNotMixed) {
  constexpr uint64_t kImages = 1000, kRequests = 16;
  make_room(kRequests);
  std::mt19937_64 random(7);
  std::vector<std::pair<uint64_t, PublisherLink::Image>> held;  // by number
  std::map<uint64_t, uint64_t> newest;                          // of each request
  const auto take = [&](PublisherLink::Image&& image) {
    uint64_t request = 0;
    const uint64_t number = number_of(image, request);
    EXPECT_EQ(request, number % kRequests + 1);
    EXPECT_GT(number, newest[request]) << "an older image after a newer one";
    newest[request] = number;
    held.emplace_back(number, std::move(image));
  };
  for (uint64_t number = 1; number <= kImages; ++number) {
    send(number % kRequests + 1, number);
    for (uint64_t more = random() % 3; more > 0; --more)
      if (auto image = publisher_->poll_image()) take(std::move(*image));
    while (held.size() > random() % kRequests) {
      const size_t which = random() % held.size();
      uint64_t request = 0;
      ASSERT_EQ(number_of(held[which].second, request), held[which].first) << "changed while it was held";
      held.erase(held.begin() + static_cast<std::ptrdiff_t>(which));
    }
  }
  held.clear();
  const auto has_all = [&] {
    return std::all_of(newest.begin(), newest.end(),
                       [](const auto& entry) { return entry.second > kImages - kRequests; });
  };
  while (newest.size() < kRequests || !has_all()) {
    auto image = next();
    ASSERT_TRUE(image) << "the newest image of a request was lost";
    take(std::move(*image));
    held.clear();
  }
}

TEST_P(Images, UnreadRequestKeepsNewest) {
  make_room(1);
  // More images than shared memory has notices for; a lost notice must not lose the image before it.
  uint64_t newest = 0;
  for (uint64_t number = 1; number <= 6000; ++number)
    if (send(9, number)) newest = number;
  EXPECT_GT(newest, 3000u);
  uint64_t got = 0;
  while (got < newest) {
    const auto image = next();
    ASSERT_TRUE(image);
    uint64_t request = 0;
    got = number_of(*image, request);
  }
  const uint64_t dropped = listener_->link->stats().images_dropped + publisher_->stats().images_dropped;
  EXPECT_GT(dropped, 0u);
  EXPECT_LT(dropped, 6000u);
  EXPECT_TRUE(send(9, 6001)) << "there is room again";
}

TEST_P(Images, ContradictoryImagesAreDropped) {
  make_room(2);
  const std::string head = "head";
  ASSERT_TRUE(
      listener_->link->send_image(peer(), 1, bytes_of(head), kPixelBytes, [&](std::span<std::byte> pixels) {
        std::memset(pixels.data() - wire::pixels_at(head.size()), 0xff,
                    16);  // invalid blocks of a faulty renderer
      }));
  ASSERT_TRUE(send(2, 7));
  const auto image = next();
  ASSERT_TRUE(image);
  uint64_t request = 0;
  EXPECT_EQ(number_of(*image, request), 7u);
  EXPECT_EQ(request, 2u);
  EXPECT_EQ(publisher_->stats().rejected_by_cause[static_cast<size_t>(Cause::malformed)], 1u);
}

TEST_P(Images, AreRefusedUntilRoomIsMade) {
  ASSERT_TRUE(publish_until_seen(*publisher_, *listener_, "pose"));
  send(1, 1);
  listener_->link->send(peer(), bytes_of("reply"));
  ASSERT_TRUE(poll_until_reply(*publisher_, "reply"));
  EXPECT_FALSE(publisher_->poll_image());
}

TEST_P(Images, StayWhenTheLinkIsGone) {
  make_room(1);
  ASSERT_TRUE(send(1, 5));
  const auto image = next();
  ASSERT_TRUE(image);
  publisher_.reset();
  uint64_t request = 0;
  EXPECT_EQ(number_of(*image, request), 5u);
}

TEST_P(Images, ToWhoIsGoneAreLost) {
  make_room(1);
  publisher_.reset();
  ASSERT_TRUE(listener_->poll_until([&] { return listener_->count(Kind::disconnected) > 0; }));
  for (uint64_t number = 1; number <= 100; ++number) send(1, number);
}

// The first images are lent, later ones copied, so that the renderer always finds a slot.
TEST(ShmImages, HeldImagesKeepTheirPixels) {
  Listener listener(unique_shm_uri("held"));
  auto publisher = open_publisher_or_fail(listener.link->uri());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")).ok());
  ASSERT_TRUE(publisher->make_room_for_images(4096, 1).ok());
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
  const PeerId peer = listener.events[0].peer;
  std::vector<PublisherLink::Image> held;
  const auto send = [&](uint8_t number, size_t bytes) {
    return listener.link->send_image(peer, number, bytes_of("h"), bytes, [&](std::span<std::byte> pixels) {
      std::ranges::fill(pixels, std::byte{number});
    });
  };
  constexpr uint8_t kImages = 64;
  for (uint8_t number = 1; number <= kImages; ++number) {
    ASSERT_TRUE(send(number, 64)) << "no slot for image " << int{number};
    auto image = publisher->poll_image();
    ASSERT_TRUE(image);
    held.push_back(std::move(*image));
  }
  EXPECT_EQ(listener.link->stats().images_dropped, 0u);
  for (uint8_t number = 1; number <= kImages; ++number)
    EXPECT_EQ(held[number - 1u].block.back(), std::byte{number}) << "the pixels of another image";
  EXPECT_FALSE(send(kImages + 1, 1 << 20)) << "longer than a slot";
}

TEST(ShmImages, LaterRendererGetsEarlierPose) {
  const std::string uri = unique_shm_uri("paused");
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")).ok());
  publisher->publish(message_of("paused"));
  ASSERT_TRUE(publisher->make_room_for_images(4096, 1).ok());
  Listener later(uri);
  EXPECT_TRUE(later.poll_until([&] { return later.saw(Kind::pose, "paused"); }));
}

TEST(ShmImages, PoseIsNotRepeated) {
  const std::string uri = unique_shm_uri("carried");
  Listener listener(uri, {.delivery = Delivery::all});
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")).ok());
  publisher->publish(message_of("one"));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "one"); }));
  ASSERT_TRUE(publisher->make_room_for_images(4096, 1).ok());
  publisher->publish(message_of("two"));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "two"); }));
  EXPECT_EQ(listener.count(Kind::pose), 2u);
}

// A renderer killed during a write leaves an incomplete slot.
TEST(ShmImages, DeadRenderersSlotIsFreed) {
  const std::string uri = unique_shm_uri("dead");
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")).ok());
  ASSERT_TRUE(publisher->make_room_for_images(4096, 1).ok());
  publisher->publish(message_of("pose"));
  for (int killed = 0; killed < 40; ++killed) {  // more than the number of slots
    const pid_t child = ::fork();
    if (child == 0) {
      Listener listener(uri);
      listener.poll_until([&] { return listener.count(Kind::pose) > 0; });
      listener.link->send_image(listener.events[0].peer, 1, bytes_of("h"), 64,
                                [](std::span<std::byte>) { ::_exit(0); });
      ::_exit(1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(WEXITSTATUS(status), 0) << "no slot was free after " << killed << " dead renderers";
    ASSERT_FALSE(publisher->poll_image());
  }
}

// The renderer changes the length of the head after the publisher's check (TOCTOU).
TEST(ImageBlock, ConcurrentChangesAreConsistent) {
  constexpr size_t kTurns = 200'000;
  std::vector<std::byte> block(wire::max_block_bytes(4096));
  const std::string head(100, 'h');
  wire::write_image_block_head(block, 7, bytes_of(head));
  std::atomic<bool> is_over{false};
  std::thread writer([&] {
    const std::atomic_ref<uint32_t> head_bytes(*reinterpret_cast<uint32_t*>(block.data() + 8));
    for (uint32_t turn = 0; !is_over.load(std::memory_order_relaxed); ++turn)
      head_bytes.store(turn % 3 == 0 ? 100 : turn % 3 == 1 ? 1024 : UINT32_MAX, std::memory_order_relaxed);
  });
  size_t read = 0, refused = 0;
  for (size_t turn = 0; turn < kTurns || ((read == 0 || refused == 0) && turn < 1000 * kTurns); ++turn) {
    const auto got = wire::read_image_block(block);
    (got.ok() ? read : refused) += 1;
    if (!got) continue;
    ASSERT_LE(got->head.size(), wire::kMaxImageHeadBytes);
    ASSERT_EQ(static_cast<size_t>(got->pixels.data() - block.data()), wire::pixels_at(got->head.size()));
    ASSERT_EQ(got->pixels.data() + got->pixels.size(), block.data() + block.size());
  }
  is_over = true;
  writer.join();
  EXPECT_GT(read, 0u);
  EXPECT_GT(refused, 0u);
}

TEST(ImageQueue, NewestAreKeptWithinBound) {
  using Block = std::vector<std::byte>;
  ImageQueue<Block> queue(100, 3);
  EXPECT_EQ(queue.push(1, Block(40)).size(), 0u);
  EXPECT_EQ(queue.push(2, Block(40)).size(), 0u);
  EXPECT_EQ(queue.push(1, Block(50)).size(), 1u) << "the older image of its request";
  EXPECT_EQ(queue.bytes(), 90u);
  EXPECT_EQ(queue.push(3, Block(30)).size(), 1u) << "the oldest";
  EXPECT_EQ(queue.pop().size(), 50u);
  EXPECT_EQ(queue.pop().size(), 30u);
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.push(4, Block(101)).size(), 1u) << "itself";
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.bytes(), 0u);
  for (uint64_t request = 1; request <= 3; ++request) EXPECT_TRUE(queue.push(request, Block(1)).empty());
  EXPECT_EQ(queue.push(4, Block(2)).size(), 1u) << "one too many";
  queue.raise_limit(1000);
  EXPECT_EQ(queue.push(4, Block(500)).size(), 1u) << "only the older one of its request";
  EXPECT_EQ(queue.bytes(), 502u);
}

}  // namespace
}  // namespace fire3dv::transport::test
