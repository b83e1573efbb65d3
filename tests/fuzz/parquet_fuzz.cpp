// Fuzz target of the Parquet reader: arbitrary bytes give numbers in whole rows, or an error.
#include <memory>
#include <span>
#include <string>

#include "base/error.h"
#include "protocol/import/parquet/page_codec.h"
#include "protocol/import/parquet/parquet_file.h"
#include "protocol/record/mcap/file.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

void put_little(Input& bytes, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<uint8_t>(value >> shift));
}

void append(Input& to, std::initializer_list<int> bytes) {
  for (const int byte : bytes) to.push_back(static_cast<uint8_t>(byte));
}

// Thrift's variable length.
void put_number(Input& bytes, size_t value) {
  for (value *= 2; value >= 0x80; value >>= 7) bytes.push_back(static_cast<uint8_t>(value | 0x80));
  bytes.push_back(static_cast<uint8_t>(value));
}

// Two rows of "s", a list of two floats; Snappy. dictionary: with one of one number.
Input file_of(bool dictionary) {
  Input file{'P', 'A', 'R', '1'};
  // repetition 0 1 0 1 packed, definition a run of 3, and the values
  Input page;
  append(page, {2, 0, 0, 0, 3, 0b1010, 2, 0, 0, 0, 8, 3});
  if (dictionary)
    append(page, {0});
  else
    for (int i = 0; i < 4; ++i) append(page, {0, 0, 0x80, 0x3f});
  const auto literal = [](const Input& bytes) {
    Input packed{static_cast<uint8_t>(bytes.size()), static_cast<uint8_t>((bytes.size() - 1) << 2)};
    packed.insert(packed.end(), bytes.begin(), bytes.end());
    return packed;
  };
  if (dictionary) {
    const Input number = literal({0, 0, 0x80, 0x3f});
    append(file, {0x15, 4, 0x15, 8, 0x15, static_cast<int>(2 * number.size()), 0x4c, 0x15, 2, 0x15, 0, 0, 0});
    file.insert(file.end(), number.begin(), number.end());
  }
  const size_t data_at = file.size();
  const Input packed = literal(page);
  append(file, {0x15, 0, 0x15});
  put_number(file, page.size());
  append(file, {0x15});
  put_number(file, packed.size());
  append(file, {0x2c, 0x15, 8, 0x15, dictionary ? 16 : 0, 0x15, 6, 0x15, 6, 0, 0});
  file.insert(file.end(), packed.begin(), packed.end());
  const size_t chunk_bytes = file.size() - 4;
  const size_t footer = file.size();
  append(file, {0x15, 2,    0x19, 0x4c,                                             // schema
                0x48, 1,    'x',  0x15, 2,    0,                                    // root
                0x35, 2,    0x18, 1,    's',  0x15, 2,   0,                         // optional group
                0x35, 4,    0x18, 1,    'l',  0x15, 2,   0,                         // repeated group
                0x15, 8,    0x25, 2,    0x18, 1,    'e', 0,                         // optional float
                0x16, 4,                                                            // rows
                0x19, 0x1c, 0x19, 0x1c, 0x3c, 0x15, 8,   0x35, 2, 0x16, 8, 0x26});  // row group, chunk
  put_number(file, chunk_bytes);
  append(file, {0x26});
  put_number(file, data_at);
  if (dictionary) append(file, {0x26, 8});
  append(file, {0, 0, 0x26, 4, 0, 0});
  put_little(file, static_cast<uint32_t>(file.size() - footer));
  append(file, {'P', 'A', 'R', '1'});
  return file;
}

}  // namespace

std::vector<Input> seeds() {
  return {file_of(false), file_of(true)};
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  const auto bytes = std::as_bytes(std::span(data, size));
  std::vector<std::byte> to(size % 100);
  (void)imported::unsnap(bytes, to);
  auto file = imported::ParquetFile::open(
      std::make_unique<record::MemorySource>(wire::Bytes(bytes.begin(), bytes.end())));
  if (!file) {
    FIRE3DV_ASSERT(!file.error().message.empty());
    return 0;
  }
  for (size_t group = 0; group < file->row_groups() && group < 4; ++group) {
    const auto numbers = file->read_numbers(group, "s");
    if (!numbers) {
      FIRE3DV_ASSERT(!numbers.error().message.empty());
      continue;
    }
    FIRE3DV_ASSERT(numbers->values.empty() || numbers->values.size() % numbers->width == 0);
  }
  return 0;
}
