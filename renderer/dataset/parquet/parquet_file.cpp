#include "renderer/dataset/parquet/parquet_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "base/error.h"
#include "renderer/dataset/parquet/compact_writer.h"

namespace fire3dv::dataset {
namespace {

// Codes of parquet.thrift.
constexpr int32_t kInt64 = 2, kFloat = 4, kDouble = 5, kByteArray = 6;
constexpr int32_t kOptional = 1, kRepeated = 2;
constexpr int32_t kUtf8 = 0, kList = 3;
constexpr int32_t kPlain = 0, kRle = 3;
constexpr int32_t kUncompressed = 0;
constexpr int32_t kDataPage = 0;
constexpr std::string_view kMagic = "PAR1";
constexpr uint64_t kPageBytes = 1 << 20;  // about that many; readers hold a page in memory

struct Chunk {
  int64_t begin = 0, bytes = 0, values = 0;  // in the file; headers of pages included
};

int32_t type_of(const ParquetColumn& column) {
  constexpr int32_t kTypes[] = {kInt64, kFloat, kDouble, kByteArray};
  return kTypes[column.values.index()];
}

uint64_t values_of_row(const ParquetColumn& column) {
  uint64_t count = 1;
  for (const uint32_t length : column.shape) count *= length;
  return count;
}

// Runs of one level, as RLE with a byte for each value.
class Levels {
 public:
  void add(uint8_t level, uint64_t count) {
    if (count_ != 0 && level != level_) flush();
    level_ = level;
    count_ += count;
  }
  // With their length in front.
  void append_to(std::vector<uint8_t>& page) {
    flush();
    const auto size = static_cast<uint32_t>(bytes_.size());
    for (int shift = 0; shift < 32; shift += 8) page.push_back(static_cast<uint8_t>(size >> shift));
    page.insert(page.end(), bytes_.begin(), bytes_.end());
  }

 private:
  void flush() {
    if (count_ == 0) return;
    put_varint(bytes_, count_ << 1);
    bytes_.push_back(level_);
    count_ = 0;
  }

  std::vector<uint8_t> bytes_;
  uint8_t level_ = 0;
  uint64_t count_ = 0;
};

// Level at which each value of a row begins a new list: 0 the row, 1 the outermost list.
std::vector<uint8_t> repetition_levels(const std::vector<uint32_t>& shape) {
  std::vector<uint8_t> levels{0};
  for (size_t depth = shape.size(); depth-- > 0;) {
    const std::vector<uint8_t> inner = levels;
    for (uint32_t i = 1; i < shape[depth]; ++i) {
      levels.insert(levels.end(), inner.begin(), inner.end());
      levels[levels.size() - inner.size()] = static_cast<uint8_t>(depth + 1);
    }
  }
  return levels;
}

template <typename T>
void append_values(const std::vector<T>& values, size_t first, size_t count, std::vector<uint8_t>& page) {
  if constexpr (std::is_same_v<T, std::string>) {
    for (size_t i = first; i < first + count; ++i) {
      const auto size = static_cast<uint32_t>(values[i].size());
      for (int shift = 0; shift < 32; shift += 8) page.push_back(static_cast<uint8_t>(size >> shift));
      page.insert(page.end(), values[i].begin(), values[i].end());
    }
  } else {
    static_assert(std::endian::native == std::endian::little);
    const size_t begin = page.size();
    page.resize(begin + count * sizeof(T));
    std::memcpy(page.data() + begin, values.data() + first, count * sizeof(T));
  }
}

void append_page(const ParquetColumn& column, uint64_t first_row, uint64_t rows,
                 const std::vector<uint8_t>& row_levels, std::vector<uint8_t>& file) {
  const uint64_t count = rows * row_levels.size();
  std::vector<uint8_t> page;
  if (!column.shape.empty()) {
    Levels repetition;
    for (uint64_t row = 0; row < rows; ++row) {
      for (const uint8_t level : row_levels) repetition.add(level, 1);
    }
    repetition.append_to(page);
  }
  Levels definition;
  definition.add(static_cast<uint8_t>(2 * column.shape.size() + 1), count);  // all values are there
  definition.append_to(page);
  std::visit([&](const auto& values) { append_values(values, first_row * row_levels.size(), count, page); },
             column.values);
  const auto page_bytes = static_cast<int32_t>(page.size());
  CompactWriter header(file);
  header.add(1, kDataPage);
  header.add(2, page_bytes);
  header.add(3, page_bytes);
  header.begin_struct(5);
  header.add(1, static_cast<int32_t>(count));
  header.add(2, kPlain);
  header.add(3, kRle);
  header.add(4, kRle);
  header.end();
  header.end();
  file.insert(file.end(), page.begin(), page.end());
}

Chunk append_chunk(const ParquetColumn& column, uint64_t rows, std::vector<uint8_t>& file) {
  const std::vector<uint8_t> row_levels = repetition_levels(column.shape);
  FIRE3DV_ASSERT(row_levels.size() == values_of_row(column));
  std::visit([&](const auto& values) { FIRE3DV_ASSERT(values.size() == rows * row_levels.size()); },
             column.values);
  Chunk chunk;
  chunk.begin = static_cast<int64_t>(file.size());
  chunk.values = static_cast<int64_t>(rows * row_levels.size());
  const uint64_t rows_of_page = std::max<uint64_t>(1, kPageBytes / (8 * row_levels.size()));
  for (uint64_t row = 0; row < rows; row += rows_of_page)
    append_page(column, row, std::min(rows_of_page, rows - row), row_levels, file);
  chunk.bytes = static_cast<int64_t>(file.size()) - chunk.begin;
  return chunk;
}

void add_group(CompactWriter& footer, int32_t repetition, std::string_view name, int32_t children,
               bool is_list) {
  footer.begin();
  footer.add(3, repetition);
  footer.add(4, name);
  footer.add(5, children);
  if (is_list) footer.add(6, kList);
  footer.end();
}

size_t schema_elements(const ParquetColumn& column) {
  return 2 * column.shape.size() + 1;
}

void add_schema(CompactWriter& footer, const ParquetColumn& column) {
  std::string_view name = column.name;
  for (size_t depth = 0; depth < column.shape.size(); ++depth) {
    add_group(footer, kOptional, name, 1, true);
    add_group(footer, kRepeated, "list", 1, false);
    name = "element";
  }
  footer.begin();
  footer.add(1, type_of(column));
  footer.add(3, kOptional);
  footer.add(4, name);
  if (type_of(column) == kByteArray) footer.add(6, kUtf8);
  footer.end();
}

void add_chunk(CompactWriter& footer, const ParquetColumn& column, const Chunk& chunk) {
  footer.begin();
  footer.add(2, chunk.begin);
  footer.begin_struct(3);
  footer.add(1, type_of(column));
  footer.begin_list(2, CompactType::i32, 2);
  footer.append(kPlain);
  footer.append(kRle);
  footer.begin_list(3, CompactType::binary, schema_elements(column));
  footer.append(column.name);
  for (size_t depth = 0; depth < column.shape.size(); ++depth) {
    footer.append(std::string_view("list"));
    footer.append(std::string_view("element"));
  }
  footer.add(4, kUncompressed);
  footer.add(5, chunk.values);
  footer.add(6, chunk.bytes);
  footer.add(7, chunk.bytes);
  footer.add(9, chunk.begin);
  footer.end();
  footer.end();
}

}  // namespace

std::vector<uint8_t> encode_parquet(const std::vector<ParquetColumn>& columns, uint64_t rows,
                                    const std::vector<std::pair<std::string, std::string>>& metadata) {
  FIRE3DV_ASSERT(rows > 0 && !columns.empty());
  std::vector<uint8_t> file(kMagic.begin(), kMagic.end());
  std::vector<Chunk> chunks;
  size_t elements = 1;
  for (const ParquetColumn& column : columns) {
    chunks.push_back(append_chunk(column, rows, file));
    elements += schema_elements(column);
  }
  const size_t footer_begin = file.size();
  CompactWriter footer(file);
  footer.add(1, int32_t{1});
  footer.begin_list(2, CompactType::structure, elements);
  footer.begin();
  footer.add(4, std::string_view("schema"));
  footer.add(5, static_cast<int32_t>(columns.size()));
  footer.end();
  for (const ParquetColumn& column : columns) add_schema(footer, column);
  footer.add(3, static_cast<int64_t>(rows));
  footer.begin_list(4, CompactType::structure, 1);
  footer.begin();
  footer.begin_list(1, CompactType::structure, columns.size());
  int64_t bytes = 0;
  for (size_t i = 0; i < columns.size(); ++i) {
    add_chunk(footer, columns[i], chunks[i]);
    bytes += chunks[i].bytes;
  }
  footer.add(2, bytes);
  footer.add(3, static_cast<int64_t>(rows));
  footer.end();
  if (!metadata.empty()) {
    footer.begin_list(5, CompactType::structure, metadata.size());
    for (const auto& [key, value] : metadata) {
      footer.begin();
      footer.add(1, std::string_view(key));
      footer.add(2, std::string_view(value));
      footer.end();
    }
  }
  footer.add(6, std::string_view("FIRE-3DV"));
  footer.end();
  const auto footer_bytes = static_cast<uint32_t>(file.size() - footer_begin);
  for (int shift = 0; shift < 32; shift += 8) file.push_back(static_cast<uint8_t>(footer_bytes >> shift));
  file.insert(file.end(), kMagic.begin(), kMagic.end());
  return file;
}

}  // namespace fire3dv::dataset
