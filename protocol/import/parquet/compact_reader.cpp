#include "protocol/import/parquet/compact_reader.h"

namespace fire3dv::imported {
namespace {

// Of elements of lists and maps: a boolean has a byte there, and none in a field.
CompactType element_type(int code) {
  const auto type = static_cast<CompactType>(code);
  return type == CompactType::yes || type == CompactType::no ? CompactType::i8 : type;
}

}  // namespace

uint8_t CompactReader::byte() {
  if (!ok_ || at_ == bytes_.size()) {
    ok_ = false;
    return 0;
  }
  return static_cast<uint8_t>(bytes_[at_++]);
}

uint64_t CompactReader::varint() {
  constexpr int kBits = 64;
  uint64_t value = 0;
  for (int shift = 0; shift < kBits; shift += 7) {
    const uint8_t part = byte();
    value |= uint64_t{part & 0x7fu} << shift;
    if (part < 0x80) return value;
  }
  ok_ = false;
  return 0;
}

int64_t CompactReader::zigzag() {
  const uint64_t value = varint();
  return static_cast<int64_t>(value >> 1 ^ (~(value & 1) + 1));
}

std::string_view CompactReader::bytes(uint64_t count) {
  if (!ok_ || count > bytes_.size() - at_) {
    ok_ = false;
    return {};
  }
  const auto* const begin = reinterpret_cast<const char*>(bytes_.data()) + at_;
  at_ += count;
  return {begin, count};
}

void CompactReader::begin_struct() {
  if (depth_ == kMaxDepth) {
    ok_ = false;
    return;
  }
  levels_[++depth_] = {};
}

bool CompactReader::next_field() {
  if (!ok_ || depth_ == 0) return false;
  Level& level = levels_[depth_];
  const uint8_t head = byte();
  if (!ok_) return false;
  level.type = static_cast<CompactType>(head & 0x0f);
  if (level.type == CompactType::stop) {
    --depth_;
    return false;
  }
  const int step = head >> 4;
  const int64_t field = step != 0 ? level.field + step : zigzag();
  if (field < 0 || field > INT16_MAX) {
    ok_ = false;
    return false;
  }
  level.field = static_cast<int16_t>(field);
  return ok_;
}

void CompactReader::expect(CompactType type) {
  if (depth_ == 0 || levels_[depth_].type != type) ok_ = false;
}

int64_t CompactReader::integer() {
  const CompactType type = levels_[depth_].type;
  if (type != CompactType::i16 && type != CompactType::i32 && type != CompactType::i64) {
    ok_ = false;
    return 0;
  }
  return zigzag();
}

bool CompactReader::boolean() {
  const CompactType type = levels_[depth_].type;
  if (type != CompactType::yes && type != CompactType::no) ok_ = false;
  return type == CompactType::yes;
}

std::string CompactReader::text() {
  expect(CompactType::binary);
  return text_element();
}

std::string CompactReader::text_element() {
  return std::string(bytes(varint()));
}

void CompactReader::begin_struct_field() {
  expect(CompactType::structure);
  begin_struct();
}

size_t CompactReader::begin_list(CompactType type, size_t max) {
  expect(CompactType::list);
  const uint8_t head = byte();
  constexpr uint64_t kLong = 15;
  const uint64_t count = head >> 4 == kLong ? varint() : uint64_t{head} >> 4;
  // Each element has a byte at least.
  if (!ok_ || static_cast<CompactType>(head & 0x0f) != type || count > max || count > bytes_.size() - at_) {
    ok_ = false;
    return 0;
  }
  return count;
}

void CompactReader::skip() {
  if (depth_ == 0) {
    ok_ = false;
    return;
  }
  skip(levels_[depth_].type, depth_);
}

void CompactReader::skip(CompactType type, size_t depth) {
  if (!ok_ || depth > kMaxDepth) {
    ok_ = false;
    return;
  }
  switch (type) {
    case CompactType::yes:
    case CompactType::no:
      return;
    case CompactType::i8:
      (void)byte();
      return;
    case CompactType::i16:
    case CompactType::i32:
    case CompactType::i64:
      (void)varint();
      return;
    case CompactType::floating:
      (void)bytes(sizeof(double));
      return;
    case CompactType::binary:
      (void)bytes(varint());
      return;
    case CompactType::list:
    case CompactType::set: {
      const uint8_t head = byte();
      constexpr uint64_t kLong = 15;
      const uint64_t count = head >> 4 == kLong ? varint() : uint64_t{head} >> 4;
      const CompactType element = element_type(head & 0x0f);
      for (uint64_t i = 0; ok_ && i < count; ++i) skip(element, depth + 1);
      return;
    }
    case CompactType::map: {
      const uint64_t count = varint();
      const uint8_t types = count == 0 ? uint8_t{0} : byte();
      for (uint64_t i = 0; ok_ && i < count; ++i) {
        skip(element_type(types >> 4), depth + 1);
        skip(element_type(types & 0x0f), depth + 1);
      }
      return;
    }
    case CompactType::structure:
      while (ok_) {
        const uint8_t head = byte();
        if (head == 0 || !ok_) return;
        if (head >> 4 == 0) (void)varint();
        skip(static_cast<CompactType>(head & 0x0f), depth + 1);
      }
      return;
    case CompactType::stop:
      break;
  }
  ok_ = false;
}

}  // namespace fire3dv::imported
