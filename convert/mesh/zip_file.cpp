#include "convert/mesh/zip_file.h"

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace fire3dv::convert {
namespace {

constexpr size_t kEndBytes = 22, kCentralBytes = 46, kLocalBytes = 30, kMaxComment = 65535;
constexpr size_t kMaxEntries = 100'000;

uint32_t little(std::string_view bytes, size_t at, size_t count) {
  uint32_t value = 0;
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

}  // namespace

Result<ZipFile> ZipFile::open(std::string_view bytes) {
  const Error damaged{"its ZIP archive is cut short or damaged"};
  const size_t end = find_end(bytes);
  if (end == std::string_view::npos) return damaged;
  ZipFile zip(bytes);
  const size_t count = little(bytes, end + 10, 2);
  size_t at = little(bytes, end + 16, 4);
  if (count > kMaxEntries || at == 0xffffffff)
    return Error{"its ZIP archive is of an unsupported kind (ZIP64)"};
  for (size_t i = 0; i < count; ++i) {
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
  const size_t at = entry.header_at;
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
  stream.avail_in = entry.packed_bytes;
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = entry.bytes;
  const int done = inflate(&stream, Z_FINISH);
  const bool is_whole = done == Z_STREAM_END && stream.avail_out == 0;
  inflateEnd(&stream);
  if (!is_whole) return damaged;
  return text;
}

}  // namespace fire3dv::convert
