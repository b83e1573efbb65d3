// Test of stream playback from recordings: replayed messages equal the recorded ones, from the start and from
// any time.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

// Records two parallel streams; returns the sent messages in order.
std::vector<Bytes> two_streams(MemoryLog& memory, uint64_t frames) {
  std::vector<Bytes> sent;
  const auto send = [&](Bytes message, uint64_t at_ms, uint64_t peer) {
    ASSERT_TRUE(memory.take(message, at_ms, peer));
    sent.push_back(std::move(message));
  };
  send(description(7), 0, 1);
  send(description(8, "crane", 2), 0, 2);
  for (uint64_t i = 1; i <= frames; ++i) {
    if (i % 10 == 0) send(edit(7, i, "link_" + std::to_string(i / 10 % 3), i % 20 == 0), i, 1);
    send(frame(7, i), i, 1);
    if (i % 3 == 0) send(frame(8, i / 3, 2), i, 2);
  }
  send(wire::encode(wire::Goodbye{7}), frames + 1, 1);
  return sent;
}

TEST(RecordStream, RecordingMatchesStream) {
  MemoryLog memory(small_chunks());
  const std::vector<Bytes> sent = two_streams(memory, 300);
  ASSERT_TRUE(memory.log.finish().ok());
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok());
  ASSERT_EQ(playback->streams().size(), 2u);
  EXPECT_EQ(playback->streams()[0].name, "arm");
  EXPECT_EQ(playback->streams()[1].name, "crane");
  // The file contains snapshots, and playback skips them.
  EXPECT_NE(playback->streams()[0].channels[static_cast<size_t>(record::Role::snapshot)], 0);
  playback->rewind();
  std::vector<Bytes> got;
  for (PlayedMessage& played : played_from(*playback)) got.push_back(std::move(played.message));
  EXPECT_EQ(got, sent);
  playback->rewind();
  EXPECT_EQ(played_from(*playback).size(), sent.size());
}

// Of a key only the newest value is in force, but a recording has each value in between.
TEST(RecordStream, ScalarsArePlayed) {
  MemoryLog memory(small_chunks());
  std::vector<Bytes> sent{description(7)};
  const auto add = [&](uint64_t version, wire::Property property, wire::EditValue value) {
    sent.push_back(wire::encode(wire::SceneEdit{7, version, "arm", property, std::move(value)}));
  };
  add(1, wire::Property::scalars, wire::Scalars{{"energy"}, {"J"}});
  for (int step = 1; step <= 300; ++step) {
    add(static_cast<uint64_t>(1 + step), wire::Property::scalar_values,
        wire::ScalarValues{1, step, {0.5 * step}});
    sent.push_back(frame(7, static_cast<uint64_t>(step)));
  }
  for (size_t i = 0; i < sent.size(); ++i) ASSERT_TRUE(memory.take(sent[i], i / 2));
  ASSERT_TRUE(memory.log.finish().ok());
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok());
  playback->rewind();
  std::vector<Bytes> got;
  for (PlayedMessage& played : played_from(*playback)) got.push_back(std::move(played.message));
  EXPECT_EQ(got, sent);
}

TEST(RecordStream, SeekStartsWithState) {
  MemoryLog memory(small_chunks());
  two_streams(memory, 300);
  ASSERT_TRUE(memory.log.finish().ok());
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok());
  for (uint64_t ms = 1; ms <= 300; ms += 13) {
    playback->seek(kBegun_ns + ms * kMs);
    const std::vector<PlayedMessage> played = played_from(*playback);
    // The newest edit of each node before that time, by version.
    std::vector<Bytes> expected{description(7)};
    for (uint64_t version = ms < 30 ? 10 : (ms - 1) / 10 * 10 - 20; version < ms; version += 10)
      expected.push_back(edit(7, version, "link_" + std::to_string(version / 10 % 3), version % 20 == 0));
    expected.push_back(description(8, "crane", 2));
    ASSERT_GT(played.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(played[i].message, expected[i]) << ms << " " << i;
    // Then the stream from that time on.
    const Bytes first =
        ms % 10 == 0 ? edit(7, ms, "link_" + std::to_string(ms / 10 % 3), ms % 20 == 0) : frame(7, ms);
    EXPECT_EQ(played[expected.size()].message, first) << ms;
  }
  playback->seek(kBegun_ns + 1000 * kMs);
  // The arm has ended; the crane is still active.
  const std::vector<PlayedMessage> end = played_from(*playback);
  ASSERT_EQ(end.size(), 1u);
  EXPECT_EQ(end[0].message, description(8, "crane", 2));
}

TEST(RecordStream, LaterFilesStandAlone) {
  record::LogOptions options = small_chunks();
  options.split_bytes = 12'000;
  MemoryLog memory(options);
  const std::vector<Bytes> sent = two_streams(memory, 300);
  ASSERT_TRUE(memory.log.finish().ok());
  ASSERT_GT(memory.files.size(), 3u);
  std::vector<Bytes> got;
  for (size_t i = 0; i < memory.files.size(); ++i) {
    auto playback = Playback::open(source_of(*memory.files[i]));
    ASSERT_TRUE(playback.ok());
    playback->rewind();
    const std::vector<PlayedMessage> played = played_from(*playback);
    ASSERT_EQ(played[0].kind, Played::Kind::description);
    // Each file begins with the current state, which was sent once.
    for (const PlayedMessage& each : played)
      if (i == 0 || (each.kind != Played::Kind::description &&
                     (each.kind != Played::Kind::edit || std::ranges::find(got, each.message) == got.end())))
        got.push_back(each.message);
  }
  EXPECT_EQ(got, sent);
}

TEST(RecordStream, SeekMemoryIsBounded) {
  MemoryLog memory;
  constexpr uint64_t kEdits = 8000;
  ASSERT_TRUE(memory.take(description(7), 0));
  for (uint64_t i = 1; i <= kEdits; ++i)
    ASSERT_TRUE(memory.take(edit(7, i, std::to_string(i) + std::string(200, 'n'), true), i));
  ASSERT_TRUE(memory.take(frame(7, 1), kEdits + 2));
  ASSERT_TRUE(memory.log.finish().ok());
  constexpr uint64_t kMemoryBytes = 8 << 20;  // 2 MiB for state, and 1 MiB of these for names
  auto playback = Playback::open(source_of(*memory.files[0]), {kMemoryBytes});
  ASSERT_TRUE(playback.ok()) << playback.error().message;
  playback->seek(kBegun_ns + (kEdits + 1) * kMs);
  uint64_t kept_bytes = 0;
  for (const PlayedMessage& played : played_from(*playback))
    if (played.kind == Played::Kind::edit) kept_bytes += played.message.size();
  EXPECT_GT(kept_bytes, 0u);
  EXPECT_LE(kept_bytes, kMemoryBytes / 8);  // with the names in memory, too
  EXPECT_GT(playback->refused(), 0u);
}

TEST(RecordStream, SnapshotRepairsDescription) {
  MemoryLog memory(small_chunks());
  two_streams(memory, 300);
  ASSERT_TRUE(memory.log.finish().ok());
  Bytes file = *memory.files[0];
  {
    auto reader = record::Reader::open(source_of(file));
    ASSERT_TRUE(reader.ok());
    file[reader->index().chunks[0].offset + 80] ^= std::byte{1};
  }
  auto playback = Playback::open(source_of(file));
  ASSERT_TRUE(playback.ok());
  playback->rewind();
  const std::vector<PlayedMessage> played = played_from(*playback);
  const auto described = std::ranges::find(played, description(7), &PlayedMessage::message);
  ASSERT_NE(described, played.end());
  EXPECT_LT(described - played.begin(), 100);
}

}  // namespace
}  // namespace fire3dv::record_test
