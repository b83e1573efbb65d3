// Layouts of MCAP files that other writers choose: without chunks, without indexes, definitions inside of
// chunks alone, chunks by topic, messages out of order, and summaries that list a part. Every message is
// read, in the order of time, and recovered.
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

// Messages and definitions of a recording, to be written anew.
struct Contents {
  record::FileIndex index;
  struct One {
    record::Message head;
    Bytes data;
  };
  std::vector<One> messages;
};

Contents contents_of(const Bytes& file) {
  auto reader = Reader::open(source_of(file));
  EXPECT_TRUE(reader.ok());
  Contents contents;
  record::Message message;
  while (reader->next(message) == Reader::Step::message)
    contents.messages.push_back({message, Bytes(message.data.begin(), message.data.end())});
  contents.index = reader->index();
  return contents;
}

enum class Definitions { outside, inside, inside_alone };

struct Layout {
  std::vector<std::vector<size_t>> chunks;  // message numbers
  std::vector<size_t> loose;                // message numbers behind the chunks
  Definitions definitions = Definitions::outside;
  std::vector<bool> listed;  // by chunk; empty: all
  bool has_message_index = true, has_summary = true, has_statistics = true;
};

void append_message(Bytes& to, const Contents& contents, size_t number) {
  record::Message message = contents.messages[number].head;
  message.data = contents.messages[number].data;
  record::append(to, message);
}

void append_definitions(Bytes& to, const Contents& contents) {
  for (const auto& [id, schema] : contents.index.schemas) record::append(to, schema);
  for (const auto& [id, channel] : contents.index.channels) record::append(to, channel);
}

Bytes written(const Contents& contents, const Layout& layout) {
  Bytes file;
  record::put(file, std::as_bytes(std::span(record::kMagic)));
  record::append_header(file, "", "layout_test");
  if (layout.definitions == Definitions::outside) append_definitions(file, contents);
  std::vector<record::ChunkIndex> indexes;
  for (const std::vector<size_t>& chunk : layout.chunks) {
    Bytes inside;
    if (indexes.empty() && layout.definitions != Definitions::outside) append_definitions(inside, contents);
    record::ChunkHead head{UINT64_MAX, 0, 0, 0, "", 0};
    std::map<uint16_t, record::MessageIndex> by_channel;
    for (const size_t number : chunk) {
      const record::Message& message = contents.messages[number].head;
      head.start_ns = std::min(head.start_ns, message.log_time_ns);
      head.end_ns = std::max(head.end_ns, message.log_time_ns);
      record::MessageIndex& index = by_channel[message.channel_id];
      index.channel_id = message.channel_id;
      index.entries.emplace_back(message.log_time_ns, inside.size());
      append_message(inside, contents, number);
    }
    head.uncompressed_bytes = head.compressed_bytes = inside.size();
    head.uncompressed_crc = record::crc32(inside);
    record::ChunkIndex index{head.start_ns, head.end_ns,  file.size(), 0, {}, 0, "",
                             inside.size(), inside.size()};
    record::append(file, head);
    record::put(file, std::span<const std::byte>(inside));
    index.length = file.size() - index.offset;
    if (layout.has_message_index) {
      const size_t from = file.size();
      for (const auto& [id, entries] : by_channel) {
        index.message_indexes.emplace_back(id, file.size());
        record::append(file, entries);
      }
      index.message_index_bytes = file.size() - from;
    }
    indexes.push_back(index);
  }
  for (const size_t number : layout.loose) append_message(file, contents, number);
  record::append_data_end(file, 0);
  const uint64_t summary = file.size();
  if (layout.has_summary) {
    if (layout.definitions != Definitions::inside_alone) append_definitions(file, contents);
    if (layout.has_statistics) {
      record::Statistics statistics;
      statistics.messages = contents.messages.size();
      statistics.schemas = static_cast<uint16_t>(contents.index.schemas.size());
      statistics.channels = static_cast<uint32_t>(contents.index.channels.size());
      statistics.chunks = static_cast<uint32_t>(indexes.size());
      statistics.start_ns = contents.messages.front().head.log_time_ns;
      statistics.end_ns = contents.messages.back().head.log_time_ns;
      for (const Contents::One& one : contents.messages)
        ++statistics.messages_of_channel[one.head.channel_id];
      record::append(file, statistics);
    }
    for (size_t i = 0; i < indexes.size(); ++i)
      if (layout.listed.empty() || layout.listed[i]) record::append(file, indexes[i]);
  }
  record::put(file, static_cast<uint8_t>(Kind::footer));
  record::put(file, uint64_t{20});
  record::put(file, layout.has_summary ? summary : 0);
  record::put(file, uint64_t{0});
  record::put(file, uint32_t{0});
  record::put(file, std::as_bytes(std::span(record::kMagic)));
  return file;
}

std::vector<std::vector<size_t>> chunks_of(const std::vector<size_t>& numbers, size_t size) {
  std::vector<std::vector<size_t>> chunks;
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (i % size == 0) chunks.emplace_back();
    chunks.back().push_back(numbers[i]);
  }
  return chunks;
}

class RecordLayout : public testing::Test {
 protected:
  RecordLayout() : contents_(contents_of(small_recording(Compression::none))) {
    for (size_t i = 0; i < contents_.messages.size(); ++i) in_order_.push_back(i);
    // Snapshots share the time of their chunk's first message: equal times come in file order.
    for (size_t i = 0; i < in_order_.size(); ++i) contents_.messages[i].head.log_time_ns += i;
  }

  // Reads the file in full, from its middle, and after its recovery.
  void expect_whole(const std::string& name, const Layout& layout, bool is_sound = true) {
    SCOPED_TRACE(name);
    const Bytes file = written(contents_, layout);
    auto reader = Reader::open(source_of(file));
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    expect_messages(*reader, 0);
    const size_t middle = in_order_.size() / 2;
    reader->seek(contents_.messages[middle].head.log_time_ns);
    expect_messages(*reader, middle);
    const auto report = record::verify(*reader, [](const record::Message&) {});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->sound(), is_sound) << (report->problems.empty() ? "" : report->problems.front());
    EXPECT_EQ(report->messages, in_order_.size());
    Bytes whole;
    const auto recovered = record::recover(*reader, std::make_unique<record::MemorySink>(whole));
    ASSERT_TRUE(recovered.ok()) << recovered.error().message;
    EXPECT_EQ(recovered->messages, in_order_.size());
    auto again = Reader::open(source_of(whole));
    ASSERT_TRUE(again.ok());
    EXPECT_TRUE(again->index().has_summary);
    expect_messages(*again, 0);
    auto playback = Playback::open(source_of(file));
    ASSERT_TRUE(playback.ok()) << playback.error().message;
    expect_played(*playback);
  }

  void expect_messages(Reader& reader, size_t from) const {
    const std::vector<LoggedMessage> heard = all_messages(reader);
    ASSERT_EQ(heard.size(), in_order_.size() - from);
    for (size_t i = 0; i < heard.size(); ++i) {
      ASSERT_EQ(heard[i].log_time_ns, contents_.messages[from + i].head.log_time_ns) << i;
      ASSERT_EQ(heard[i].data, contents_.messages[from + i].data) << i;
    }
  }

  // The state in the middle equals that of the file in order.
  void expect_played(Playback& playback) const {
    Layout usual;
    usual.chunks = chunks_of(in_order_, 10);
    auto expected = Playback::open(source_of(written(contents_, usual)));
    ASSERT_TRUE(expected.ok());
    for (const size_t at : {size_t{0}, in_order_.size() / 2, in_order_.size() - 2}) {
      const uint64_t time_ns = contents_.messages[at].head.log_time_ns;
      playback.seek(time_ns);
      expected->seek(time_ns);
      const std::vector<PlayedMessage> seen = played_from(playback), right = played_from(*expected);
      ASSERT_EQ(seen.size(), right.size()) << at;
      for (size_t i = 0; i < seen.size(); ++i) {
        ASSERT_EQ(seen[i].message, right[i].message) << at << ' ' << i;
        ASSERT_EQ(seen[i].kind, right[i].kind) << at << ' ' << i;
      }
    }
  }

  Contents contents_;
  std::vector<size_t> in_order_;
};

TEST_F(RecordLayout, WithoutIndexes) {
  Layout layout;
  layout.chunks = chunks_of(in_order_, 10);
  expect_whole("usual", layout);
  layout.has_message_index = false;
  expect_whole("no message index", layout);
  layout.has_statistics = false;
  expect_whole("no statistics", layout);
  layout.listed.assign(layout.chunks.size(), false);
  expect_whole("no chunk index", layout);
  layout.has_summary = false;
  expect_whole("no summary", layout);
}

TEST_F(RecordLayout, WithoutChunks) {
  Layout layout;
  layout.loose = in_order_;
  expect_whole("unchunked", layout);
  layout.has_summary = false;
  expect_whole("unchunked without summary", layout);
  layout = {};
  layout.chunks = chunks_of({in_order_.begin(), in_order_.begin() + 20}, 10);
  layout.loose.assign(in_order_.begin() + 20, in_order_.end());
  expect_whole("messages behind chunks", layout);
  std::shuffle(layout.loose.begin(), layout.loose.end(), std::mt19937(1));
  expect_whole("shuffled behind chunks", layout);
}

TEST_F(RecordLayout, DefinitionsInsideOfChunks) {
  for (const bool has_message_index : {true, false}) {
    for (const bool has_statistics : {true, false}) {
      Layout layout;
      layout.chunks = chunks_of(in_order_, 10);
      layout.has_message_index = has_message_index;
      layout.has_statistics = has_statistics;
      layout.definitions = Definitions::inside;
      expect_whole("repeated in the summary", layout);
      layout.definitions = Definitions::inside_alone;
      expect_whole("inside of chunks alone", layout);
    }
  }
}

TEST_F(RecordLayout, MessagesOutOfOrder) {
  std::vector<size_t> by_channel = in_order_, reversed(in_order_.rbegin(), in_order_.rend()),
                      shuffled = in_order_;
  std::stable_sort(by_channel.begin(), by_channel.end(), [this](size_t a, size_t b) {
    return contents_.messages[a].head.channel_id < contents_.messages[b].head.channel_id;
  });
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(2));
  for (const size_t size : {size_t{7}, size_t{1000}}) {
    for (const std::vector<size_t>& order : {by_channel, reversed, shuffled}) {
      Layout layout;
      layout.chunks = chunks_of(order, size);
      expect_whole("chunks of " + std::to_string(size), layout);
    }
  }
}

TEST_F(RecordLayout, SummaryListsAPart) {
  Layout layout;
  layout.chunks = chunks_of(in_order_, 10);
  for (size_t missing = 0; missing < layout.chunks.size(); ++missing) {
    layout.listed.assign(layout.chunks.size(), true);
    layout.listed[missing] = false;
    expect_whole("without chunk " + std::to_string(missing), layout, false);
  }
}

// Overlapping chunks that do not fit into memory together come in file order, which is said.
TEST_F(RecordLayout, TooManyAtOnceAreNamed) {
  std::vector<size_t> shuffled = in_order_;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(3));
  Layout layout;
  layout.chunks = chunks_of(shuffled, 7);
  const Bytes file = written(contents_, layout);
  auto reader = Reader::open(source_of(file), {4 << 20});
  ASSERT_TRUE(reader.ok());
  EXPECT_NE(reader->index().remark.find("overlap in time"), std::string::npos) << reader->index().remark;
  EXPECT_EQ(all_messages(*reader).size(), in_order_.size());
}

}  // namespace
}  // namespace fire3dv::record_test
