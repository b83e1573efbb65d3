// Robustness test of recordings: truncated, damaged and hostile files. Valid chunks are recovered, damaged
// data is rejected, and memory and time stay bounded.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "protocol/record/damage.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

using record::Compression;
using record::Kind;
using record::Reader;

std::vector<LoggedMessage> recovered_messages(const Bytes& file, bool& has_summary) {
  auto reader = Reader::open(source_of(file));
  EXPECT_TRUE(reader.ok());
  Bytes whole;
  EXPECT_TRUE(record::recover(*reader, std::make_unique<record::MemorySink>(whole)).ok());
  auto again = Reader::open(source_of(whole));
  EXPECT_TRUE(again.ok());
  has_summary = again->index().has_summary;
  return all_messages(*again);
}

// A recovered file has new channel ids.
bool same_but_channels(const std::vector<LoggedMessage>& a, const std::vector<LoggedMessage>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const LoggedMessage& x, const LoggedMessage& y) {
                      return x.log_time_ns == y.log_time_ns && x.data == y.data;
                    });
}

TEST(RecordDamage, TruncationKeepsWholeChunks) {
  const Bytes file = small_recording(Compression::zstd, 24);
  auto whole = Reader::open(source_of(file));
  ASSERT_TRUE(whole.ok());
  const std::vector<record::ChunkIndex> chunks = whole->index().chunks;
  ASSERT_GT(chunks.size(), 2u);
  const std::vector<LoggedMessage> all = all_messages(*whole);
  std::vector<size_t> messages_up_to;  // of each chunk, the messages before its end
  {
    whole->rewind();
    record::Message message;
    messages_up_to.assign(chunks.size(), 0);
    while (whole->next(message) == Reader::Step::message) ++messages_up_to[whole->chunk()];
    for (size_t i = 1; i < chunks.size(); ++i) messages_up_to[i] += messages_up_to[i - 1];
  }
  for (size_t length = 0; length < file.size(); ++length) {
    const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length));
    auto reader = Reader::open(source_of(cut));
    if (length < record::kMagic.size()) {
      ASSERT_FALSE(reader.ok());
      continue;
    }
    ASSERT_TRUE(reader.ok()) << length;
    size_t expected = 0;
    for (size_t i = 0; i < chunks.size(); ++i)
      if (chunks[i].offset + chunks[i].length <= length) expected = messages_up_to[i];
    const std::vector<LoggedMessage> kept = all_messages(*reader);
    ASSERT_EQ(kept.size(), expected) << "cut at " << length;
    ASSERT_TRUE(std::equal(kept.begin(), kept.end(), all.begin())) << "cut at " << length;
    ASSERT_FALSE(reader->index().damage.empty());
    if (length % 16 != 0) continue;
    bool has_summary = false;
    ASSERT_TRUE(same_but_channels(recovered_messages(cut, has_summary), kept)) << length;
    ASSERT_EQ(has_summary, !kept.empty()) << length;  // of nothing there is no file
  }
}

TEST(RecordDamage, FlippedBitsAreDetected) {
  std::mt19937_64 generator(7);
  for (const Compression compression : {Compression::zstd, Compression::none, Compression::lz4}) {
    const Bytes file = small_recording(compression, 24);
    auto whole = Reader::open(source_of(file));
    ASSERT_TRUE(whole.ok());
    const std::vector<LoggedMessage> all = all_messages(*whole);
    size_t detected = 0;
    for (int i = 0; i < 3400; ++i) {
      Bytes damaged = file;
      const size_t at = generator() % damaged.size();
      damaged[at] ^= static_cast<std::byte>(1u << generator() % 8);
      auto reader = Reader::open(source_of(damaged));
      if (!reader) {
        ++detected;
        continue;
      }
      // In order, and without invented messages.
      const std::vector<LoggedMessage> kept = all_messages(*reader);
      size_t next = 0, found = 0;
      for (const LoggedMessage& each : kept) {
        while (next < all.size() && !(all[next] == each)) ++next;
        if (next == all.size()) break;
        ++next;
        ++found;
      }
      ASSERT_EQ(found, kept.size()) << "byte " << at << " gave a message that was never written";
      const auto report = record::verify(*reader, [](const record::Message&) {});
      if (!report.ok() || !report->sound())
        ++detected;
      else
        ASSERT_EQ(kept, all) << "byte " << at << " lost messages without a word";
    }
    EXPECT_GT(detected, 3300u);
  }
}

TEST(RecordDamage, DamagedChunkCostsItselfAlone) {
  const Bytes file = small_recording(Compression::zstd, 60);
  auto whole = Reader::open(source_of(file));
  ASSERT_TRUE(whole.ok());
  const auto chunks = whole->index().chunks;
  const size_t all = all_messages(*whole).size();
  for (const size_t at : {size_t{0}, size_t{5}, size_t{35}, size_t{60}}) {
    Bytes damaged = file;
    damaged[chunks[1].offset + at] ^= std::byte{0x10};
    // Also without the summary: the offsets of later chunks are found by a scan.
    for (const size_t length : {damaged.size(), damaged.size() - 1}) {
      damaged.resize(length);
      auto reader = Reader::open(source_of(damaged));
      ASSERT_TRUE(reader.ok());
      const size_t kept = all_messages(*reader).size();
      EXPECT_GT(kept, all / 2) << at;
      EXPECT_LT(kept, all) << at;
      bool has_summary = false;
      EXPECT_EQ(recovered_messages(damaged, has_summary).size(), kept);
    }
  }
}

// --- hostile files

Bytes begun_file() {
  Bytes file;
  record::put(file, std::as_bytes(std::span(record::kMagic)));
  record::append_header(file, "", "");
  record::append(file, record::Schema{1, "a.Table", "flatbuffer", {}});
  record::append(file, record::Channel{1, 1, "/a", "flatbuffer", {}});
  return file;
}

void put_chunk(Bytes& file, const record::ChunkHead& head, const Bytes& content) {
  record::append(file, head);
  record::put(file, std::span<const std::byte>(content));
}

// Returns the number of messages that the reader delivers, and its first error.
std::pair<size_t, std::string> read_hostile(const Bytes& file) {
  auto reader = Reader::open(source_of(file));
  if (!reader) return {0, reader.error().message};
  std::string complaint;
  size_t messages = 0;
  record::Message message;
  for (;;) {
    const auto step = reader->next(message);
    if (step == Reader::Step::end) break;
    if (step == Reader::Step::message) ++messages;
    if (step == Reader::Step::damaged && complaint.empty()) complaint = reader->problem();
  }
  (void)record::verify(*reader, [](const record::Message&) {});
  return {messages, complaint};
}

TEST(RecordHostile, HugeLengthsTakeNoMemory) {
  for (const uint64_t length : {uint64_t{1} << 40, UINT64_MAX, UINT64_MAX - 8, uint64_t{1} << 63}) {
    Bytes file = begun_file();
    record::put(file, static_cast<uint8_t>(Kind::chunk));
    record::put(file, length);
    file.resize(file.size() + 100);
    EXPECT_EQ(read_hostile(file).first, 0u);
    Bytes second = begun_file();
    put_chunk(second, {1, 1, length, 0, "zstd", 10}, Bytes(10));
    const auto [messages, complaint] = read_hostile(second);
    EXPECT_EQ(messages, 0u);
    EXPECT_NE(complaint.find("--memory-mb"), std::string::npos) << complaint;
  }
}

TEST(RecordHostile, DecompressionBombIsNotUnpacked) {
  record::Compressor compressor;
  const Bytes zeros(size_t{15} << 20);
  for (const Compression compression : {Compression::zstd, Compression::lz4}) {
    Bytes packed;
    ASSERT_TRUE(compressor.compress(compression, zeros, packed));
    const std::string name(record::compression_name(compression));
    // A true size unpacks to the data; a false one gives no messages.
    for (const uint64_t stated : {uint64_t{100}, uint64_t{zeros.size() - 1}, uint64_t{zeros.size() + 1}}) {
      Bytes file = begun_file();
      put_chunk(file, {1, 1, stated, 0, name, packed.size()}, packed);
      const auto [messages, complaint] = read_hostile(file);
      EXPECT_EQ(messages, 0u);
      EXPECT_FALSE(complaint.empty()) << stated;
    }
  }
}

TEST(RecordHostile, NestedChunksAreRefused) {
  Bytes inner;
  record::append(inner, record::ChunkHead{1, 1, 0, 0, "", 0});
  Bytes file = begun_file();
  put_chunk(file, {1, 1, inner.size(), 0, "", inner.size()}, inner);
  EXPECT_NE(read_hostile(file).second.find("does not belong into a chunk"), std::string::npos);

  Bytes message;
  record::append(message, record::Message{9, 1, 1, 1, {}});
  file = begun_file();
  put_chunk(file, {1, 1, message.size(), 0, "", message.size()}, message);
  EXPECT_NE(read_hostile(file).second.find("which nothing describes"), std::string::npos);

  file = begun_file();
  put_chunk(file, {1, 1, message.size() - 5, 0, "", message.size() - 5},
            Bytes(message.begin(), message.end() - 5));
  EXPECT_NE(read_hostile(file).second.find("ends inside a record"), std::string::npos);

  file = begun_file();
  put_chunk(file, {1, 1, message.size(), 0, "brotli", message.size()}, message);
  EXPECT_NE(read_hostile(file).second.find("only zstd, lz4 and none"), std::string::npos);
}

TEST(RecordHostile, CircularIndexIsRefused) {
  for (const uint64_t where : {uint64_t{8}, uint64_t{0}, UINT64_MAX - 20}) {
    Bytes file = begun_file();
    Bytes message;
    record::append(message, record::Message{1, 1, 5, 5, {}});
    put_chunk(file, {5, 5, message.size(), 0, "", message.size()}, message);
    record::append_data_end(file, 0);
    const uint64_t summary = file.size();
    for (int i = 0; i < 1000; ++i)
      record::append(file, record::ChunkIndex{5, 5, where, 60, {}, 0, "", message.size(), message.size()});
    record::put(file, static_cast<uint8_t>(Kind::footer));
    record::put(file, uint64_t{20});
    record::put(file, summary);
    record::put(file, uint64_t{0});
    record::put(file, uint32_t{0});
    record::put(file, std::as_bytes(std::span(record::kMagic)));
    EXPECT_EQ(read_hostile(file).first, 1u);  // by a scan of all records instead
  }
}

TEST(RecordHostile, LongIndexIsReported) {
  Bytes file = begun_file();
  Bytes empty;
  record::append(empty, record::ChunkHead{1, 1, 0, 0, "", 0});
  for (int i = 0; i < 200'000; ++i) file.insert(file.end(), empty.begin(), empty.end());
  const auto [messages, complaint] = read_hostile(file);
  EXPECT_EQ(messages, 0u);
  EXPECT_NE(complaint.find("--memory-mb"), std::string::npos) << complaint;
}

TEST(RecordHostile, LongNamesAreCharged) {
  const std::string name(size_t{1} << 20, 'n');
  Bytes channels = begun_file(), schemas = begun_file(), attachments = begun_file();
  for (uint16_t id = 2; id < 40; ++id) {
    record::append(channels, record::Channel{id, 1, "/a", name, {}});
    record::append(schemas, record::Schema{id, "", name, {}});
  }
  const std::string short_name(60'000, 'n');
  for (int i = 0; i < 200; ++i) {
    Bytes content;
    record::put(content, uint64_t{0});
    record::put(content, uint64_t{0});
    record::put(content, std::string_view(short_name));
    record::put(content, std::string_view(short_name));
    record::put(content, uint64_t{0});
    record::put(content, uint32_t{0});
    record::put(attachments, static_cast<uint8_t>(Kind::attachment));
    record::put(attachments, uint64_t{content.size()});
    record::put(attachments, std::span<const std::byte>(content));
  }
  for (const Bytes* file : {&channels, &schemas, &attachments}) {
    auto reader = Reader::open(source_of(*file));
    const std::string complaint = reader.ok() ? reader->index().damage : reader.error().message;
    EXPECT_NE(complaint.find("--memory-mb"), std::string::npos) << complaint;
  }
}

TEST(RecordHostile, ScanNeedsEndOfData) {
  Bytes file = begun_file();
  record::put(file, static_cast<uint8_t>(Kind::data_end));
  record::put(file, uint64_t{60});
  file.resize(file.size() + 60);
  Bytes message;
  record::append(message, record::Message{1, 1, 5, 5, {}});
  put_chunk(file, {5, 5, message.size(), 0, "", message.size()}, message);
  EXPECT_EQ(read_hostile(file).first, 1u);
}

TEST(RecordHostile, OtherFilesAreNamed) {
  for (const std::string_view text : {"", "glTF", "not an MCAP file at all, but longer than its magic"}) {
    const auto bytes = std::as_bytes(std::span(text));
    const auto reader = Reader::open(source_of(Bytes(bytes.begin(), bytes.end())));
    ASSERT_FALSE(reader.ok());
    EXPECT_NE(reader.error().message.find("is not an MCAP file"), std::string::npos);
  }
  EXPECT_FALSE(record::open_source("/dev/zero").ok());
  EXPECT_FALSE(record::open_source("/nowhere/at/all").ok());
}

// Source that counts the bytes read.
class CountingSource final : public record::Source {
 public:
  CountingSource(Bytes bytes, uint64_t& read_bytes) : memory_(std::move(bytes)), read_bytes_(read_bytes) {}
  uint64_t size() const override { return memory_.size(); }
  Result<void> read(uint64_t offset, std::span<std::byte> to) override {
    read_bytes_ += to.size();
    return memory_.read(offset, to);
  }
  const std::string& name() const override { return memory_.name(); }

 private:
  record::MemorySource memory_;
  uint64_t& read_bytes_;
};

// Nested chunks, each in a record that leads to the same long run of records with damage behind it.
TEST(RecordDamage, OverlappingChunksAreFast) {
  Bytes one;
  {
    const Bytes file = small_recording(Compression::none, 1);
    auto reader = Reader::open(source_of(file));
    ASSERT_TRUE(reader.ok());
    const record::ChunkIndex& chunk = reader->index().chunks.at(0);
    one.assign(file.begin() + static_cast<std::ptrdiff_t>(chunk.offset),
               file.begin() + static_cast<std::ptrdiff_t>(chunk.offset + chunk.length));
  }
  constexpr size_t kLevels = 3000, kRecords = 100'000;
  Bytes file;
  for (const uint8_t byte : record::kMagic) file.push_back(std::byte{byte});
  const size_t level_bytes = one.size() + record::kRecordHead;
  const size_t row_at = file.size() + kLevels * level_bytes;
  for (size_t level = 0; level < kLevels; ++level) {
    file.insert(file.end(), one.begin(), one.end());
    record::put(file, uint8_t{0x80});  // a record of a private type, up to the run
    record::put(file, static_cast<uint64_t>(row_at - file.size() - 8));
  }
  ASSERT_EQ(file.size(), row_at);
  for (size_t i = 0; i < kRecords; ++i) {
    record::put(file, uint8_t{0x81});
    record::put(file, uint64_t{0});
  }
  record::put(file, uint64_t{0});  // an invalid record
  const size_t file_bytes = file.size();
  uint64_t read_bytes = 0;
  auto reader = Reader::open(std::make_unique<CountingSource>(std::move(file), read_bytes));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  EXPECT_EQ(reader->index().chunks.size(), kLevels);
  EXPECT_LT(read_bytes, 40 * file_bytes) << "each level walks the row again";
}

}  // namespace
}  // namespace fire3dv::record_test
