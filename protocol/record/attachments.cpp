#include "protocol/record/attachments.h"

#include <algorithm>
#include <filesystem>

#include "protocol/record/mcap/bytes.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/mcap/reader.h"
#include "protocol/wire/check.h"

namespace fire3dv::record {

namespace {

// Attachments are read and written in pieces: a scene file may exceed the memory limit of a recorder or
// reader.
constexpr size_t kPieceBytes = size_t{1} << 20;

}  // namespace

Result<void> Writer::attach(const AttachmentIndex& about, Source& data) {
  if (auto good = end_chunk(); !good) return good;
  AttachmentIndex index = about;
  index.offset = position_;
  index.data_bytes = data.size();

  Bytes head;
  put(head, static_cast<uint8_t>(Kind::attachment));
  const uint64_t content_bytes =
      8 + 8 + 4 + about.name.size() + 4 + about.media_type.size() + 8 + data.size() + 4;
  put(head, content_bytes);
  put(head, about.log_time_ns);
  put(head, about.create_time_ns);
  put(head, std::string_view(about.name));
  put(head, std::string_view(about.media_type));
  put(head, data.size());
  index.length = kRecordHead + content_bytes;

  const uint64_t begun_at = position_;
  const uint32_t data_crc = data_crc_;
  uint32_t crc = crc32(std::span(head).subspan(kRecordHead));
  Result<void> good = append_whole(head);
  Bytes piece;
  for (uint64_t at = 0; good && at < data.size(); at += piece.size()) {
    piece.resize(static_cast<size_t>(std::min<uint64_t>(kPieceBytes, data.size() - at)));
    good = data.read(at, piece);
    if (good) good = append_whole(piece);
    crc = crc32(piece, crc);
  }
  Bytes tail;
  put(tail, crc);
  if (good) good = append_whole(tail);
  if (!good) {
    (void)sink_->truncate(begun_at).ok();
    position_ = begun_at;
    data_crc_ = data_crc;
    return good;
  }
  attachments_.push_back(std::move(index));
  return {};
}

Result<AttachmentIndex> read_attachment_head(Source& source, const RecordAt& record) {
  const Error damaged{wire::printable(source.name(), 4096) + ": the attachment at byte " +
                      std::to_string(record.offset) + " is damaged; it cannot be taken out"};
  Bytes head(static_cast<size_t>(std::min(record.content_bytes(), kMaxDefinitionBytes / 64)));
  if (auto good = source.read(record.content_at(), head); !good) return good.error();
  AttachmentIndex index;
  index.offset = record.offset;
  index.length = record.length;
  Parser parser(head);
  if (!parser.get(index.log_time_ns) || !parser.get(index.create_time_ns) || !parser.get(index.name) ||
      !parser.get(index.media_type) || !parser.get(index.data_bytes))
    return damaged;
  const uint64_t head_bytes = head.size() - parser.rest().size();
  if (record.content_bytes() < head_bytes + 4 || record.content_bytes() - head_bytes - 4 != index.data_bytes)
    return damaged;
  return index;
}

Result<void> Reader::read_attachment(
    const AttachmentIndex& index, const std::function<Result<void>(std::span<const std::byte>)>& on_piece) {
  const Error damaged{wire::printable(source_->name(), 4096) + ": attachment \"" +
                      wire::printable(index.name) + "\" is damaged; it cannot be taken out"};
  const uint64_t file_bytes = source_->size();
  if (index.length < kRecordHead || index.length > file_bytes || index.offset > file_bytes - index.length)
    return damaged;
  const auto record = RecordIterator(*source_, index.offset, index.offset + index.length).next();
  if (!record) return record.error();
  if (!*record || (*record)->kind != Kind::attachment || (*record)->length != index.length) return damaged;
  const auto stated = read_attachment_head(*source_, **record);
  if (!stated) return stated.error();
  if (*stated != index) return damaged;
  const uint64_t until = index.offset + index.length - 4;  // the CRC covers all preceding bytes
  const uint64_t data_at = until - index.data_bytes;
  uint32_t crc = 0;
  Bytes piece;
  for (uint64_t at = (*record)->content_at(); at < until; at += piece.size()) {
    const uint64_t end = at < data_at ? data_at : until;
    piece.resize(static_cast<size_t>(std::min<uint64_t>(kPieceBytes, end - at)));
    if (auto good = source_->read(at, piece); !good) return good;
    crc = crc32(piece, crc);
    if (at < data_at) continue;
    if (auto good = on_piece(piece); !good) return good;
  }
  Bytes tail(4);
  if (auto good = source_->read(until, tail); !good) return good;
  uint32_t stated_crc = 0;
  Parser(tail).get(stated_crc);
  return stated_crc == 0 || stated_crc == crc ? Result<void>() : Result<void>(damaged);
}

std::vector<AttachedFile> named_files(const std::vector<std::string>& paths) {
  std::vector<AttachedFile> files;
  for (const std::string& path : paths)
    files.push_back({path, std::filesystem::path(path).filename().string()});
  return files;
}

std::string media_type_of(const std::string& name) {
  const std::string extension = std::filesystem::path(name).extension().string();
  return extension == ".glb"    ? kGlbType
         : extension == ".gltf" ? "model/gltf+json"
                                : "application/octet-stream";
}

Result<void> attach_files(const std::vector<AttachedFile>& files, Writer& writer, uint64_t log_time_ns) {
  for (const auto& [path, name] : files) {
    auto source = open_source(path);
    if (!source) return source.error();
    AttachmentIndex about;
    about.log_time_ns = log_time_ns;
    about.name = name;
    about.media_type = media_type_of(name);
    if (auto good = writer.attach(about, **source); !good) return good;
  }
  return {};
}

Result<std::vector<FoxgloveModel>> load_models(const std::vector<AttachedFile>& files,
                                               std::vector<std::string>& left_out) {
  std::vector<FoxgloveModel> models;
  uint64_t bytes = 0;
  for (const auto& [path, name] : files) {
    if (media_type_of(name) != kGlbType) continue;
    auto source = open_source(path);
    if (!source) return source.error();
    if ((*source)->size() > kMaxModelBytes - bytes) {
      left_out.push_back(wire::printable(path, 4096) +
                         " is attached, but no model for Foxglove: all of them together may have " +
                         std::to_string(kMaxModelBytes >> 20) + " MiB");
      continue;
    }
    bytes += (*source)->size();
    FoxgloveModel model{name, kGlbType, Bytes((*source)->size())};
    if (auto good = (*source)->read(0, model.data); !good) return good.error();
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace fire3dv::record
