#include "renderer/dataset/parquet/compact_writer.h"

#include "base/error.h"

namespace fire3dv::dataset {

void put_varint(std::vector<uint8_t>& bytes, uint64_t value) {
  for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<uint8_t>(value | 0x80));
  bytes.push_back(static_cast<uint8_t>(value));
}

void CompactWriter::put_varint(uint64_t value) {
  dataset::put_varint(bytes_, value);
}

void CompactWriter::put_zigzag(int64_t value) {
  put_varint(static_cast<uint64_t>(value) << 1 ^ static_cast<uint64_t>(value >> 63));
}

void CompactWriter::put_field(int16_t field, CompactType type) {
  constexpr int kMaxStep = 15;
  const int step = field - last_fields_.back();
  FIRE3DV_ASSERT(step > 0 && step <= kMaxStep);
  bytes_.push_back(static_cast<uint8_t>(step << 4 | static_cast<int>(type)));
  last_fields_.back() = field;
}

void CompactWriter::add(int16_t field, int32_t value) {
  put_field(field, CompactType::i32);
  put_zigzag(value);
}

void CompactWriter::add(int16_t field, int64_t value) {
  put_field(field, CompactType::i64);
  put_zigzag(value);
}

void CompactWriter::add(int16_t field, std::string_view value) {
  put_field(field, CompactType::binary);
  append(value);
}

void CompactWriter::append(std::string_view value) {
  put_varint(value.size());
  bytes_.insert(bytes_.end(), value.begin(), value.end());
}

void CompactWriter::begin_struct(int16_t field) {
  put_field(field, CompactType::structure);
  begin();
}

void CompactWriter::begin_list(int16_t field, CompactType type, size_t count) {
  constexpr size_t kShort = 15;
  put_field(field, CompactType::list);
  const auto code = static_cast<uint8_t>(type);
  if (count < kShort) {
    bytes_.push_back(static_cast<uint8_t>(count << 4 | code));
    return;
  }
  bytes_.push_back(static_cast<uint8_t>(0xf0 | code));
  put_varint(count);
}

void CompactWriter::end() {
  bytes_.push_back(0);
  last_fields_.pop_back();
}

}  // namespace fire3dv::dataset
