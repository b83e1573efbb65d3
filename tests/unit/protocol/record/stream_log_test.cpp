// Test of the recorder's log: self-contained files, snapshots of bounded size, and counts of missing
// messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "protocol/record/log_thread.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

TEST(StreamLog, AttachmentsHaveLimits) {
  std::vector<std::unique_ptr<Bytes>> files;
  record::LogOptions options = small_chunks();
  options.split_bytes = 12'000;
  record::StreamLog log(
      [&](uint32_t) -> Result<std::unique_ptr<record::Sink>> {
        files.push_back(std::make_unique<Bytes>());
        return std::unique_ptr<record::Sink>(std::make_unique<record::MemorySink>(*files.back()));
      },
      [](record::Writer& writer, uint64_t) {
        record::MemorySource scene(Bytes(50'000));
        return writer.attach({}, scene);
      },
      options);
  ASSERT_TRUE(log.take(1, description(7), kBegun_ns).ok());
  constexpr uint64_t kFrames = 200;
  for (uint64_t i = 1; i <= kFrames; ++i) ASSERT_TRUE(log.take(1, frame(7, i), kBegun_ns + i * kMs).ok());
  ASSERT_TRUE(log.finish().ok());
  EXPECT_GT(files.size(), 1u);
  EXPECT_LE(files.size(), kFrames * frame(7, 1).size() / options.split_bytes + 1 + kFrames / 20);
  for (const auto& file : files) EXPECT_GT(file->size(), 50'000u);
}

// Each file of a series describes a stream before its other messages, in the order of the original
// descriptions.
TEST(StreamLog, FramesFollowDescriptions) {
  record::LogOptions options;  // one chunk per file: a returning stream starts in the middle of a chunk
  options.split_bytes = 4'000;
  MemoryLog memory(options);
  ASSERT_TRUE(memory.take(description(7), 0, 1));
  ASSERT_TRUE(memory.take(edit(7, 1, "link_0", false), 0, 1));
  ASSERT_TRUE(memory.take(frame(7, 1), 0, 1));
  memory.log.end_peer(1);
  ASSERT_TRUE(memory.take(description(8, "crane"), 1, 2));
  uint64_t sequence = 0;
  while (memory.log.files() < 2) ASSERT_TRUE(memory.take(frame(8, ++sequence), 2, 2));
  ASSERT_TRUE(memory.take(frame(8, ++sequence), 2, 2));
  ASSERT_TRUE(memory.take(description(7), 3, 1));
  ASSERT_TRUE(memory.take(frame(7, 2), 3, 1));
  ASSERT_TRUE(memory.log.finish().ok());
  ASSERT_EQ(memory.files.size(), 2u);
  auto playback = Playback::open(source_of(*memory.files[1]));
  ASSERT_TRUE(playback.ok());
  playback->rewind();
  std::vector<Bytes> of_arm;
  for (PlayedMessage& played : played_from(*playback))
    if (playback->streams()[played.stream].name == "arm") of_arm.push_back(std::move(played.message));
  EXPECT_EQ(of_arm, (std::vector<Bytes>{description(7), edit(7, 1, "link_0", false), frame(7, 2)}));
}

TEST(StreamLog, DescriptionPrecedesSnapshot) {
  MemoryLog memory(small_chunks(1));  // each message starts a chunk
  constexpr uint64_t kLongest = 400;
  ASSERT_TRUE(memory.take(description(1, "long", kLongest), 0, 1));
  for (uint64_t i = 1; i <= 400; ++i) {
    ASSERT_TRUE(memory.take(frame(1, i, kLongest), i, 1));
    if (i % 10 == 0) {
      ASSERT_TRUE(memory.take(description(i, "s" + std::to_string(i), 1), i, i));
    }
  }
  ASSERT_TRUE(memory.log.finish().ok());
  auto reader = record::Reader::open(source_of(*memory.files[0]));
  ASSERT_TRUE(reader.ok());
  std::vector<std::string> described;
  record::Message message;
  while (reader->next(message) == record::Reader::Step::message) {
    const record::Texts& about = reader->index().channels.at(message.channel_id).metadata;
    const std::string& role = about.at(std::string(record::kRoleKey));
    const std::string& stream = about.at(std::string(record::kStreamKey));
    if (role == record::role_name(record::Role::control)) described.push_back(stream);
    if (role == record::role_name(record::Role::snapshot)) {
      EXPECT_NE(std::ranges::find(described, stream), described.end());
    }
  }
  EXPECT_EQ(described.size(), 41u);
}

TEST(StreamLog, SnapshotsStayBelowANinth) {
  MemoryLog memory(small_chunks());
  constexpr uint64_t kStreams = 30;
  for (uint64_t stream = 1; stream <= kStreams; ++stream)
    ASSERT_TRUE(memory.take(description(stream, "s" + std::to_string(stream)), 0, stream));
  for (uint64_t i = 1; i <= 600; ++i)
    for (uint64_t stream = 1; stream <= kStreams; ++stream)
      ASSERT_TRUE(memory.take(frame(stream, i), i, stream));
  ASSERT_TRUE(memory.log.finish().ok());
  auto reader = record::Reader::open(source_of(*memory.files[0]));
  ASSERT_TRUE(reader.ok());
  uint64_t snapshots = 0, all = 0;
  record::Message message;
  while (reader->next(message) == record::Reader::Step::message) {
    all += message.data.size();
    const record::Texts& about = reader->index().channels.at(message.channel_id).metadata;
    if (about.at(std::string(record::kRoleKey)) == record::role_name(record::Role::snapshot))
      snapshots += message.data.size();
  }
  EXPECT_GT(snapshots, 0u);
  EXPECT_LE(snapshots * 9, all);
}

TEST(StreamLog, StreamsThatEndedGiveWay) {
  record::LogOptions options;
  options.max_snapshot_bytes = 4 * description(1).size();
  MemoryLog memory(options);
  for (uint64_t stream = 1; stream <= 10; ++stream) {  // one after another: there is room for each
    ASSERT_TRUE(memory.take(description(stream, "s" + std::to_string(stream)), stream, stream));
    ASSERT_TRUE(memory.take(edit(stream, 1, "link_0", false), stream, stream));
    ASSERT_TRUE(memory.take(frame(stream, 1), stream, stream));
    if (stream < 10) memory.log.end_peer(stream);
  }
  EXPECT_EQ(memory.log.refused(), 0u);
  EXPECT_EQ(memory.log.dropped_edits(), 0u);
  // A stream without a slot returns and continues.
  ASSERT_TRUE(memory.take(description(1, "s1"), 11, 1));
  ASSERT_TRUE(memory.take(frame(1, 2), 12, 1));
  EXPECT_EQ(memory.log.streams().at(0).frames, 2u);
  // Live streams keep their slots.
  for (uint64_t stream = 20; stream < 25; ++stream)
    ASSERT_TRUE(memory.take(description(stream, "s" + std::to_string(stream)), 13, stream));
  const uint64_t refused = memory.log.refused();
  EXPECT_GT(refused, 0u);
  ASSERT_TRUE(memory.take(frame(1, 3), 14, 1));
  EXPECT_EQ(memory.log.refused(), refused);
}

TEST(StreamLog, TickEndsOldChunk) {
  MemoryLog memory;  // chunks of a megabyte or a second
  ASSERT_TRUE(memory.take(description(7), 0));
  ASSERT_TRUE(memory.take(frame(7, 1), 1));
  const size_t before = memory.files[0]->size();
  ASSERT_TRUE(memory.log.tick(kBegun_ns + 900 * kMs).ok());
  EXPECT_EQ(memory.files[0]->size(), before);
  ASSERT_TRUE(memory.log.tick(kBegun_ns + 1100 * kMs).ok());
  EXPECT_GT(memory.files[0]->size(), before);
  // Everything is readable without the end of the file.
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok());
  EXPECT_EQ(played_from(*playback).size(), 2u);
}

TEST(StreamLog, CountsWhatIsMissing) {
  MemoryLog memory;
  memory.take(frame(7, 1), 0);  // before its description
  memory.take(description(7), 0);
  memory.take(frame(9, 1), 0);  // of another epoch
  memory.take(Bytes(100), 0);
  for (const uint64_t sequence : {1u, 2u, 5u, 4u, 6u}) memory.take(frame(7, sequence), sequence);
  const record::StreamSeen seen = memory.log.streams().at(0);
  EXPECT_EQ(seen.frames, 4u);
  EXPECT_EQ(seen.missing, 2u);
  EXPECT_EQ(seen.late, 1u);
  EXPECT_EQ(memory.log.refused(), 3u);
  EXPECT_TRUE(seen.live);
  // After a reconnect the same stream continues without a new description.
  memory.log.end_peer(1);
  EXPECT_FALSE(memory.log.streams().at(0).live);
  memory.take(description(7), 10, 2);
  memory.take(frame(7, 7), 11, 2);
  ASSERT_EQ(memory.log.streams().size(), 1u);
  EXPECT_EQ(memory.log.streams()[0].frames, 5u);
  // Two simultaneous streams of one name are two streams.
  memory.take(description(70), 12, 3);
  ASSERT_EQ(memory.log.streams().size(), 2u);
  EXPECT_EQ(memory.log.streams()[1].name, "arm_2");
}

// An edit of an unknown property, as a later minor version may send it.
Bytes unknown_edit(uint64_t epoch, uint64_t version) {
  const Bytes known = edit(epoch, version, "link_0", true);
  wire::Decoder decoder;
  for (size_t i = 0; i < known.size(); ++i) {
    Bytes changed = known;
    changed[i] = std::byte{200};
    const auto decoded = decoder.decode(changed);
    if (!decoded) continue;
    const auto* later = std::get_if<wire::UnknownEdit>(&*decoded);
    if (later != nullptr && later->epoch == epoch && later->version == version) return changed;
  }
  ADD_FAILURE() << "no byte makes it unknown";
  return known;
}

TEST(StreamLog, UnknownEditsAreInSnapshots) {
  record::LogOptions options = small_chunks();
  options.split_bytes = 8'000;
  MemoryLog memory(options);
  ASSERT_TRUE(memory.take(description(7), 0));
  const std::vector<Bytes> edits{edit(7, 1, "link_0", false), unknown_edit(7, 2), edit(7, 3, "link_1", false),
                                 unknown_edit(7, 4)};
  for (const Bytes& each : edits) ASSERT_TRUE(memory.take(each, 1));
  for (uint64_t s = 1; s <= 100; ++s) ASSERT_TRUE(memory.take(frame(7, s), s));
  ASSERT_TRUE(memory.log.finish().ok());
  ASSERT_GT(memory.files.size(), 1u);
  auto playback = Playback::open(source_of(*memory.files[1]));
  ASSERT_TRUE(playback.ok());
  for (const uint64_t ms : {0u, 99u}) {
    ms == 0 ? playback->rewind() : playback->seek(kBegun_ns + ms * kMs);
    std::vector<Bytes> got;
    for (PlayedMessage& played : played_from(*playback))
      if (played.kind == Played::Kind::edit) got.push_back(std::move(played.message));
    EXPECT_EQ(got, edits) << ms;
  }
}

// A stream that another connection took over does not end with its previous connection.
TEST(StreamLog, TakeoverIsExclusive) {
  MemoryLog memory;
  ASSERT_TRUE(memory.take(description(7), 0, 1));
  ASSERT_TRUE(memory.take(wire::encode(wire::Goodbye{7}), 1, 1));  // and stays connected
  ASSERT_TRUE(memory.take(description(8), 2, 2));
  memory.log.end_peer(1);
  ASSERT_EQ(memory.log.streams().size(), 1u);
  EXPECT_TRUE(memory.log.streams()[0].live);
  ASSERT_TRUE(memory.take(frame(8, 1), 3, 2));
  EXPECT_EQ(memory.log.refused(), 0u);
  // The same run over another connection, before the time-out of the first one.
  ASSERT_TRUE(memory.take(description(8), 4, 3));
  ASSERT_TRUE(memory.take(frame(8, 2), 5, 3));
  memory.log.end_peer(2);
  ASSERT_EQ(memory.log.streams().size(), 1u);
  EXPECT_TRUE(memory.log.streams()[0].live);
  EXPECT_EQ(memory.log.streams()[0].frames, 2u);
  memory.log.end_peer(3);
  EXPECT_FALSE(memory.log.streams()[0].live);
}

// Sink that blocks while it is stuck.
class StuckSink final : public record::Sink {
 public:
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    bool is_stuck = false, is_waited_for = false;
  };
  explicit StuckSink(State& state) : state_(state) {}
  Result<void> append(std::span<const std::byte>) override {
    std::unique_lock lock(state_.mutex);
    state_.is_waited_for = state_.is_stuck;
    state_.changed.notify_all();
    state_.changed.wait(lock, [&] { return !state_.is_stuck; });
    return {};
  }
  Result<void> truncate(uint64_t) override { return {}; }
  const std::string& name() const override { return name_; }

 private:
  State& state_;
  std::string name_ = "stuck";
};

TEST(LogThread, WritesInProgressAreWaiting) {
  StuckSink::State disk;
  record::LogThread log(record::StreamLog(
                            [&](uint32_t) -> Result<std::unique_ptr<record::Sink>> {
                              return std::unique_ptr<record::Sink>(std::make_unique<StuckSink>(disk));
                            },
                            {}, small_chunks(1000)),
                        5000);
  const Bytes large = frame(7, 1, 80), small = edit(7, 1, "link_0", false);
  ASSERT_TRUE(large.size() > 3000 && large.size() < 4500) << large.size() << ": one has room, two have not";
  log.take(1, description(7, "arm", 80), 0, false);
  const auto begun = std::chrono::steady_clock::now();
  const auto hangs = [&] { return std::chrono::steady_clock::now() - begun > std::chrono::minutes(2); };
  const auto look_again = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
  while (log.status().streams.empty() && !hangs()) look_again();
  {
    std::unique_lock lock(disk.mutex);
    disk.is_stuck = true;
  }
  log.take(1, large, 0, true);
  {
    std::unique_lock lock(disk.mutex);
    EXPECT_TRUE(disk.changed.wait_for(lock, std::chrono::minutes(2), [&] { return disk.is_waited_for; }));
  }
  EXPECT_EQ(log.status().unwritten, 0u);
  log.take(1, large, 0, true);
  EXPECT_EQ(log.status().unwritten, 1u) << "the first is in memory, too";
  log.take(1, small, 0, true);
  EXPECT_EQ(log.status().unwritten, 1u) << "there is room for that";
  {
    std::unique_lock lock(disk.mutex);
    disk.is_stuck = false;
  }
  disk.changed.notify_all();
  // The whole buffer becomes free again.
  for (; !hangs(); look_again()) {
    const uint64_t unwritten = log.status().unwritten;
    log.take(1, frame(7, 2, 80), 0, true);
    if (log.status().unwritten == unwritten) break;
  }
  log.finish();
  EXPECT_EQ(log.status().streams.at(0).frames, 2u);
}

}  // namespace
}  // namespace fire3dv::record_test
