// Test of MCAP files: round trip, seek by time, and checksums.
#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/record/channels.h"
#include "protocol/record/damage.h"
#include "protocol/record/mcap/bytes.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

using record::Compression;
using record::Reader;

Bytes bytes_of(std::string_view text) {
  const auto span = std::as_bytes(std::span(text));
  return {span.begin(), span.end()};
}

TEST(Crc32, IsThatOfZlib) {
  EXPECT_EQ(record::crc32(bytes_of("123456789")), 0xcbf43926u);
  // Whole steps and a remainder, at once and in pieces.
  const Bytes text = bytes_of("The quick brown fox jumps over the lazy dog");
  EXPECT_EQ(record::crc32(text), 0x414fa339u);
  for (size_t cut = 0; cut <= text.size(); ++cut)
    EXPECT_EQ(record::crc32(std::span(text).subspan(cut), record::crc32(std::span(text).first(cut))),
              0x414fa339u);
  EXPECT_EQ(record::crc32({}), 0u);
}

// Long inputs use another code path than short ones.
TEST(Crc32, PiecesGiveSameChecksum) {
  Bytes bytes(700);
  uint32_t random = 1;
  for (std::byte& byte : bytes) byte = static_cast<std::byte>((random = random * 1664525 + 1013904223) >> 24);
  for (size_t from = 0; from < 20; ++from)
    for (size_t length = 0; from + length <= bytes.size(); length += length < 300 ? 1 : 13) {
      const auto piece = std::span<const std::byte>(bytes).subspan(from, length);
      uint32_t expected = 77;
      for (size_t i = 0; i < length; ++i) expected = record::crc32(piece.subspan(i, 1), expected);
      ASSERT_EQ(record::crc32(piece, 77), expected) << from << " " << length;
    }
}

class RecordFormat : public testing::TestWithParam<Compression> {};
INSTANTIATE_TEST_SUITE_P(Compressions, RecordFormat,
                         testing::Values(Compression::none, Compression::zstd, Compression::lz4));

TEST_P(RecordFormat, MessagesRoundTrip) {
  Bytes file;
  record::WriterOptions options{GetParam(), 4096};
  auto writer = record::Writer::open(std::make_unique<record::MemorySink>(file), options);
  ASSERT_TRUE(writer.ok());
  const auto schema = writer->add_schema("a.Table", "flatbuffer", record::message_schema());
  ASSERT_TRUE(schema.ok());
  const auto first = writer->add_channel(*schema, "/first", "flatbuffer", {{"key", "value"}, {"k2", ""}});
  const auto second = writer->add_channel(0, "/second", "raw", {});
  ASSERT_TRUE(first.ok() && second.ok());
  std::vector<LoggedMessage> written;
  for (uint64_t i = 0; i < 500; ++i) {
    const uint16_t channel = i % 3 == 0 ? *second : *first;
    const Bytes data(i % 97, static_cast<std::byte>(i));
    ASSERT_TRUE(
        writer->write({channel, static_cast<uint32_t>(i), kBegun_ns + i, kBegun_ns + 2 * i, data}).ok());
    written.push_back({channel, kBegun_ns + i, data});
    if (i != 250) continue;
    record::MemorySource scene(Bytes(3'000'000, std::byte{42}));
    record::AttachmentIndex about;
    about.name = "scene.glb";
    about.media_type = "model/gltf-binary";
    ASSERT_TRUE(writer->attach(about, scene).ok());
    ASSERT_TRUE(writer->add_metadata({"about", {{"robot", "arm"}}}).ok());
  }
  ASSERT_TRUE(writer->finish().ok());

  auto reader = Reader::open(source_of(file));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  const record::FileIndex& index = reader->index();
  EXPECT_TRUE(index.has_summary && index.damage.empty());
  EXPECT_EQ(all_messages(*reader), written);
  ASSERT_EQ(index.channels.size(), 2u);
  EXPECT_EQ(index.channels.at(*first).metadata, (record::Texts{{"key", "value"}, {"k2", ""}}));
  EXPECT_EQ(index.channels.at(*second).topic, "/second");
  EXPECT_TRUE(std::ranges::equal(index.schemas.at(*schema).data, record::message_schema()));
  EXPECT_GT(index.chunks.size(), 3u);
  ASSERT_TRUE(index.statistics.has_value());
  EXPECT_EQ(index.statistics->messages, 500u);
  EXPECT_EQ(index.statistics->start_ns, kBegun_ns);
  EXPECT_EQ(index.statistics->end_ns, kBegun_ns + 499);

  ASSERT_EQ(index.attachments.size(), 1u);
  Bytes attached;
  ASSERT_TRUE(reader
                  ->read_attachment(index.attachments[0],
                                    [&](std::span<const std::byte> piece) {
                                      attached.insert(attached.end(), piece.begin(), piece.end());
                                      return Result<void>();
                                    })
                  .ok());
  EXPECT_EQ(attached, Bytes(3'000'000, std::byte{42}));

  uint64_t seen = 0;
  const auto report = record::verify(*reader, [&](const record::Message&) { ++seen; });
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report->sound()) << report->problems.front();
  EXPECT_TRUE(report->data_crc_given);
  EXPECT_EQ(seen, 500u);
  EXPECT_EQ(report->attachments, 1u);
  EXPECT_EQ(report->metadata, 1u);

  // Recovery of an undamaged file keeps everything.
  Bytes copy;
  const auto recovered = record::recover(*reader, std::make_unique<record::MemorySink>(copy));
  ASSERT_TRUE(recovered.ok());
  auto again = Reader::open(source_of(copy));
  ASSERT_TRUE(again.ok());
  const auto copied = all_messages(*again);
  // Channel ids follow the order of their first messages.
  for (LoggedMessage& each : written) each.channel = each.channel == *second ? 1 : 2;
  EXPECT_TRUE(copied == written);
  EXPECT_EQ(recovered->messages, written.size());
}

TEST_P(RecordFormat, SeeksByTime) {
  const Bytes file = small_recording(GetParam(), 200);
  auto reader = Reader::open(source_of(file));
  ASSERT_TRUE(reader.ok());
  const std::vector<LoggedMessage> all = all_messages(*reader);
  for (uint64_t ms : {0u, 1u, 17u, 100u, 200u, 201u, 202u, 5000u}) {
    const uint64_t from_ns = kBegun_ns + ms * kMs;
    std::vector<LoggedMessage> expected;
    for (const LoggedMessage& each : all)
      if (each.log_time_ns >= from_ns) expected.push_back(each);
    reader->seek(from_ns);
    EXPECT_EQ(all_messages(*reader), expected) << ms;
  }
}

TEST(RecordFormatOf, EmptyRecordingIsOne) {
  MemoryLog memory;
  ASSERT_TRUE(memory.log.finish().ok());
  auto reader = Reader::open(source_of(*memory.files.at(0)));
  ASSERT_TRUE(reader.ok());
  EXPECT_TRUE(reader->index().has_summary);
  EXPECT_TRUE(all_messages(*reader).empty());
  const auto report = record::verify(*reader, [](const record::Message&) {});
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report->sound()) << report->problems.front();
}

// Sink that is full after a number of bytes, like a disk.
class FullSink final : public record::Sink {
 public:
  FullSink(Bytes& bytes, size_t room) : memory_(bytes), bytes_(bytes), room_(room) {}
  Result<void> append(std::span<const std::byte> bytes) override {
    const size_t fits = std::min(bytes.size(), room_ - std::min(room_, bytes_.size()));
    (void)memory_.append(bytes.first(fits));
    return fits == bytes.size() ? Result<void>() : Result<void>(Error{"full"});
  }
  Result<void> truncate(uint64_t length) override { return memory_.truncate(length); }
  const std::string& name() const override { return memory_.name(); }

 private:
  record::MemorySink memory_;
  Bytes& bytes_;
  size_t room_;
};

TEST(RecordFormatOf, HeaderErrorIsReportedOnce) {
  Bytes file;
  // Like the recorder: the first file exists before any message, and its sink is handed over once.
  auto sink = std::make_shared<std::unique_ptr<record::Sink>>(std::make_unique<FullSink>(file, 4));
  record::StreamLog log(
      [sink](uint32_t) -> Result<std::unique_ptr<record::Sink>> { return std::move(*sink); }, {}, {});
  EXPECT_FALSE(log.take(1, description(7), kBegun_ns).ok());
  EXPECT_FALSE(log.take(1, frame(7, 1), kBegun_ns).ok());
  EXPECT_FALSE(log.finish().ok());
  EXPECT_EQ(log.files(), 0u);
}

TEST(RecordFormatOf, FullDiskKeepsChunks) {
  constexpr uint64_t kFrames = 200;
  constexpr size_t kChunkBytes = 16'384;  // longer than the summary
  const Bytes whole = small_recording(Compression::none, kFrames, kChunkBytes);
  auto whole_reader = Reader::open(source_of(whole));
  ASSERT_TRUE(whole_reader.ok());
  const std::vector<LoggedMessage> all = all_messages(*whole_reader);
  const std::vector<record::ChunkIndex> chunks = whole_reader->index().chunks;
  size_t with_summary = 0;
  for (size_t room = 2 * record::message_schema().size(); room < whole.size(); room += 211) {
    Bytes file;
    record::LogOptions options;
    options.writer = {Compression::none, kChunkBytes};
    record::StreamLog log(
        [&](uint32_t) -> Result<std::unique_ptr<record::Sink>> {
          return std::unique_ptr<record::Sink>(std::make_unique<FullSink>(file, room));
        },
        {}, options);
    bool failed = !log.take(1, description(7), kBegun_ns).ok();
    for (uint64_t i = 1; i <= kFrames && !failed; ++i) {
      if (i % 8 == 1)
        failed =
            !log.take(1, edit(7, i, "link_" + std::to_string(i % 3), i % 2 == 0), kBegun_ns + i * kMs).ok();
      if (!failed) failed = !log.take(1, frame(7, i), kBegun_ns + i * kMs).ok();
    }
    if (!failed) failed = !log.take(1, wire::encode(wire::Goodbye{7}), kBegun_ns + (kFrames + 1) * kMs).ok();
    (void)log.finish().ok();
    auto reader = Reader::open(source_of(file));
    ASSERT_TRUE(reader.ok());
    with_summary += reader->index().has_summary;
    const std::vector<LoggedMessage> kept = all_messages(*reader);
    ASSERT_LE(kept.size(), all.size());
    ASSERT_TRUE(std::equal(kept.begin(), kept.end(), all.begin()));
    // Every chunk that fits is present.
    const auto fits = std::count_if(chunks.begin(), chunks.end(), [&](const record::ChunkIndex& chunk) {
      return chunk.offset + chunk.length + chunk.message_index_bytes <= room;
    });
    ASSERT_EQ(reader->index().chunks.size(), static_cast<size_t>(fits)) << room;
    if (reader->index().has_summary) {
      const auto report = record::verify(*reader, [](const record::Message&) {});
      ASSERT_TRUE(report.ok() && report->sound());
    }
  }
  EXPECT_GT(with_summary, 0u);
}

// A file of MCAP's own writer with the messages of small_recording (npm's @mcap/core 2.2.2, by
// tests/e2e/record/mcap_oracle.mjs write): another order, another layout of the summary, and chunks with
// their schemas and channels.
TEST(RecordFormat, McapReferenceFileIsRead) {
  const std::string path = std::string(FIRE3DV_RECORDINGS) + "/by_mcap_core.mcap";
  auto source = record::open_source(path);
  ASSERT_TRUE(source.ok()) << source.error().message;
  auto theirs = record::Playback::open(std::move(*source));
  ASSERT_TRUE(theirs.ok()) << theirs.error().message;
  EXPECT_TRUE(theirs->reader().index().has_summary);
  EXPECT_TRUE(theirs->reader().index().damage.empty()) << theirs->reader().index().damage;
  const auto report = record::verify(theirs->reader(), [](const record::Message&) {});
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report->sound()) << report->problems.front();
  auto ours = record::Playback::open(source_of(small_recording(record::Compression::none)));
  ASSERT_TRUE(ours.ok());
  for (const uint64_t from_ms : {0u, 17u, 39u}) {
    for (record::Playback* playback : {&*theirs, &*ours})
      from_ms == 0 ? playback->rewind() : playback->seek(kBegun_ns + from_ms * kMs);
    record::Played a, b;
    size_t messages = 0;
    for (;; ++messages) {
      const auto step = theirs->next(a);
      ASSERT_EQ(step, ours->next(b)) << messages;
      if (step == record::Playback::Step::end) break;
      ASSERT_TRUE(a.kind == b.kind && a.log_time_ns == b.log_time_ns &&
                  std::ranges::equal(a.message, b.message))
          << "message " << messages << " from " << from_ms << " ms on";
    }
    EXPECT_GT(messages, 40 - from_ms);
  }
}

}  // namespace
}  // namespace fire3dv::record_test
