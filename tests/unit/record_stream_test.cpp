// Streams in recordings: what came is what is played, from the start and from anywhere.
#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/replay/pacer.h"
#include "protocol/replay/stream_player.h"
#include "tests/unit/record_files.h"

namespace fire3dv::record_test {
namespace {

using record::Playback;
using record::Played;

struct Told {
  Played::Kind kind;
  size_t stream;
  uint64_t edit_key;
  Bytes message;
};

std::vector<Told> played_from(Playback& playback) {
  std::vector<Told> result;
  Played played;
  for (;;) {
    const auto step = playback.next(played);
    if (step == Playback::Step::end) return result;
    if (step == Playback::Step::played)
      result.push_back(
          {played.kind, played.stream, played.edit_key, Bytes(played.message.begin(), played.message.end())});
  }
}

record::LogOptions small_chunks(size_t bytes = 1500) {
  record::LogOptions options;
  options.writer.chunk_bytes = bytes;
  return options;
}

// Two streams side by side; what was sent, in order.
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

TEST(RecordStream, ARecordingIsTheStreamByteByByte) {
  MemoryLog memory(small_chunks());
  const std::vector<Bytes> sent = two_streams(memory, 300);
  ASSERT_TRUE(memory.log.finish().ok());
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok());
  ASSERT_EQ(playback->streams().size(), 2u);
  EXPECT_EQ(playback->streams()[0].name, "arm");
  EXPECT_EQ(playback->streams()[1].name, "crane");
  // Snapshots are in the file, and none of them is played.
  EXPECT_NE(playback->streams()[0].channels[static_cast<size_t>(record::Role::snapshot)], 0);
  playback->rewind();
  std::vector<Bytes> got;
  for (Told& told : played_from(*playback)) got.push_back(std::move(told.message));
  EXPECT_EQ(got, sent);
  playback->rewind();
  EXPECT_EQ(played_from(*playback).size(), sent.size());
}

TEST(RecordStream, SeekingGivesWhatIsInForceFirst) {
  MemoryLog memory(small_chunks());
  two_streams(memory, 300);
  ASSERT_TRUE(memory.log.finish().ok());
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok());
  for (uint64_t ms = 1; ms <= 300; ms += 13) {
    playback->seek(kBegun_ns + ms * kMs);
    const std::vector<Told> told = played_from(*playback);
    // The newest edit of each node before that moment, by version.
    std::vector<Bytes> expected{description(7)};
    for (uint64_t version = ms < 30 ? 10 : (ms - 1) / 10 * 10 - 20; version < ms; version += 10)
      expected.push_back(edit(7, version, "link_" + std::to_string(version / 10 % 3), version % 20 == 0));
    expected.push_back(description(8, "crane", 2));
    ASSERT_GT(told.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(told[i].message, expected[i]) << ms << " " << i;
    // And then the stream from there on.
    const Bytes first =
        ms % 10 == 0 ? edit(7, ms, "link_" + std::to_string(ms / 10 % 3), ms % 20 == 0) : frame(7, ms);
    EXPECT_EQ(told[expected.size()].message, first) << ms;
  }
  playback->seek(kBegun_ns + 1000 * kMs);
  // The arm has said goodbye; the crane is still there.
  const std::vector<Told> end = played_from(*playback);
  ASSERT_EQ(end.size(), 1u);
  EXPECT_EQ(end[0].message, description(8, "crane", 2));
}

TEST(RecordStream, FilesThatWereBegunInTheMiddleStandAlone) {
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
    const std::vector<Told> told = played_from(*playback);
    ASSERT_EQ(told[0].kind, Played::Kind::description);
    // Each begins with what is in force; that was sent once.
    for (const Told& each : told)
      if (i == 0 || (each.kind != Played::Kind::description &&
                     (each.kind != Played::Kind::edit || std::ranges::find(got, each.message) == got.end())))
        got.push_back(each.message);
  }
  EXPECT_EQ(got, sent);
}

TEST(RecordStream, WhatIsAttachedFillsNoFile) {
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

// Each file of a series describes a stream before it says anything else of it, and says it first where it was
// said first.
TEST(RecordStream, NoFrameIsInAFileWithoutItsDescription) {
  record::LogOptions options;  // one chunk for each file: what comes back comes back in the middle of one
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
  for (Told& told : played_from(*playback))
    if (playback->streams()[told.stream].name == "arm") of_arm.push_back(std::move(told.message));
  EXPECT_EQ(of_arm, (std::vector<Bytes>{description(7), edit(7, 1, "link_0", false), frame(7, 2)}));
}

TEST(RecordStream, AStreamDescribesItselfBeforeASnapshotDoes) {
  MemoryLog memory(small_chunks(1));  // each message begins a chunk
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

TEST(RecordStream, SnapshotsOfManyStreamsTakeNoMoreThanANinth) {
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

TEST(RecordStream, StreamsThatEndedGiveWay) {
  record::LogOptions options;
  options.most_kept_bytes = 4 * description(1).size();
  MemoryLog memory(options);
  for (uint64_t stream = 1; stream <= 10; ++stream) {  // one after another: there is room for each
    ASSERT_TRUE(memory.take(description(stream, "s" + std::to_string(stream)), stream, stream));
    ASSERT_TRUE(memory.take(edit(stream, 1, "link_0", false), stream, stream));
    ASSERT_TRUE(memory.take(frame(stream, 1), stream, stream));
    if (stream < 10) memory.log.end_peer(stream);
  }
  EXPECT_EQ(memory.log.refused(), 0u);
  EXPECT_EQ(memory.log.unkept_edits(), 0u);
  // One that was forgotten comes back, and goes on.
  ASSERT_TRUE(memory.take(description(1, "s1"), 11, 1));
  ASSERT_TRUE(memory.take(frame(1, 2), 12, 1));
  EXPECT_EQ(memory.log.streams().at(0).frames, 2u);
  // Those that live give way to none.
  for (uint64_t stream = 20; stream < 25; ++stream)
    ASSERT_TRUE(memory.take(description(stream, "s" + std::to_string(stream)), 13, stream));
  const uint64_t refused = memory.log.refused();
  EXPECT_GT(refused, 0u);
  ASSERT_TRUE(memory.take(frame(1, 3), 14, 1));
  EXPECT_EQ(memory.log.refused(), refused);
}

TEST(RecordStream, SeekingKeepsNoMoreThanItMay) {
  MemoryLog memory;
  constexpr uint64_t kEdits = 8000;
  ASSERT_TRUE(memory.take(description(7), 0));
  for (uint64_t i = 1; i <= kEdits; ++i)
    ASSERT_TRUE(memory.take(edit(7, i, std::to_string(i) + std::string(200, 'n'), true), i));
  ASSERT_TRUE(memory.take(frame(7, 1), kEdits + 2));
  ASSERT_TRUE(memory.log.finish().ok());
  constexpr uint64_t kMemoryBytes = 8 << 20;  // two of them for state, and one of these for names
  auto playback = Playback::open(source_of(*memory.files[0]), {kMemoryBytes});
  ASSERT_TRUE(playback.ok()) << playback.error().message;
  playback->seek(kBegun_ns + (kEdits + 1) * kMs);
  uint64_t kept_bytes = 0;
  for (const Told& told : played_from(*playback))
    if (told.kind == Played::Kind::edit) kept_bytes += told.message.size();
  EXPECT_GT(kept_bytes, 0u);
  EXPECT_LE(kept_bytes, kMemoryBytes / 8);  // with the names in memory, too
  EXPECT_GT(playback->refused(), 0u);
}

TEST(RecordStream, AnOldChunkEndsAndATickEndsIt) {
  MemoryLog memory;  // a megabyte, and a second
  ASSERT_TRUE(memory.take(description(7), 0));
  ASSERT_TRUE(memory.take(frame(7, 1), 1));
  const size_t before = memory.files[0]->size();
  ASSERT_TRUE(memory.log.tick(kBegun_ns + 900 * kMs).ok());
  EXPECT_EQ(memory.files[0]->size(), before);
  ASSERT_TRUE(memory.log.tick(kBegun_ns + 1100 * kMs).ok());
  EXPECT_GT(memory.files[0]->size(), before);
  // All of it is there without any end of the file.
  auto playback = Playback::open(source_of(*memory.files[0]));
  ASSERT_TRUE(playback.ok());
  EXPECT_EQ(played_from(*playback).size(), 2u);
}

TEST(RecordStream, CountsWhatIsMissing) {
  MemoryLog memory;
  memory.take(frame(7, 1), 0);  // of a stream that has not described itself
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
  // The link came back: the same stream goes on, and is not described again.
  memory.log.end_peer(1);
  EXPECT_FALSE(memory.log.streams().at(0).live);
  memory.take(description(7), 10, 2);
  memory.take(frame(7, 7), 11, 2);
  ASSERT_EQ(memory.log.streams().size(), 1u);
  EXPECT_EQ(memory.log.streams()[0].frames, 5u);
  // Two of one name at once are two streams.
  memory.take(description(70), 12, 3);
  ASSERT_EQ(memory.log.streams().size(), 2u);
  EXPECT_EQ(memory.log.streams()[1].name, "arm_2");
}

// As a later minor version would send it: a property that nobody here knows.
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

TEST(RecordStream, EditsThatNobodyKnowsAreInSnapshotsToo) {
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
    for (Told& told : played_from(*playback))
      if (told.kind == Played::Kind::edit) got.push_back(std::move(told.message));
    EXPECT_EQ(got, edits) << ms;
  }
}

// A stream that somebody else goes on with is not ended by the one who had it before.
TEST(RecordStream, WhoTakesAStreamOverHasItAlone) {
  MemoryLog memory;
  ASSERT_TRUE(memory.take(description(7), 0, 1));
  ASSERT_TRUE(memory.take(wire::encode(wire::Goodbye{7}), 1, 1));  // and stays connected
  ASSERT_TRUE(memory.take(description(8), 2, 2));
  memory.log.end_peer(1);
  ASSERT_EQ(memory.log.streams().size(), 1u);
  EXPECT_TRUE(memory.log.streams()[0].live);
  ASSERT_TRUE(memory.take(frame(8, 1), 3, 2));
  EXPECT_EQ(memory.log.refused(), 0u);
  // The same run over another connection, before anybody notices that the first one is gone.
  ASSERT_TRUE(memory.take(description(8), 4, 3));
  ASSERT_TRUE(memory.take(frame(8, 2), 5, 3));
  memory.log.end_peer(2);
  ASSERT_EQ(memory.log.streams().size(), 1u);
  EXPECT_TRUE(memory.log.streams()[0].live);
  EXPECT_EQ(memory.log.streams()[0].frames, 2u);
  memory.log.end_peer(3);
  EXPECT_FALSE(memory.log.streams()[0].live);
}

TEST(RecordStream, ADamagedDescriptionIsRepairedByTheNextSnapshot) {
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
  const std::vector<Told> told = played_from(*playback);
  const auto described = std::ranges::find(told, description(7), &Told::message);
  ASSERT_NE(described, told.end());
  EXPECT_LT(described - told.begin(), 100);
}

// --- playing onto a link

class FakeLink final : public transport::PublisherLink {
 public:
  explicit FakeLink(size_t most_bytes, bool partial) : most_bytes_(most_bytes), partial_(partial) {}
  size_t max_pose_message_bytes() const override { return most_bytes_; }
  Result<void> set_description(std::span<const std::byte> message) override { return put(message); }
  Result<void> put_state(uint64_t key, transport::SharedBytes message) override {
    keys.push_back(key);
    return put(*message);
  }
  bool publish(const wire::MessagePieces& message, bool) noexcept override {
    Bytes whole(message.head.begin(), message.head.end());
    whole.insert(whole.end(), message.body.begin(), message.body.end());
    sent.push_back(std::move(whole));
    return true;
  }
  bool takes_partial_frames() const override { return partial_; }
  bool publish_partial(const wire::MessagePieces& partial,
                       std::span<const wire::MessagePieces>) noexcept override {
    return publish(partial, true);
  }
  void send_control(std::span<const std::byte> message) noexcept override { (void)put(message); }
  bool poll(std::vector<std::byte>&) override { return false; }
  transport::LinkStats stats() const override { return {}; }

  std::vector<Bytes> sent;
  std::vector<uint64_t> keys;

 private:
  Result<void> put(std::span<const std::byte> message) {
    sent.emplace_back(message.begin(), message.end());
    return {};
  }
  size_t most_bytes_;
  bool partial_;
};

struct OnLink {
  OnLink(size_t most_bytes, bool partial, bool verbatim) {
    auto made = std::make_unique<FakeLink>(most_bytes, partial);
    link = made.get();
    player = std::make_unique<replay::StreamPlayer>(std::move(made), verbatim);
  }
  void play(const Bytes& message, Played::Kind kind = Played::Kind::pose, uint64_t key = 0) {
    EXPECT_TRUE(player->play({kind, 0, 0, key, message}).ok());
  }
  wire::PoseFrameView frame_at(size_t i) {
    auto decoded = decoder.decode(link->sent.at(i));
    EXPECT_TRUE(decoded.ok());
    return std::get<wire::PoseFrameView>(*decoded);
  }
  FakeLink* link;
  std::unique_ptr<replay::StreamPlayer> player;
  wire::Decoder decoder;
};

TEST(StreamPlayer, VerbatimIsWhatWasRecorded) {
  OnLink on(1 << 20, true, true);
  const std::vector<Bytes> messages{description(7), edit(7, 1, "link_0", false), frame(7, 1), frame(7, 2)};
  on.play(messages[0], Played::Kind::description);
  on.play(messages[1], Played::Kind::edit, 5);
  on.play(messages[2]);
  on.play(messages[3]);
  EXPECT_EQ(on.link->sent, messages);
  EXPECT_EQ(on.link->keys, std::vector<uint64_t>{5});
  on.play(frame(7, 1));  // stale
  EXPECT_EQ(on.player->counts().skipped, 1u);
}

TEST(StreamPlayer, ElseTimesAreThoseOfNowAndNothingElseChanges) {
  OnLink on(1 << 20, true, false);
  on.play(description(7), Played::Kind::description);
  on.play(frame(7, 3));
  const wire::PoseFrameView sent = on.frame_at(1);
  EXPECT_EQ(sent.header.epoch, 7u);
  EXPECT_EQ(sent.header.sequence, 3u);
  EXPECT_EQ(sent.header.sim_time_ns, static_cast<int64_t>(3 * kMs));
  EXPECT_EQ(sent.header.flags, 0u);
  EXPECT_EQ(sent.poses[1].m[3], 31.f);
  EXPECT_NE(sent.header.publish_time_ns, 1000 + 3 * kMs);
  wire::Decoder decoder;
  const auto told = decoder.decode(on.link->sent[0]);
  ASSERT_TRUE(told.ok());
  EXPECT_NE(std::get<wire::StreamDescription>(*told).clock.boot_id, "boot");
}

TEST(StreamPlayer, ALinkIsGivenSoManyEditsAndNoMore) {
  OnLink on(1 << 20, true, true);
  on.play(description(7), Played::Kind::description);
  const Bytes one = edit(7, 1, "link_0", false);
  for (uint64_t key = 0; key < 65'546; ++key) on.play(one, Played::Kind::edit, key);
  EXPECT_EQ(on.link->keys.size(), 65'536u);
  EXPECT_EQ(on.player->counts().unkept_edits, 10u);
  on.play(one, Played::Kind::edit, 5);  // one that is there is replaced
  EXPECT_EQ(on.link->keys.size(), 65'537u);
  on.play(description(8), Played::Kind::description);
  on.play(edit(8, 1, "link_0", false), Played::Kind::edit, 70'000);
  EXPECT_EQ(on.link->keys.size(), 65'538u);
}

TEST(StreamPlayer, ALoopIsANewRunAndSaysThatItJumped) {
  OnLink on(1 << 20, true, true);
  for (int pass = 0; pass < 2; ++pass) {
    if (pass != 0) on.player->jump(true);
    on.play(description(7), Played::Kind::description);
    on.play(edit(7, 1, "link_0", false), Played::Kind::edit, 1);
    on.play(frame(7, 1));
    on.play(frame(7, 2));
  }
  ASSERT_EQ(on.link->sent.size(), 8u);
  const uint64_t epoch = on.frame_at(6).header.epoch;
  EXPECT_NE(epoch, 7u);
  EXPECT_EQ(on.frame_at(6).header.flags, wire::kFrameDiscontinuity);
  EXPECT_EQ(on.frame_at(7).header.epoch, epoch);
  EXPECT_EQ(on.frame_at(7).header.flags, 0u);
  wire::Decoder decoder;
  const auto edited = decoder.decode(on.link->sent[5]);
  ASSERT_TRUE(edited.ok());
  EXPECT_EQ(std::get<wire::SceneEdit>(*edited).epoch, epoch);
}

TEST(StreamPlayer, FramesAreCutAndPutTogetherAsTheLinkNeeds) {
  constexpr uint32_t kNodes = 50;
  const Bytes whole = frame(7, 1, kNodes);
  OnLink datagrams(1148, true, true);
  datagrams.play(description(7, "arm", kNodes), Played::Kind::description);
  datagrams.play(whole);
  ASSERT_EQ(datagrams.link->sent.size(), 4u);  // the description, and three parts of at most 21
  // Those parts, recorded, onto a link that takes whole frames.
  OnLink memory(1 << 20, false, true);
  memory.play(description(7, "arm", kNodes), Played::Kind::description);
  for (size_t i = 1; i < datagrams.link->sent.size(); ++i) {
    EXPECT_LE(datagrams.link->sent[i].size(), 1148u);
    memory.play(datagrams.link->sent[i]);
  }
  ASSERT_EQ(memory.link->sent.size(), 2u);
  const wire::PoseFrameView together = memory.frame_at(1);
  ASSERT_EQ(together.poses.size(), kNodes);
  EXPECT_EQ(together.poses[49].m[3], 59.f);
  // A frame of which a part is missing is not played.
  const Bytes first_part = datagrams.link->sent[1];
  OnLink lost(1 << 20, false, true);
  lost.play(description(7, "arm", kNodes), Played::Kind::description);
  lost.play(first_part);
  lost.play(frame(7, 2, kNodes));
  EXPECT_EQ(lost.player->counts().incomplete, 1u);
  EXPECT_EQ(lost.player->counts().frames, 1u);
}

TEST(StreamPlayer, PartialFramesBuildOnWholeOnes) {
  const std::vector<uint32_t> indices{1};
  std::vector<wire::Affine3x4> poses(1);
  poses[0].m[3] = 99;
  wire::PoseFrameView view;
  view.header = {7, 2, 0, 0, 0, 0};
  view.node_count = 3;
  view.poses = poses;
  view.node_indices = indices;
  const Bytes partial = wire::encode(view);
  for (const bool takes_partial : {true, false}) {
    OnLink on(1 << 20, takes_partial, true);
    on.play(description(7), Played::Kind::description);
    on.play(partial);  // nothing to build on
    EXPECT_EQ(on.player->counts().skipped, 1u);
    on.play(frame(7, 1));
    on.play(partial);
    ASSERT_EQ(on.link->sent.size(), 3u);
    if (takes_partial) {
      EXPECT_EQ(on.link->sent[2], partial);
    } else {
      const wire::PoseFrameView whole = on.frame_at(2);
      ASSERT_EQ(whole.poses.size(), 3u);
      EXPECT_EQ(whole.poses[0].m[3], 10.f);
      EXPECT_EQ(whole.poses[1].m[3], 99.f);
    }
  }
}

TEST(Pacer, FollowsLogTimes) {
  replay::Pacer pacer(2);
  EXPECT_EQ(pacer.wait_ns(1000, 50), 0);
  EXPECT_EQ(pacer.wait_ns(3000, 50), 1000);
  EXPECT_EQ(pacer.wait_ns(3000, 1050), 0);
  EXPECT_EQ(pacer.wait_ns(3000, 9999), 0);  // late is not waited for
  EXPECT_EQ(pacer.wait_ns(500, 50), 0);
  pacer.restart();
  EXPECT_EQ(pacer.wait_ns(9000, 100), 0);
  EXPECT_GT(pacer.wait_ns(UINT64_MAX, 100), int64_t{1} << 40);
  EXPECT_EQ(replay::Pacer(0).wait_ns(9000, 100), 0);
}

}  // namespace
}  // namespace fire3dv::record_test
