// Channels and schemas of one recording file, added when their first message is written. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "protocol/record/channels.h"
#include "protocol/record/mcap/writer.h"

namespace fire3dv::record {

class FileChannels {
 public:
  // Begins a file, whose writer is borrowed until the next one begins.
  void begin(Writer& writer);

  // Identifier of a schema of the file.
  Result<uint16_t> schema(std::string_view name, std::span<const std::byte> data);
  // Channel "/STREAM/END" of messages of this schema. All streams of the name share it. metadata: of a
  // channel that is added.
  Result<uint16_t> channel(const std::string& stream, std::string_view end, uint16_t schema,
                           const Texts& metadata = {});

  bool has_channel(const std::string& stream, std::string_view end, uint16_t schema) const;
  // True if the file has channels of a stream of this name.
  bool has_stream(const std::string& name) const { return streams_.contains(name); }
  // Memory that a reader needs for all channels.
  uint64_t bytes() const { return bytes_; }

 private:
  Writer* writer_ = nullptr;
  std::map<std::string, uint16_t, std::less<>> schemas_;           // by name
  std::map<std::pair<std::string, uint16_t>, uint16_t> channels_;  // by topic and schema
  std::set<std::string> streams_;
  uint64_t bytes_ = 0;
};

}  // namespace fire3dv::record
