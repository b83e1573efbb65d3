// Writer of Parquet files: numbers, texts, and nested lists of them whose lengths are the same in all rows.
// Plain encoding, not compressed, one row group. The schema is that of Apache Arrow's writer: all values are
// optional, and lists have three levels (github.com/apache/parquet-format). Equal calls give equal bytes.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace fire3dv::dataset {

struct ParquetColumn {
  std::string name;
  std::vector<uint32_t> shape;  // of the value of a row; empty: one number or text
  // Row after row, the last index first.
  std::variant<std::vector<int64_t>, std::vector<float>, std::vector<double>, std::vector<std::string>>
      values;
};

// All columns have so many rows, at least one; no length of a shape is 0. metadata: keys and values of the
// file.
std::vector<uint8_t> encode_parquet(const std::vector<ParquetColumn>& columns, uint64_t rows,
                                    const std::vector<std::pair<std::string, std::string>>& metadata);

}  // namespace fire3dv::dataset
