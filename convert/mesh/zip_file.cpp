#include "convert/mesh/zip_file.h"

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <initializer_list>

namespace fire3dv::convert {
namespace {

constexpr size_t kEndBytes = 22, kCentralBytes = 46, kLocalBytes = 30, kMaxComment = 65535;
constexpr size_t kMaxEntries = 100'000;

constexpr size_t kEnd64Bytes = 56, kLocator64Bytes = 20;
constexpr uint64_t kIn64 = 0xffffffff;  // the value is in a ZIP64 record

// count: at most 8.
uint64_t little(std::string_view bytes, size_t at, size_t count) {
  uint64_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

// Position of the end record, which a comment may follow; npos: none.
size_t find_end(std::string_view bytes) {
  if (bytes.size() < kEndBytes) return std::string_view::npos;
  const size_t last = bytes.size() - kEndBytes;
  const size_t at = bytes.rfind("PK\x05\x06", last);
  return at != std::string_view::npos && last - at <= kMaxComment ? at : std::string_view::npos;
}

// Entries and position of the central directory, by the ZIP64 record where there is one.
struct Directory {
  uint64_t count = 0, at = 0;
};

Directory find_directory(std::string_view bytes, size_t end) {
  Directory directory{little(bytes, end + 10, 2), little(bytes, end + 16, 4)};
  if (directory.count != 0xffff && directory.at != kIn64) return directory;
  if (end < kLocator64Bytes || bytes.substr(end - kLocator64Bytes, 4) != "PK\x06\x07") return directory;
  const uint64_t record = little(bytes, end - kLocator64Bytes + 8, 8);
  if (record > bytes.size() || bytes.size() - record < kEnd64Bytes || bytes.substr(record, 4) != "PK\x06\x06")
    return directory;
  return {little(bytes, record + 32, 8), little(bytes, record + 48, 8)};
}

// Replaces values by those of the extra field of ZIP64, which holds them in this order.
void take_64(std::string_view extra, std::initializer_list<uint64_t*> values) {
  while (extra.size() >= 4) {
    const size_t size = std::min<size_t>(little(extra, 2, 2), extra.size() - 4);
    std::string_view field = extra.substr(4, size);
    if (little(extra, 0, 2) == 1) {
      for (uint64_t* value : values) {
        if (*value != kIn64 || field.size() < 8) continue;
        *value = little(field, 0, 8);
        field.remove_prefix(8);
      }
    }
    extra.remove_prefix(4 + size);
  }
}

}  // namespace

Result<ZipFile> ZipFile::open(std::string_view bytes) {
  const Error damaged{"its ZIP archive is cut short or damaged"};
  const size_t end = find_end(bytes);
  if (end == std::string_view::npos) return damaged;
  ZipFile zip(bytes);
  const Directory directory = find_directory(bytes, end);
  if (directory.count > kMaxEntries)
    return Error{"its ZIP archive holds more than " + std::to_string(kMaxEntries) + " files"};
  uint64_t at = directory.at;
  for (size_t i = 0; i < directory.count; ++i) {
    if (at > bytes.size() || bytes.size() - at < kCentralBytes || bytes.substr(at, 4) != "PK\x01\x02")
      return damaged;
    const size_t name_bytes = little(bytes, at + 28, 2), extra = little(bytes, at + 30, 2),
                 comment = little(bytes, at + 32, 2);
    if (bytes.size() - at - kCentralBytes < name_bytes + extra + comment) return damaged;
    Entry entry;
    entry.method = little(bytes, at + 10, 2);
    if ((little(bytes, at + 8, 2) & 1) != 0) return Error{"its ZIP archive is encrypted"};
    entry.packed_bytes = little(bytes, at + 20, 4);
    entry.bytes = little(bytes, at + 24, 4);
    entry.header_at = little(bytes, at + 42, 4);
    take_64(bytes.substr(at + kCentralBytes + name_bytes, extra),
            {&entry.bytes, &entry.packed_bytes, &entry.header_at});
    zip.entries_.emplace(bytes.substr(at + kCentralBytes, name_bytes), entry);
    at += kCentralBytes + name_bytes + extra + comment;
  }
  return zip;
}

Result<std::string> ZipFile::read(const std::string& name, uint64_t max_bytes) const {
  const auto known = entries_.find(name);
  if (known == entries_.end()) return Error{"it has no file " + name};
  const Entry& entry = known->second;
  const Error damaged{"its file " + name + " is damaged"};
  const uint64_t at = entry.header_at;
  if (at > bytes_.size() || bytes_.size() - at < kLocalBytes || bytes_.substr(at, 4) != "PK\x03\x04")
    return damaged;
  const size_t data_at = at + kLocalBytes + little(bytes_, at + 26, 2) + little(bytes_, at + 28, 2);
  if (data_at > bytes_.size() || bytes_.size() - data_at < entry.packed_bytes) return damaged;
  if (entry.bytes > max_bytes)
    return Error{"its file " + name + " has more than " + std::to_string(max_bytes >> 20) + " MiB"};
  const std::string_view packed = bytes_.substr(data_at, entry.packed_bytes);
  if (entry.method == 0)
    return packed.size() == entry.bytes ? Result<std::string>(std::string(packed)) : damaged;
  if (entry.method != 8) return Error{"its file " + name + " is compressed in an unsupported way"};
  std::string text(entry.bytes, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return damaged;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(entry.packed_bytes);
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(entry.bytes);
  const int done = inflate(&stream, Z_FINISH);
  const bool is_whole = done == Z_STREAM_END && stream.avail_out == 0;
  inflateEnd(&stream);
  if (!is_whole) return damaged;
  return text;
}

}  // namespace fire3dv::convert
