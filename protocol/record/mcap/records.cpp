#include "protocol/record/mcap/records.h"

#include <algorithm>

namespace fire3dv::record {
namespace {

// Parses a map or array, which is prefixed by its length in bytes. Every element must end within it.
template <typename OnElement>
bool elements(Parser& parser, OnElement on_element) {
  uint32_t length = 0;
  std::span<const std::byte> bytes;
  if (!parser.get(length) || !parser.get(length, bytes)) return false;
  Parser inner(bytes);
  while (!inner.rest().empty())
    if (!on_element(inner)) return false;
  return true;
}

// Each entry takes some hundred bytes of memory, however short it is in the file.
constexpr size_t kMaxTexts = 65'536;

bool texts(Parser& parser, Texts& result) {
  return elements(parser, [&](Parser& inner) {
    std::string key, value;
    if (result.size() == kMaxTexts) return false;
    if (!inner.get(key) || !inner.get(value)) return false;
    result[std::move(key)] = std::move(value);
    return true;
  });
}

// Appends a record with the content that `fill` writes, then patches its length.
template <typename Fill>
void append_record(Bytes& to, Kind kind, Fill fill) {
  put(to, static_cast<uint8_t>(kind));
  const size_t length_at = to.size();
  put(to, uint64_t{0});
  fill();
  const uint64_t length = to.size() - length_at - 8;
  for (size_t i = 0; i < 8; ++i) to[length_at + i] = static_cast<std::byte>(length >> (8 * i));
}

// Same for content with a 32-bit length prefix.
template <typename Fill>
void put_length_prefixed(Bytes& to, Fill fill) {
  const size_t length_at = to.size();
  put(to, uint32_t{0});
  fill();
  const size_t length = to.size() - length_at - 4;
  for (size_t i = 0; i < 4; ++i) to[length_at + i] = static_cast<std::byte>(length >> (8 * i));
}

void put_texts(Bytes& to, const Texts& texts) {
  put_length_prefixed(to, [&] {
    for (const auto& [key, value] : texts) {
      put(to, std::string_view(key));
      put(to, std::string_view(value));
    }
  });
}

}  // namespace

bool parse(std::span<const std::byte> content, Schema& result) {
  Parser parser(content);
  uint32_t length = 0;
  std::span<const std::byte> data;
  if (!parser.get(result.id) || !parser.get(result.name) || !parser.get(result.encoding) ||
      !parser.get(length) || !parser.get(length, data))
    return false;
  result.data.assign(data.begin(), data.end());
  return result.id != 0;
}

bool parse(std::span<const std::byte> content, Channel& result) {
  Parser parser(content);
  return parser.get(result.id) && parser.get(result.schema_id) && parser.get(result.topic) &&
         parser.get(result.message_encoding) && texts(parser, result.metadata);
}

bool parse(std::span<const std::byte> content, Message& result) {
  Parser parser(content);
  if (!parser.get(result.channel_id) || !parser.get(result.sequence) || !parser.get(result.log_time_ns) ||
      !parser.get(result.publish_time_ns))
    return false;
  result.data = parser.rest();
  return true;
}

bool parse(std::span<const std::byte> content, ChunkHead& result) {
  Parser parser(content);
  return parser.get(result.start_ns) && parser.get(result.end_ns) && parser.get(result.uncompressed_bytes) &&
         parser.get(result.uncompressed_crc) && parser.get(result.compression) &&
         parser.get(result.compressed_bytes);
}

bool parse(std::span<const std::byte> content, MessageIndex& result) {
  Parser parser(content);
  return parser.get(result.channel_id) && elements(parser, [&](Parser& inner) {
           std::pair<uint64_t, uint64_t> entry;
           if (!inner.get(entry.first) || !inner.get(entry.second)) return false;
           result.entries.push_back(entry);
           return true;
         });
}

bool parse(std::span<const std::byte> content, ChunkIndex& result) {
  Parser parser(content);
  const bool good = parser.get(result.start_ns) && parser.get(result.end_ns) && parser.get(result.offset) &&
                    parser.get(result.length) &&
                    elements(parser,
                             [&](Parser& inner) {
                               std::pair<uint16_t, uint64_t> entry;
                               if (!inner.get(entry.first) || !inner.get(entry.second)) return false;
                               result.message_indexes.push_back(entry);
                               return true;
                             }) &&
                    parser.get(result.message_index_bytes) && parser.get(result.compression) &&
                    parser.get(result.compressed_bytes) && parser.get(result.uncompressed_bytes);
  std::sort(result.message_indexes.begin(), result.message_indexes.end());
  return good;
}

bool parse(std::span<const std::byte> content, AttachmentIndex& result) {
  Parser parser(content);
  return parser.get(result.offset) && parser.get(result.length) && parser.get(result.log_time_ns) &&
         parser.get(result.create_time_ns) && parser.get(result.data_bytes) && parser.get(result.name) &&
         parser.get(result.media_type);
}

bool parse(std::span<const std::byte> content, Statistics& result) {
  Parser parser(content);
  return parser.get(result.messages) && parser.get(result.schemas) && parser.get(result.channels) &&
         parser.get(result.attachments) && parser.get(result.metadata) && parser.get(result.chunks) &&
         parser.get(result.start_ns) && parser.get(result.end_ns) && elements(parser, [&](Parser& inner) {
           uint16_t channel = 0;
           uint64_t count = 0;
           if (!inner.get(channel) || !inner.get(count)) return false;
           result.messages_of_channel[channel] = count;
           return true;
         });
}

bool parse(std::span<const std::byte> content, Metadata& result) {
  Parser parser(content);
  return parser.get(result.name) && texts(parser, result.values);
}

bool parse(std::span<const std::byte> content, MetadataIndex& result) {
  Parser parser(content);
  return parser.get(result.offset) && parser.get(result.length) && parser.get(result.name);
}

bool parse(std::span<const std::byte> content, Footer& result) {
  Parser parser(content);
  return parser.get(result.summary_start) && parser.get(result.summary_offset_start) &&
         parser.get(result.summary_crc);
}

void append_header(Bytes& to, const std::string& profile, const std::string& library) {
  append_record(to, Kind::header, [&] {
    put(to, std::string_view(profile));
    put(to, std::string_view(library));
  });
}

void append(Bytes& to, const Schema& record) {
  append_record(to, Kind::schema, [&] {
    put(to, record.id);
    put(to, std::string_view(record.name));
    put(to, std::string_view(record.encoding));
    put(to, static_cast<uint32_t>(record.data.size()));
    put(to, std::span<const std::byte>(record.data));
  });
}

void append(Bytes& to, const Channel& record) {
  append_record(to, Kind::channel, [&] {
    put(to, record.id);
    put(to, record.schema_id);
    put(to, std::string_view(record.topic));
    put(to, std::string_view(record.message_encoding));
    put_texts(to, record.metadata);
  });
}

void append(Bytes& to, const Message& record) {
  put(to, static_cast<uint8_t>(Kind::message));
  put(to, kMessageHead + record.data.size());
  put(to, record.channel_id);
  put(to, record.sequence);
  put(to, record.log_time_ns);
  put(to, record.publish_time_ns);
  put(to, record.data);
}

void append(Bytes& to, const MessageIndex& record) {
  append_record(to, Kind::message_index, [&] {
    put(to, record.channel_id);
    put_length_prefixed(to, [&] {
      for (const auto& [log_time_ns, offset] : record.entries) {
        put(to, log_time_ns);
        put(to, offset);
      }
    });
  });
}

void append(Bytes& to, const ChunkHead& head) {
  put(to, static_cast<uint8_t>(Kind::chunk));
  const uint64_t head_bytes = 8 + 8 + 8 + 4 + 4 + head.compression.size() + 8;
  put(to, head_bytes + head.compressed_bytes);
  put(to, head.start_ns);
  put(to, head.end_ns);
  put(to, head.uncompressed_bytes);
  put(to, head.uncompressed_crc);
  put(to, std::string_view(head.compression));
  put(to, head.compressed_bytes);
}

void append(Bytes& to, const ChunkIndex& record) {
  append_record(to, Kind::chunk_index, [&] {
    put(to, record.start_ns);
    put(to, record.end_ns);
    put(to, record.offset);
    put(to, record.length);
    put_length_prefixed(to, [&] {
      for (const auto& [channel, offset] : record.message_indexes) {
        put(to, channel);
        put(to, offset);
      }
    });
    put(to, record.message_index_bytes);
    put(to, std::string_view(record.compression));
    put(to, record.compressed_bytes);
    put(to, record.uncompressed_bytes);
  });
}

void append(Bytes& to, const AttachmentIndex& record) {
  append_record(to, Kind::attachment_index, [&] {
    put(to, record.offset);
    put(to, record.length);
    put(to, record.log_time_ns);
    put(to, record.create_time_ns);
    put(to, record.data_bytes);
    put(to, std::string_view(record.name));
    put(to, std::string_view(record.media_type));
  });
}

void append(Bytes& to, const Statistics& record) {
  append_record(to, Kind::statistics, [&] {
    put(to, record.messages);
    put(to, record.schemas);
    put(to, record.channels);
    put(to, record.attachments);
    put(to, record.metadata);
    put(to, record.chunks);
    put(to, record.start_ns);
    put(to, record.end_ns);
    put_length_prefixed(to, [&] {
      for (const auto& [channel, count] : record.messages_of_channel) {
        put(to, channel);
        put(to, count);
      }
    });
  });
}

void append(Bytes& to, const Metadata& record) {
  append_record(to, Kind::metadata, [&] {
    put(to, std::string_view(record.name));
    put_texts(to, record.values);
  });
}

void append(Bytes& to, const MetadataIndex& record) {
  append_record(to, Kind::metadata_index, [&] {
    put(to, record.offset);
    put(to, record.length);
    put(to, std::string_view(record.name));
  });
}

void append_summary_offset(Bytes& to, Kind group, uint64_t start, uint64_t length) {
  append_record(to, Kind::summary_offset, [&] {
    put(to, static_cast<uint8_t>(group));
    put(to, start);
    put(to, length);
  });
}

void append_data_end(Bytes& to, uint32_t data_crc) {
  append_record(to, Kind::data_end, [&] { put(to, data_crc); });
}

}  // namespace fire3dv::record
