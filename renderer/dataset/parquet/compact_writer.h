// Writer of Thrift's compact protocol, in which the metadata of Parquet files is stored
// (thrift.apache.org, "Thrift compact protocol encoding").
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace fire3dv::dataset {

enum class CompactType : uint8_t { i32 = 5, i64 = 6, binary = 8, list = 9, structure = 12 };

// Appends to a buffer. Fields of a struct have ascending numbers; a struct ends with end().
class CompactWriter {
 public:
  explicit CompactWriter(std::vector<uint8_t>& bytes) : bytes_(bytes) { begin(); }  // the outer struct

  void add(int16_t field, int32_t value);
  void add(int16_t field, int64_t value);
  void add(int16_t field, std::string_view value);
  void begin_struct(int16_t field);
  void begin_list(int16_t field, CompactType type, size_t count);
  // Elements of a list.
  void append(int32_t value) { put_zigzag(value); }
  void append(std::string_view value);
  void begin() { last_fields_.push_back(0); }
  // Of a struct.
  void end();

 private:
  void put_varint(uint64_t value);
  void put_zigzag(int64_t value);
  void put_field(int16_t field, CompactType type);

  std::vector<uint8_t>& bytes_;
  std::vector<int16_t> last_fields_;  // of the structs that are open
};

void put_varint(std::vector<uint8_t>& bytes, uint64_t value);

}  // namespace fire3dv::dataset
