#include "protocol/import/parquet/parquet_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "protocol/import/parquet/compact_reader.h"
#include "protocol/import/parquet/levels.h"
#include "protocol/import/parquet/page_codec.h"

namespace fire3dv::imported {
namespace {

using Bytes = std::span<const std::byte>;

// Codes of parquet.thrift.
constexpr int64_t kInt32 = 1, kInt64 = 2, kFloat = 4, kDouble = 5;
constexpr int64_t kRequired = 0, kOptional = 1, kRepeated = 2;
constexpr int64_t kPlain = 0, kPlainDictionary = 2, kRle = 3, kRleDictionary = 8, kByteStreamSplit = 9;
constexpr int64_t kDataPage = 0, kDictionaryPage = 2, kDataPage2 = 3;

constexpr std::string_view kMagic = "PAR1";
constexpr std::string_view kTooMuch = "the columns that are read have more than 4 GiB";
constexpr size_t kTailBytes = 8;  // length of the footer, and the magic bytes
constexpr size_t kMaxElements = 100'000, kMaxDepth = 32, kMaxGroups = 1'000'000, kMaxChunks = 4'000'000;

size_t bytes_of(int64_t type) {
  return type == kInt32 || type == kFloat ? 4 : 8;
}

template <typename T>
double number_at(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

double number_at(int64_t type, const std::byte* at) {
  static_assert(std::endian::native == std::endian::little);
  switch (type) {
    case kInt32:
      return number_at<int32_t>(at);
    case kInt64:
      return number_at<int64_t>(at);
    case kFloat:
      return double{number_at<float>(at)};
    default:
      return number_at<double>(at);
  }
}

bool decode_plain(int64_t type, Bytes bytes, size_t count, std::vector<double>& values) {
  const size_t size = bytes_of(type);
  if (count > bytes.size() / size) return false;
  for (size_t i = 0; i < count; ++i) values.push_back(number_at(type, bytes.data() + i * size));
  return true;
}

// All first bytes, all second bytes, and so on.
bool decode_split(int64_t type, Bytes bytes, size_t count, std::vector<double>& values) {
  const size_t size = bytes_of(type);
  if (count > bytes.size() / size) return false;
  std::byte number[8];
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < size; ++k) number[k] = bytes[k * count + i];
    values.push_back(number_at(type, number));
  }
  return true;
}

struct SchemaElement {
  int64_t type = -1, repetition = kRequired;
  size_t children = 0;
  std::string name;
};

SchemaElement read_element(CompactReader& reader) {
  SchemaElement element;
  reader.begin_struct();
  while (reader.next_field()) {
    switch (reader.field()) {
      case 1:
        element.type = reader.integer();
        break;
      case 3:
        element.repetition = reader.integer();
        break;
      case 4:
        element.name = reader.text();
        break;
      case 5: {
        const int64_t children = reader.integer();
        if (children < 0 || children > static_cast<int64_t>(kMaxElements)) reader.fail();
        element.children = static_cast<size_t>(children);
        break;
      }
      default:
        reader.skip();
    }
  }
  return element;
}

struct PageHeader {
  int64_t type = -1, bytes = -1, packed_bytes = -1;
  int64_t values = -1, encoding = -1;
  int64_t definition_encoding = kRle, repetition_encoding = kRle;  // of version 1
  int64_t definition_bytes = 0, repetition_bytes = 0;              // of version 2
  bool is_packed = true;
};

void read_data_header(CompactReader& reader, PageHeader& header) {
  reader.begin_struct_field();
  while (reader.next_field()) {
    switch (reader.field()) {
      case 1:
        header.values = reader.integer();
        break;
      case 2:
        header.encoding = reader.integer();
        break;
      case 3:
        header.definition_encoding = reader.integer();
        break;
      case 4:
        header.repetition_encoding = reader.integer();
        break;
      default:
        reader.skip();
    }
  }
}

void read_data_header_2(CompactReader& reader, PageHeader& header) {
  reader.begin_struct_field();
  while (reader.next_field()) {
    switch (reader.field()) {
      case 1:
        header.values = reader.integer();
        break;
      case 4:
        header.encoding = reader.integer();
        break;
      case 5:
        header.definition_bytes = reader.integer();
        break;
      case 6:
        header.repetition_bytes = reader.integer();
        break;
      case 7:
        header.is_packed = reader.boolean();
        break;
      default:
        reader.skip();
    }
  }
}

PageHeader read_page_header(CompactReader& reader) {
  PageHeader header;
  reader.begin_struct();
  while (reader.next_field()) {
    switch (reader.field()) {
      case 1:
        header.type = reader.integer();
        break;
      case 2:
        header.bytes = reader.integer();
        break;
      case 3:
        header.packed_bytes = reader.integer();
        break;
      case 5:
      case 7:  // of a dictionary: its first two fields are the same
        read_data_header(reader, header);
        break;
      case 8:
        read_data_header_2(reader, header);
        break;
      default:
        reader.skip();
    }
  }
  return header;
}

}  // namespace

// Decoder of the pages of a column chunk.
class ParquetFile::Pages {
 public:
  // left_bytes: of the file; pages are taken from it.
  Pages(const Leaf& leaf, const Chunk& chunk, uint64_t& left_bytes)
      : leaf_(leaf), chunk_(chunk), left_bytes_(left_bytes) {}

  // Error without the file's name.
  Result<void> read(Bytes bytes);

  std::vector<double> values;
  std::vector<uint32_t> repetition;  // of each value; empty: no lists

 private:
  Result<void> read_page(const PageHeader& header, Bytes packed);
  Result<void> read_dictionary(const PageHeader& header, Bytes page);
  // levels: cut off the front of the page.
  bool read_levels(const PageHeader& header, Bytes& levels, uint32_t max, int64_t size, size_t count,
                   std::vector<uint32_t>& out) const;
  Result<void> read_values(int64_t encoding, Bytes page, size_t count);

  const Leaf& leaf_;
  const Chunk& chunk_;
  uint64_t& left_bytes_;
  std::optional<std::vector<double>> dictionary_;
  uint64_t unpacked_bytes_ = 0;  // of all pages
};

Result<void> ParquetFile::Pages::read(Bytes bytes) {
  while (values.size() < static_cast<size_t>(chunk_.values)) {
    CompactReader reader(bytes);
    const PageHeader header = read_page_header(reader);
    if (!reader.ok()) return Error{"the header of a page is damaged"};
    bytes = bytes.subspan(reader.position());
    if (header.packed_bytes < 0 || static_cast<uint64_t>(header.packed_bytes) > bytes.size())
      return Error{"a page is longer than its column"};
    if (header.bytes < 0 || static_cast<uint64_t>(header.bytes) > kMaxPageBytes)
      return Error{"a page has more than " + std::to_string(kMaxPageBytes >> 20) + " MiB"};
    unpacked_bytes_ += static_cast<uint64_t>(header.bytes);
    if (unpacked_bytes_ > kMaxChunkBytes)
      return Error{"it has more than " + std::to_string(kMaxChunkBytes >> 20) + " MiB in a row group"};
    if (static_cast<uint64_t>(header.bytes) > left_bytes_) return Error{std::string(kTooMuch)};
    left_bytes_ -= static_cast<uint64_t>(header.bytes);
    const Bytes packed = bytes.first(static_cast<size_t>(header.packed_bytes));
    bytes = bytes.subspan(packed.size());
    const size_t before = values.size();
    if (auto done = read_page(header, packed); !done) return done;
    if (bytes.empty() && values.size() == before && before < static_cast<size_t>(chunk_.values))
      return Error{"the pages have fewer values than the column"};
  }
  return {};
}

Result<void> ParquetFile::Pages::read_dictionary(const PageHeader& header, Bytes page) {
  if (dictionary_ || header.values < 0 || static_cast<uint64_t>(header.values) > kMaxNumbers ||
      (header.encoding != kPlain && header.encoding != kPlainDictionary))
    return Error{"the dictionary of a column is damaged"};
  std::vector<double> numbers;
  if (!decode_plain(leaf_.type, page, static_cast<size_t>(header.values), numbers))
    return Error{"the dictionary of a column is damaged"};
  dictionary_ = std::move(numbers);
  return {};
}

bool ParquetFile::Pages::read_levels(const PageHeader& header, Bytes& levels, uint32_t max, int64_t size,
                                     size_t count, std::vector<uint32_t>& out) const {
  if (header.type == kDataPage) {
    if (max == 0) return true;  // no levels are stored
    uint32_t length = 0;
    if (levels.size() < sizeof length) return false;
    std::memcpy(&length, levels.data(), sizeof length);
    levels = levels.subspan(sizeof length);
    size = length;
  }
  if (size < 0 || static_cast<uint64_t>(size) > levels.size()) return false;
  const Bytes own = levels.first(static_cast<size_t>(size));
  levels = levels.subspan(own.size());
  if (max == 0) return true;
  return decode_hybrid(own, static_cast<uint32_t>(std::bit_width(max)), count, out) &&
         std::all_of(out.end() - static_cast<std::ptrdiff_t>(count), out.end(),
                     [&](uint32_t level) { return level <= max; });
}

Result<void> ParquetFile::Pages::read_page(const PageHeader& header, Bytes packed) {
  if (header.type == kDictionaryPage) {
    auto page = decompress(chunk_.codec, packed, static_cast<size_t>(header.bytes));
    return page ? read_dictionary(header, *page) : page.error();
  }
  const bool is_second = header.type == kDataPage2;
  if (header.type != kDataPage && !is_second) return {};  // an index
  if (header.values < 0 ||
      static_cast<size_t>(header.values) > static_cast<size_t>(chunk_.values) - values.size())
    return Error{"the pages have more values than the column"};
  if ((leaf_.max_definition != 0 && header.definition_encoding != kRle) ||
      (leaf_.max_repetition != 0 && header.repetition_encoding != kRle))
    return Error{"its levels have an encoding that is not read"};
  const auto count = static_cast<size_t>(header.values);
  // Levels of version 2 are not compressed.
  if (header.repetition_bytes < 0 || header.repetition_bytes > header.bytes || header.definition_bytes < 0 ||
      header.definition_bytes > header.bytes - header.repetition_bytes)
    return Error{"the levels of a page are damaged"};
  const int64_t level_bytes = is_second ? header.repetition_bytes + header.definition_bytes : 0;
  if (static_cast<uint64_t>(level_bytes) > packed.size()) return Error{"the levels of a page are damaged"};
  const auto level_size = static_cast<size_t>(level_bytes);
  auto page = decompress(header.is_packed ? chunk_.codec : kUncompressed, packed.subspan(level_size),
                         static_cast<size_t>(header.bytes) - level_size);
  if (!page) return page.error();
  Bytes rest = *page, levels = is_second ? packed.first(level_size) : rest;
  std::vector<uint32_t> definition;
  if (!read_levels(header, levels, leaf_.max_repetition, header.repetition_bytes, count, repetition) ||
      !read_levels(header, levels, leaf_.max_definition, header.definition_bytes, count, definition))
    return Error{"the levels of a page are damaged"};
  if (!is_second) rest = levels;
  for (const uint32_t level : definition) {
    if (level != leaf_.max_definition) return Error{"it has rows without a value"};
  }
  return read_values(header.encoding, rest, count);
}

Result<void> ParquetFile::Pages::read_values(int64_t encoding, Bytes page, size_t count) {
  const Error damaged{"the values of a page are damaged"};
  if (encoding == kPlain) {
    if (!decode_plain(leaf_.type, page, count, values)) return damaged;
    return {};
  }
  if (encoding == kByteStreamSplit) {
    if (!decode_split(leaf_.type, page, count, values)) return damaged;
    return {};
  }
  if (encoding != kPlainDictionary && encoding != kRleDictionary)
    return Error{"its encoding, number " + std::to_string(encoding) +
                 ", is not read; plain, dictionary and split bytes are"};
  if (!dictionary_ || page.empty()) return damaged;
  std::vector<uint32_t> indices;
  if (!decode_hybrid(page.subspan(1), static_cast<uint32_t>(page[0]), count, indices)) return damaged;
  for (const uint32_t index : indices) {
    if (index >= dictionary_->size()) return damaged;
    values.push_back((*dictionary_)[index]);
  }
  return {};
}

Error ParquetFile::fault(const std::string& what) const {
  return Error{quote(source_->name()) + ": " + what};
}

Result<ParquetFile> ParquetFile::open(std::unique_ptr<record::Source> source) {
  ParquetFile file;
  file.source_ = std::move(source);
  if (auto read = file.read_footer(); !read) return read.error();
  return file;
}

// Metadata at the end of the file.
Result<void> ParquetFile::read_footer() {
  const uint64_t size = source_->size();
  std::byte tail[kTailBytes];
  if (size < kMagic.size() + kTailBytes) return fault("it is no Parquet file");
  if (auto read = source_->read(size - kTailBytes, tail); !read) return read;
  uint32_t footer_bytes = 0;
  std::memcpy(&footer_bytes, tail, sizeof footer_bytes);
  if (std::memcmp(tail + sizeof footer_bytes, kMagic.data(), kMagic.size()) != 0 ||
      footer_bytes > size - kMagic.size() - kTailBytes)
    return fault("it is no Parquet file, or not whole");
  if (footer_bytes > kMaxFooterBytes)
    return fault("its metadata has more than " + std::to_string(kMaxFooterBytes >> 20) + " MiB");
  std::vector<std::byte> footer(footer_bytes);
  if (auto read = source_->read(size - kTailBytes - footer_bytes, footer); !read) return read;

  CompactReader reader(footer);
  std::vector<SchemaElement> schema;
  size_t chunks = 0;
  const auto read_chunk = [&] {
    Chunk chunk;
    if (++chunks > kMaxChunks) reader.fail();
    int64_t dictionary = 0;
    reader.begin_struct();
    while (reader.next_field()) {
      if (reader.field() != 3) {
        reader.skip();
        continue;
      }
      reader.begin_struct_field();
      while (reader.next_field()) {
        switch (reader.field()) {
          case 4:
            chunk.codec = reader.integer();
            break;
          case 5:
            chunk.values = reader.integer();
            break;
          case 7:
            chunk.bytes = reader.integer();
            break;
          case 9:
            chunk.begin = reader.integer();
            break;
          case 11:
            dictionary = reader.integer();
            break;
          default:
            reader.skip();
        }
      }
    }
    if (dictionary > 0) chunk.begin = std::min(chunk.begin, dictionary);  // some writers have 0 for none
    return chunk;
  };
  const auto read_group = [&] {
    Group group;
    reader.begin_struct();
    while (reader.next_field()) {
      if (reader.field() == 1) {
        for (size_t left = reader.begin_list(CompactType::structure, kMaxElements); left > 0 && reader.ok();
             --left)
          group.chunks.push_back(read_chunk());
      } else if (reader.field() == 3) {
        group.rows = reader.integer();
      } else {
        reader.skip();
      }
    }
    return group;
  };
  reader.begin_struct();
  while (reader.next_field()) {
    if (reader.field() == 2) {
      for (size_t left = reader.begin_list(CompactType::structure, kMaxElements); left > 0 && reader.ok();
           --left)
        schema.push_back(read_element(reader));
    } else if (reader.field() == 4) {
      for (size_t left = reader.begin_list(CompactType::structure, kMaxGroups); left > 0 && reader.ok();
           --left)
        groups_.push_back(read_group());
    } else {
      reader.skip();
    }
  }
  if (!reader.ok() || schema.empty()) return fault("its metadata is damaged");

  // The tree of elements, parents first: open groups with the elements that they still lack.
  struct Open {
    size_t left;
    uint32_t definition, repetition;
  };
  std::vector<Open> open{{schema[0].children, 0, 0}};
  for (size_t i = 1; i < schema.size(); ++i) {
    while (!open.empty() && open.back().left == 0) open.pop_back();
    if (open.empty() || open.size() > kMaxDepth) return fault("its schema is damaged");
    --open.back().left;
    Open inner = open.back();
    if (open.size() == 1) columns_.push_back(schema[i].name);
    inner.definition += schema[i].repetition == kOptional || schema[i].repetition == kRepeated;
    inner.repetition += schema[i].repetition == kRepeated;
    if (schema[i].children == 0) {
      leaves_.push_back({columns_.size() - 1, schema[i].type, inner.definition, inner.repetition});
    } else {
      open.push_back({schema[i].children, inner.definition, inner.repetition});
    }
  }
  for (const Open& group : open) {
    if (group.left != 0) return fault("its schema is damaged");
  }
  uint64_t chunk_bytes = 0;
  for (const Group& group : groups_) {
    if (group.chunks.size() != leaves_.size() || group.rows < 0) return fault("its metadata is damaged");
    for (const Chunk& chunk : group.chunks) {
      if (chunk.bytes < 0 || static_cast<uint64_t>(chunk.bytes) > size - chunk_bytes)
        return fault("its columns have more bytes than the file");
      chunk_bytes += static_cast<uint64_t>(chunk.bytes);
    }
  }
  return {};
}

Result<size_t> ParquetFile::find_leaf(const std::string& column) const {
  std::optional<size_t> found;
  for (size_t i = 0; i < leaves_.size(); ++i) {
    if (columns_[leaves_[i].column] != column) continue;
    if (found) return fault("column " + quote(column) + " has several parts");
    found = i;
  }
  if (!found) return fault("it has no column " + quote(column));
  const Leaf& leaf = leaves_[*found];
  if (leaf.type != kInt32 && leaf.type != kInt64 && leaf.type != kFloat && leaf.type != kDouble)
    return fault("column " + quote(column) + " has no numbers");
  if (leaf.max_repetition > 1) return fault("column " + quote(column) + " has lists of lists");
  return *found;
}

Result<NumberRows> ParquetFile::read_numbers(size_t group_index, const std::string& column) {
  const auto found = find_leaf(column);
  if (!found) return found.error();
  const Leaf& leaf = leaves_[*found];
  const Group& group = groups_[group_index];
  const Chunk& chunk = group.chunks[*found];
  const auto fault_of = [&](const std::string& what) {
    return fault("column " + quote(column) + ": " + what);
  };
  if (auto known = check_codec(chunk.codec); !known) return fault_of(known.error().message);
  if (chunk.values < 0 || static_cast<uint64_t>(chunk.values) > kMaxNumbers)
    return fault_of("it has more than " + std::to_string(kMaxNumbers) + " numbers in a row group");
  const uint64_t size = source_->size();
  if (chunk.begin < 0 || static_cast<uint64_t>(chunk.begin) > size ||
      static_cast<uint64_t>(chunk.bytes) > size - static_cast<uint64_t>(chunk.begin))
    return fault_of("it lies outside of the file");
  if (static_cast<uint64_t>(chunk.bytes) > kMaxChunkBytes)
    return fault_of("it has more than " + std::to_string(kMaxChunkBytes >> 20) + " MiB in a row group");
  const uint64_t number_bytes = static_cast<uint64_t>(chunk.values) * sizeof(double);
  if (number_bytes > left_bytes_) return fault_of(std::string(kTooMuch));
  left_bytes_ -= number_bytes;
  std::vector<std::byte> bytes(static_cast<size_t>(chunk.bytes));
  if (auto read = source_->read(static_cast<uint64_t>(chunk.begin), bytes); !read) return read.error();
  Pages pages(leaf, chunk, left_bytes_);
  if (auto read = pages.read(bytes); !read) return fault_of(read.error().message);
  const auto rows = static_cast<size_t>(group.rows);
  NumberRows numbers{1, std::move(pages.values)};
  if (leaf.max_repetition != 0) numbers.width = rows == 0 ? 0 : numbers.values.size() / rows;
  for (size_t i = 0; i < pages.repetition.size(); ++i) {
    const bool begins = pages.repetition[i] == 0;
    if (numbers.width == 0 || begins != (i % numbers.width == 0))
      return fault_of("its lists have different lengths");
  }
  if (numbers.values.size() != rows * numbers.width)
    return fault_of("it has more or fewer rows than its group");
  return numbers;
}

}  // namespace fire3dv::imported
