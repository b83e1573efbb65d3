// Durability test of recordings, with reports of losses: flushes, failing disks, and more streams than slots.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "protocol/record/log_thread.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

// Disk in memory that counts flushes and fails on demand.
struct Disk {
  Bytes bytes, flushed;
  std::atomic<int> flushes = 0;
  std::atomic<bool> fails_to_flush = false;
  uint64_t capacity_bytes = UINT64_MAX;
};

class DiskSink final : public record::Sink {
 public:
  explicit DiskSink(Disk& disk) : disk_(disk) {}
  Result<void> append(std::span<const std::byte> bytes) override {
    if (disk_.bytes.size() + bytes.size() > disk_.capacity_bytes) return Error{"the disk is full"};
    disk_.bytes.insert(disk_.bytes.end(), bytes.begin(), bytes.end());
    return {};
  }
  Result<void> truncate(uint64_t length) override {
    disk_.bytes.resize(length);
    return {};
  }
  Result<void> flush() override {
    ++disk_.flushes;
    if (disk_.fails_to_flush) return Error{"disk.mcap cannot be flushed to the disk"};
    disk_.flushed = disk_.bytes;
    return {};
  }
  const std::string& name() const override { return name_; }

 private:
  Disk& disk_;
  std::string name_ = "disk.mcap";
};

record::StreamLog log_on(Disk& disk, const record::LogOptions& options) {
  return record::StreamLog(
      [&disk](uint32_t) -> Result<std::unique_ptr<record::Sink>> {
        return std::unique_ptr<record::Sink>(std::make_unique<DiskSink>(disk));
      },
      {}, options);
}

std::vector<uint64_t> sequences_in(const Bytes& file) {
  std::vector<uint64_t> result;
  auto playback = Playback::open(source_of(file));
  if (!playback) return result;
  wire::Decoder decoder;
  for (const PlayedMessage& played : played_from(*playback)) {
    if (played.kind != Played::Kind::pose) continue;
    const auto decoded = decoder.decode(played.message);
    result.push_back(std::get<wire::PoseFrameView>(*decoded).header.sequence);
  }
  return result;
}

TEST(Flushes, IntervalFlushesOlderData) {
  Disk disk;
  record::LogOptions options = small_chunks();
  options.flush_ns = 50 * kMs;
  record::StreamLog log = log_on(disk, options);
  ASSERT_TRUE(log.take(1, description(7), kBegun_ns).ok());
  for (uint64_t i = 1; i <= 400; ++i) {
    ASSERT_TRUE(log.take(1, frame(7, i), kBegun_ns + i * kMs).ok());
    if (i > 50) {
      EXPECT_GE(sequences_in(disk.flushed).size(), i - 50);
    }
  }
  EXPECT_EQ(disk.flushes, 8);
  // Without new messages there is no flush. The interval starts with the next message.
  ASSERT_TRUE(log.tick(kBegun_ns + 1000 * kMs).ok());
  const int flushes = disk.flushes;
  for (uint64_t ms = 2000; ms < 9000; ms += 100) ASSERT_TRUE(log.tick(kBegun_ns + ms * kMs).ok());
  EXPECT_EQ(disk.flushes, flushes);
  ASSERT_TRUE(log.take(1, frame(7, 401), kBegun_ns + 9000 * kMs).ok());
  ASSERT_TRUE(log.take(1, frame(7, 402), kBegun_ns + 9001 * kMs).ok());
  EXPECT_EQ(disk.flushes, flushes);
  ASSERT_TRUE(log.tick(kBegun_ns + 9100 * kMs).ok());
  EXPECT_EQ(disk.flushes, flushes + 1);
  EXPECT_EQ(sequences_in(disk.flushed).size(), 402u);
}

TEST(Flushes, ComeOnlyAtEndWithoutInterval) {
  Disk disk;
  record::LogOptions options = small_chunks();
  options.flush_ns = 0;
  record::StreamLog log = log_on(disk, options);
  ASSERT_TRUE(log.take(1, description(7), kBegun_ns).ok());
  for (uint64_t i = 1; i <= 400; ++i) ASSERT_TRUE(log.take(1, frame(7, i), kBegun_ns + i * 20 * kMs).ok());
  EXPECT_EQ(disk.flushes, 0);
  ASSERT_TRUE(log.finish().ok());
  EXPECT_EQ(disk.flushes, 1);
  EXPECT_EQ(disk.flushed, disk.bytes);
}

TEST(Flushes, ErrorEndsRecordingAndIsReported) {
  Disk disk;
  disk.fails_to_flush = true;
  record::LogOptions options;
  options.flush_ns = kMs;
  record::LogThread log(log_on(disk, options));
  log.take(1, description(7), 0, false);
  uint64_t sequence = 0;
  while (!log.losses().failure && ++sequence < 100'000) {
    log.take(1, frame(7, sequence), static_cast<int64_t>(sequence * kMs), true);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(log.losses().failure);
  EXPECT_NE(log.losses().failure->find("disk.mcap cannot be flushed"), std::string::npos);
  EXPECT_TRUE(log.has_trouble());
  const int flushes = disk.flushes;
  const uint64_t unwritten = log.losses().unwritten;
  log.take(1, frame(7, sequence + 1), 0, true);
  log.finish();
  EXPECT_EQ(log.losses().unwritten, unwritten + 1) << "what comes later is counted";
  EXPECT_EQ(disk.flushes, flushes) << "the error is not hidden by a later flush";
}

// After a failure the counts equal the messages in the file, wherever the disk was full.
TEST(Counts, AreOfMessagesInFile) {
  Disk head;  // start of the file
  ASSERT_TRUE(log_on(head, small_chunks(2500)).take(1, description(7), kBegun_ns).ok());
  for (uint64_t more_bytes = 1'000; more_bytes < 50'000; more_bytes += 1'717) {
    Disk disk;
    const uint64_t capacity_bytes = disk.capacity_bytes = head.bytes.size() + more_bytes;
    record::StreamLog log = log_on(disk, small_chunks(2500));
    ASSERT_TRUE(log.take(1, description(7), kBegun_ns).ok());
    Result<void> good;
    uint64_t taken = 0;
    while (good) {
      ++taken;
      if (taken % 5 == 0)
        good = log.take(1, edit(7, taken, "link_0", taken % 2 == 0), kBegun_ns + taken * kMs);
      if (good) good = log.take(1, frame(7, taken), kBegun_ns + taken * kMs);
    }
    (void)log.finish().ok();
    uint64_t frames = 0, edits = 0, messages = 0, bytes = 0;
    auto reader = record::Reader::open(source_of(disk.bytes));
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    for (const LoggedMessage& heard : all_messages(*reader)) {
      const auto& role =
          reader->index().channels.at(heard.channel).metadata.at(std::string(record::kRoleKey));
      if (role == record::role_name(record::Role::snapshot)) continue;
      ++messages;
      bytes += heard.data.size();
      frames += role == record::role_name(record::Role::poses);
      wire::Decoder decoder;
      edits += std::holds_alternative<wire::SceneEdit>(*decoder.decode(heard.data));
    }
    const record::StreamSeen seen = log.streams().at(0);
    EXPECT_EQ(seen.frames, frames) << capacity_bytes;
    EXPECT_EQ(seen.edits, edits) << capacity_bytes;
    EXPECT_EQ(seen.messages, messages) << capacity_bytes;
    EXPECT_EQ(seen.bytes, bytes) << capacity_bytes;
    EXPECT_LT(frames, taken);
    EXPECT_GT(log.lost_messages(), 0u);
  }
}

TEST(Slots, OfEndedStreamsAreReclaimed) {
  constexpr uint64_t kVisitors = 3000;
  MemoryLog memory;
  for (uint64_t visitor = 1; visitor <= kVisitors; ++visitor) {
    ASSERT_TRUE(memory.take(description(visitor, "visitor " + std::to_string(visitor)), visitor, visitor));
    ASSERT_TRUE(memory.take(frame(visitor, 1), visitor, visitor));
    memory.log.end_peer(visitor);
  }
  ASSERT_TRUE(memory.take(description(7777, "arm"), 5000, 7777));
  ASSERT_TRUE(memory.take(frame(7777, 1), 5001, 7777));
  // A stream without a slot gets one again.
  ASSERT_TRUE(memory.take(description(8888, "visitor 1"), 5002, 8888));
  ASSERT_TRUE(memory.take(frame(8888, 1), 5003, 8888));
  EXPECT_EQ(memory.log.refused(), 0u);
  EXPECT_EQ(memory.log.unrecorded_streams(), 0u);
  EXPECT_EQ(memory.log.streams().size(), 1024u);
  EXPECT_EQ(memory.log.reclaimed_streams(), kVisitors + 2 - 1024);
  EXPECT_EQ(memory.log.reclaimed_frames(), kVisitors + 2 - 1024);
  ASSERT_TRUE(memory.log.finish().ok());
  // All of them are played, and each name is one stream.
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok()) << playback.error().message;
  EXPECT_EQ(playback->streams().size(), kVisitors + 1);
  std::map<std::string, int> frames;
  for (const PlayedMessage& played : played_from(*playback))
    frames[playback->streams()[played.stream].name] += played.kind == Played::Kind::pose;
  EXPECT_EQ(frames.size(), kVisitors + 1);
  EXPECT_EQ(frames["arm"], 1);
  EXPECT_EQ(frames["visitor 1"], 2);
}

TEST(Slots, UnrecordedStreamIsReported) {
  MemoryLog memory;
  constexpr uint64_t kSlots = 1024;
  for (uint64_t stream = 1; stream <= kSlots; ++stream)
    ASSERT_TRUE(memory.take(description(stream, "s" + std::to_string(stream)), 0, stream));
  for (int again = 0; again < 3; ++again) ASSERT_TRUE(memory.take(description(5000, "late"), 1, 5000));
  EXPECT_EQ(memory.log.unrecorded_streams(), 1u);
  ASSERT_TRUE(memory.take(description(5001, "later"), 1, 5001));
  EXPECT_EQ(memory.log.unrecorded_streams(), 2u);
  memory.log.end_peer(3);
  ASSERT_TRUE(memory.take(description(5000, "late"), 2, 5000));
  ASSERT_TRUE(memory.take(frame(5000, 1), 3, 5000));
  EXPECT_EQ(memory.log.streams().at(2).name, "late");
  EXPECT_EQ(memory.log.streams().at(2).frames, 1u);
}

// Readers hold the channels of a file in memory. A series continues in a new file; a single file accepts no
// further streams.
TEST(Slots, ChannelsAreBounded) {
  for (const uint64_t split_ns : {uint64_t{0}, 3'600'000 * kMs}) {
    record::LogOptions options;
    options.split_ns = split_ns;
    MemoryLog memory(options);
    const std::string name(900, 'n');
    constexpr uint64_t kVisitors = 2500;
    for (uint64_t visitor = 1; visitor <= kVisitors; ++visitor) {
      ASSERT_TRUE(memory.take(description(visitor, name + std::to_string(visitor)), visitor, visitor));
      memory.log.end_peer(visitor);
    }
    ASSERT_TRUE(memory.log.finish().ok());
    EXPECT_EQ(memory.log.unrecorded_streams() > 0, split_ns == 0);
    EXPECT_EQ(memory.files.size(), split_ns == 0 ? 1u : 2u);
    for (const auto& file : memory.files) EXPECT_TRUE(Playback::open(source_of(*file)).ok());
  }
}

}  // namespace
}  // namespace fire3dv::record_test
