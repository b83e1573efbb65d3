// Codec of MCAP records (mcap.dev/spec): plain structs, parsers and serialisers. protocol/SPEC-record.md
// lists the subset that recordings use. Parsers return false for truncated content and ignore bytes after the
// known fields, as MCAP requires.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/record/mcap/bytes.h"

namespace fire3dv::record {

constexpr std::array<uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
constexpr uint64_t kRecordHead = 9;  // kind u8, content length u64

enum class Kind : uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0a,
  statistics = 0x0b,
  metadata = 0x0c,
  metadata_index = 0x0d,
  summary_offset = 0x0e,
  data_end = 0x0f,
};

using Texts = std::map<std::string, std::string>;

struct Schema {
  uint16_t id = 0;  // never 0
  std::string name, encoding;
  Bytes data;
  bool operator==(const Schema&) const = default;
};

struct Channel {
  uint16_t id = 0, schema_id = 0;
  std::string topic, message_encoding;
  Texts metadata;
  bool operator==(const Channel&) const = default;
};

struct Message {
  uint16_t channel_id = 0;
  uint32_t sequence = 0;
  uint64_t log_time_ns = 0, publish_time_ns = 0;
  std::span<const std::byte> data;
};
constexpr uint64_t kMessageHead = 22;  // part of the content, precedes the data

struct ChunkHead {
  uint64_t start_ns = 0, end_ns = 0;
  uint64_t uncompressed_bytes = 0;
  uint32_t uncompressed_crc = 0;  // 0: absent
  std::string compression;
  uint64_t compressed_bytes = 0;
};
constexpr uint64_t kMaxChunkHead =
    8 + 8 + 8 + 4 + 4 + 16 + 8;  // with the longest compression name that we read

struct MessageIndex {
  uint16_t channel_id = 0;
  std::vector<std::pair<uint64_t, uint64_t>> entries;  // log time, offset in the uncompressed chunk
  bool operator==(const MessageIndex&) const = default;
};

struct ChunkIndex {
  uint64_t start_ns = 0, end_ns = 0;
  uint64_t offset = 0, length = 0;  // in the file, including the record header
  std::vector<std::pair<uint16_t, uint64_t>>
      message_indexes;  // channel, offset in the file; sorted by channel
  uint64_t message_index_bytes = 0;
  std::string compression;
  uint64_t compressed_bytes = 0, uncompressed_bytes = 0;
  // A range of consecutive records outside chunks, which is read as an uncompressed chunk. message_indexes
  // then has the first message of each channel.
  bool loose = false;
  bool operator==(const ChunkIndex&) const = default;
};

struct AttachmentIndex {
  uint64_t offset = 0, length = 0;
  uint64_t log_time_ns = 0, create_time_ns = 0;
  uint64_t data_bytes = 0;
  std::string name, media_type;
  bool operator==(const AttachmentIndex&) const = default;
};

struct Statistics {
  uint64_t messages = 0;
  uint16_t schemas = 0;
  uint32_t channels = 0, attachments = 0, metadata = 0, chunks = 0;
  uint64_t start_ns = 0, end_ns = 0;
  std::map<uint16_t, uint64_t> messages_of_channel;
  bool operator==(const Statistics&) const = default;
};

struct Metadata {
  std::string name;
  Texts values;
  bool operator==(const Metadata&) const = default;
};

struct MetadataIndex {
  uint64_t offset = 0, length = 0;
  std::string name;
  bool operator==(const MetadataIndex&) const = default;
};

struct Footer {
  uint64_t summary_start = 0, summary_offset_start = 0;
  uint32_t summary_crc = 0;
};
constexpr uint64_t kFooterBytes = kRecordHead + 20;

bool parse(std::span<const std::byte> content, Schema& result);
bool parse(std::span<const std::byte> content, Channel& result);
bool parse(std::span<const std::byte> content, Message& result);
bool parse(std::span<const std::byte> content, ChunkHead& result);  // the content may extend past the head
bool parse(std::span<const std::byte> content, MessageIndex& result);
bool parse(std::span<const std::byte> content, ChunkIndex& result);
bool parse(std::span<const std::byte> content, AttachmentIndex& result);
bool parse(std::span<const std::byte> content, Statistics& result);
bool parse(std::span<const std::byte> content, Metadata& result);
bool parse(std::span<const std::byte> content, MetadataIndex& result);
bool parse(std::span<const std::byte> content, Footer& result);

// Serialisers: append a whole record to `to`.
void append_header(Bytes& to, const std::string& profile, const std::string& library);
void append(Bytes& to, const Schema& record);
void append(Bytes& to, const Channel& record);
void append(Bytes& to, const Message& record);
void append(Bytes& to, const MessageIndex& record);
void append(Bytes& to, const ChunkIndex& record);
void append(Bytes& to, const AttachmentIndex& record);
void append(Bytes& to, const Statistics& record);
void append(Bytes& to, const Metadata& record);
void append(Bytes& to, const MetadataIndex& record);
void append_summary_offset(Bytes& to, Kind group, uint64_t start, uint64_t length);
void append_data_end(Bytes& to, uint32_t data_crc);
// Appends a chunk record without its compressed content. The record length includes that content.
void append(Bytes& to, const ChunkHead& head);

}  // namespace fire3dv::record
