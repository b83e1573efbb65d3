// Reader of numbers in Parquet files of other programs (github.com/apache/parquet-format). Files are
// untrusted: sizes are limited, and faults are errors. Read are columns of 32- and 64-bit integers and
// floats, and of lists of them; pages of both versions; plain, dictionary and split-byte encoding; see
// page_codec.h. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/record/mcap/file.h"

namespace fire3dv::imported {

// Rows of as many numbers each.
struct NumberRows {
  size_t width = 0;
  std::vector<double> values;  // row after row
};

class ParquetFile {
 public:
  static constexpr uint64_t kMaxNumbers = uint64_t{1} << 25;  // of a column of a row group
  static constexpr uint64_t kMaxFooterBytes = 64 << 20, kMaxChunkBytes = 512 << 20, kMaxPageBytes = 128 << 20;
  static constexpr uint64_t kMaxReadBytes = uint64_t{4} << 30;  // of all that is read, unpacked

  // Errors of all methods name the file.
  static Result<ParquetFile> open(std::unique_ptr<record::Source> source);

  size_t row_groups() const { return groups_.size(); }
  // Numbers of a top-level column. Fails if there is no such column, if it holds other values or nested
  // lists, if a value is missing, or if its lists have different lengths.
  Result<NumberRows> read_numbers(size_t group, const std::string& column);

 private:
  struct Leaf {
    size_t column = 0;  // top-level; index in columns_
    int64_t type = 0;
    uint32_t max_definition = 0, max_repetition = 0;
  };
  struct Chunk {
    int64_t codec = 0, values = 0, begin = 0, bytes = 0;
  };
  struct Group {
    int64_t rows = 0;
    std::vector<Chunk> chunks;  // by leaf
  };
  class Pages;

  Result<void> read_footer();
  Result<size_t> find_leaf(const std::string& column) const;
  Error fault(const std::string& what) const;

  std::unique_ptr<record::Source> source_;
  std::vector<std::string> columns_;
  std::vector<Leaf> leaves_;
  std::vector<Group> groups_;
  uint64_t left_bytes_ = kMaxReadBytes;
};

}  // namespace fire3dv::imported
