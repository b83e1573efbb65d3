// Security test of shared-memory segments: invalid files under a segment's name are reported once each,
// without a crash.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <random>

#include "protocol/transport/shm/shm_segment.h"
#include "tests/unit/protocol/transport/link_fixture.h"
#include "tests/unit/protocol/transport/raw_socket.h"

namespace fire3dv::transport::test {
namespace {

struct FakeSegment {
  explicit FakeSegment(const char* what) : uri(unique_shm_uri(what)), name(uri.substr(6)) {}
  ~FakeSegment() { ::unlink(shm::segment_path(name).c_str()); }

  // Writes a file with this content, locked like a live publisher's: before it has content, since programs
  // that start meanwhile remove segments without a lock.
  void write(std::span<const std::byte> bytes, mode_t mode = 0600) {
    fd = UniqueFd(::open(shm::segment_path(name).c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    ASSERT_TRUE(fd);
    ASSERT_TRUE(shm::try_lock_byte(fd.get(), shm::kPublisherLockByte));
    ASSERT_EQ(::pwrite(fd.get(), bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    ASSERT_EQ(::fchmod(fd.get(), mode), 0);
  }
  std::string uri, name;
  UniqueFd fd;
};

// Returns the bytes of a valid segment with one description and one pose.
std::vector<std::byte> sound_segment() {
  const std::string uri = unique_shm_uri("sound");
  auto publisher = open_publisher_or_fail(uri);
  EXPECT_TRUE(publisher->set_description(bytes_of("description")));
  publisher->publish(message_of("pose"));
  const UniqueFd fd(::open(shm::segment_path(uri.substr(6)).c_str(), O_RDONLY | O_CLOEXEC));
  struct stat info {};
  EXPECT_EQ(::fstat(fd.get(), &info), 0);
  std::vector<std::byte> bytes(static_cast<size_t>(info.st_size));
  EXPECT_EQ(::pread(fd.get(), bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  return bytes;
}

void expect_one_note(const std::string& uri, std::string_view what) {
  Listener listener(uri);
  for (int i = 0; i < 5; ++i) {
    listener.poll();
    ::usleep(25'000);
  }
  ASSERT_EQ(listener.events.size(), 1u) << what;
  EXPECT_EQ(listener.events[0].kind, Kind::note);
  EXPECT_NE(listener.events[0].text.find(what), std::string::npos) << listener.events[0].text;
  EXPECT_EQ(listener.link->stats().rejected, 1u);
}

TEST(ShmHostile, SoundCopyIsRead) {
  FakeSegment fake("copy");
  fake.write(sound_segment());
  Listener listener(fake.uri);
  listener.poll();
  EXPECT_TRUE(listener.saw(Kind::control, "description"));
  EXPECT_TRUE(listener.saw(Kind::pose, "pose"));
}

TEST(ShmHostile, FilesThatAreNoSegments) {
  FakeSegment fake("garbage");
  fake.write({});
  expect_one_note(fake.uri, "too short");
  fake.write(random_bytes(100'000, 1));
  expect_one_note(fake.uri, "is not a FIRE-3DV segment");
  auto truncated = sound_segment();
  truncated.resize(truncated.size() / 2);
  fake.write(truncated);
  expect_one_note(fake.uri, "bytes long; its header states");
  auto oversized = sound_segment();
  oversized.resize(oversized.size() + 4096);
  fake.write(oversized);
  expect_one_note(fake.uri, "bytes long; its header states");
}

TEST(ShmHostile, AnotherVersionAndUnsafeModes) {
  FakeSegment fake("version");
  auto other = sound_segment();
  other[8] = std::byte{99};
  fake.write(other);
  expect_one_note(fake.uri, "layout version 99");
  fake.write(sound_segment(), 0666);
  expect_one_note(fake.uri, "other users");
}

TEST(ShmHostile, DirectoryOrLinkUnderName) {
  FakeSegment fake("link");
  const std::string path = shm::segment_path(fake.name);
  ASSERT_EQ(::symlink("/etc/hostname", path.c_str()), 0);
  expect_one_note(fake.uri, "cannot be opened");
  EXPECT_FALSE(open_publisher(fake.uri).ok());
  ::unlink(path.c_str());
  ASSERT_EQ(::mkdir(path.c_str(), 0700), 0);
  expect_one_note(fake.uri, "cannot be opened");
  EXPECT_FALSE(open_publisher(fake.uri).ok());
  ::rmdir(path.c_str());
}

TEST(ShmHostile, DeadPublishersGarbageIsReplaced) {
  FakeSegment fake("replace");
  fake.write(random_bytes(5000, 2));
  Listener listener(fake.uri);
  listener.poll();
  EXPECT_EQ(listener.count(Kind::note), 1u);
  fake.fd = UniqueFd();  // releases its lock
  auto publisher = open_publisher_or_fail(fake.uri);
  publisher->publish(message_of("pose"));
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "pose"); }));
}

// Overwrites each word of the header and of the slot heads with values that overflow arithmetic.
TEST(ShmHostile, EveryWordIsValidated) {
  const auto sound = sound_segment();
  FakeSegment fake("words");
  const auto* header = reinterpret_cast<const shm::SegmentHeader*>(sound.data());
  std::vector<size_t> places;
  for (size_t at = 0; at < sizeof(shm::SegmentHeader); at += 8) places.push_back(at);
  for (const auto& ring : header->rings)
    for (size_t at = 0; at < 24; at += 8) places.push_back(ring.offset + at);
  for (size_t at = 0; at < 192; at += 64) places.push_back(header->readers_offset + at);
  for (const size_t place : places) {
    for (const uint64_t value : {uint64_t{0}, uint64_t{1}, uint64_t{3}, uint64_t{1} << 20, uint64_t{1} << 31,
                                 uint64_t{1} << 63, UINT64_MAX, UINT64_MAX - 63}) {
      auto broken = sound;
      std::memcpy(&broken[place], &value, sizeof value);
      fake.write(broken);
      for (const Delivery delivery : {Delivery::newest, Delivery::all}) {
        ListenerOptions options;
        options.delivery = delivery;
        Listener listener(fake.uri, options);
        for (int i = 0; i < 3; ++i) listener.poll();
        listener.link->send(listener.peer(), bytes_of("reply"));
        for (const Event& event : listener.events) {
          if (event.kind == Kind::pose) {
            EXPECT_LE(event.text.size(), header->rings[shm::kPoseRing].capacity);
          }
        }
        EXPECT_LE(listener.count(Kind::note), 1u);
      }
    }
  }
}

// A live segment whose words change at random during reads: what is delivered has a length that the segment
// can hold, and the undamaged segment is read again afterwards.
TEST(ShmHostile, WordsThatChangeDuringReads) {
  const auto sound = sound_segment();
  FakeSegment fake("shaky");
  fake.write(sound);
  void* mapped = ::mmap(nullptr, sound.size(), PROT_READ | PROT_WRITE, MAP_SHARED, fake.fd.get(), 0);
  ASSERT_NE(mapped, MAP_FAILED);
  auto* words = static_cast<uint64_t*>(mapped);
  const size_t pose_capacity =
      reinterpret_cast<const shm::SegmentHeader*>(sound.data())->rings[shm::kPoseRing].capacity;
  ListenerOptions options;
  options.delivery = Delivery::all;
  std::mt19937_64 generator(3);
  uint64_t rejected = 0;
  for (int i = 0; i < 2000; ++i) {
    std::memcpy(mapped, sound.data(), sizeof(shm::SegmentHeader));
    Listener listener(fake.uri, options);
    listener.poll();
    ASSERT_TRUE(listener.saw(Kind::control, "description")) << i;
    ASSERT_TRUE(listener.saw(Kind::pose, "pose")) << i;
    const size_t changed[] = {256 / 8 + generator() % (sound.size() / 8 - 256 / 8),
                              256 / 8 + 8 * (generator() % 4)};
    for (const size_t word : changed)
      shm::atomic_word(words[word]).store(generator() >> (generator() % 64), std::memory_order_relaxed);
    for (int n = 0; n < 3; ++n) listener.poll();
    listener.link->send(listener.peer(), bytes_of("reply"));
    for (const Event& event : listener.events)
      ASSERT_LE(event.text.size(), event.kind == Kind::pose ? pose_capacity : sound.size()) << i;
    EXPECT_LE(listener.count(Kind::note), 1u) << i;
    rejected += listener.link->stats().rejected;
    for (const size_t word : changed) std::memcpy(&words[word], &sound[8 * word], 8);
  }
  EXPECT_GT(rejected, 0u) << "no change met a read";
  ::munmap(mapped, sound.size());
}

TEST(ShmHostile, InvalidRepliesAreCounted) {
  const std::string uri = unique_shm_uri("replies");
  auto publisher = open_publisher_or_fail(uri);
  Listener listener(uri);
  listener.poll();
  const UniqueFd fd(::open(shm::segment_path(uri.substr(6)).c_str(), O_RDWR | O_CLOEXEC));
  struct stat info {};
  ASSERT_EQ(::fstat(fd.get(), &info), 0);
  const auto bytes = static_cast<size_t>(info.st_size);
  void* mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd.get(), 0);
  ASSERT_NE(mapped, MAP_FAILED);
  auto* header = static_cast<shm::SegmentHeader*>(mapped);
  auto* slot = reinterpret_cast<shm::ReaderSlot*>(static_cast<std::byte*>(mapped) + header->readers_offset);
  std::mt19937_64 generator(4);
  std::vector<std::byte> message;
  for (int i = 0; i < 10'000; ++i) {
    for (int n = 0; n < 8; ++n)
      shm::atomic_word(slot->words[generator() % shm::kReplyWords])
          .store(shm::kReplyMark << 32 | (generator() >> (generator() % 64)), std::memory_order_relaxed);
    shm::atomic_word(slot->head).store(generator() >> (generator() % 64), std::memory_order_relaxed);
    for (int n = 0; n < 3 && publisher->poll(message); ++n) EXPECT_LE(message.size(), shm::kReplyWords * 8);
  }
  EXPECT_GT(publisher->stats().rejected, 0u);
  ::munmap(mapped, bytes);
}

}  // namespace
}  // namespace fire3dv::transport::test
