// Reader of Thrift's compact protocol, in which the metadata of Parquet files is stored
// (thrift.apache.org, "Thrift compact protocol encoding"). Bytes are untrusted: lengths and depth are
// checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace fire3dv::imported {

enum class CompactType : uint8_t {
  stop = 0,
  yes = 1,
  no = 2,
  i8 = 3,
  i16 = 4,
  i32 = 5,
  i64 = 6,
  floating = 7,
  binary = 8,
  list = 9,
  set = 10,
  map = 11,
  structure = 12
};

// After the first fault all reads return zeros, and no struct or list has an element left. Usage:
//   reader.begin_struct();
//   while (reader.next_field()) switch (reader.field()) { case 1: x = reader.integer(); break; default:
//   reader.skip(); }
class CompactReader {
 public:
  explicit CompactReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  size_t position() const { return at_; }  // bytes read

  void begin_struct();
  // Moves to the next field; false at the end of the struct. Each field is read or skipped before.
  bool next_field();
  int16_t field() const { return levels_[depth_].field; }
  // Of the current field, which has this type; else a fault.
  int64_t integer();
  bool boolean();
  std::string text();
  void begin_struct_field();
  // Count of the elements, at most max. A list of others than `type`, or a longer one, is a fault.
  size_t begin_list(CompactType type, size_t max);
  // Elements of a list.
  int64_t integer_element() { return zigzag(); }
  std::string text_element();
  void skip();

  void fail() { ok_ = false; }

 private:
  static constexpr size_t kMaxDepth = 24;
  struct Level {
    int16_t field = 0;
    CompactType type = CompactType::stop;
  };

  uint8_t byte();
  uint64_t varint();
  int64_t zigzag();
  std::string_view bytes(uint64_t count);
  void expect(CompactType type);
  void skip(CompactType type, size_t depth);

  std::span<const std::byte> bytes_;
  size_t at_ = 0, depth_ = 0;  // depth 0: no struct is open
  Level levels_[kMaxDepth + 1];
  bool ok_ = true;
};

}  // namespace fire3dv::imported
