// Test of BasisLZ's Huffman tables, written bit by bit.
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "renderer/scene/textures/ktx2/huffman.h"
#include "tests/unit/renderer/scene/textures/ktx2/ktx2_builder.h"

namespace fire3dv::scene::ktx2 {
namespace {

using ktx2_test::BitWriter;

std::vector<uint32_t> symbols_of(const std::vector<std::byte>& bytes, size_t count) {
  BitReader reader(bytes);
  const auto code = HuffmanCode::read(reader);
  std::vector<uint32_t> symbols;
  for (size_t i = 0; code && i < count; ++i) {
    const auto symbol = code->decode(reader);
    if (!symbol) break;
    symbols.push_back(*symbol);
  }
  return symbols;
}

TEST(BasisLzHuffman, CodesMatchDeflate) {
  // Lengths 2, 1, 3, 3 of A, B, C, D: the codes 10, 0, 110, 111 (RFC 1951, section 3.2.2).
  BitWriter writer;
  writer.table_head(4);
  for (const uint32_t length : {2, 1, 3, 3}) writer.length_symbol(length);
  writer.code(0b111, 3);
  writer.code(0b0, 1);
  writer.code(0b10, 2);
  writer.code(0b110, 3);
  EXPECT_EQ(symbols_of(writer.bytes(), 4), (std::vector<uint32_t>{3, 1, 0, 2}));
}

TEST(BasisLzHuffman, RunsOfLengths) {
  // Length 8, repeated 3 + 3 times, zeros 3 + 2 and 11 + 100, length 8, repeated 7 + 120 times and 3 more.
  BitWriter writer;
  writer.table_head(7 + 5 + 111 + 1 + 127 + 3);
  writer.length_symbol(8);
  writer.length_symbol(19);
  writer.bits(3, 2);
  writer.length_symbol(17);
  writer.bits(2, 3);
  writer.length_symbol(18);
  writer.bits(100, 7);
  writer.length_symbol(8);
  writer.length_symbol(20);
  writer.bits(120, 7);
  writer.length_symbol(19);
  writer.bits(0, 2);
  writer.code(6, 8);    // the last of the first seven
  writer.code(7, 8);    // the first after the zeros
  writer.code(137, 8);  // the last one
  EXPECT_EQ(symbols_of(writer.bytes(), 3), (std::vector<uint32_t>{6, 123, 253}));
}

TEST(BasisLzHuffman, DamagedTablesAreRefused) {
  const auto is_read = [](const std::function<void(BitWriter&)>& write) {
    BitWriter writer;
    write(writer);
    for (int i = 0; i < 8; ++i) writer.bits(0, 8);
    BitReader reader(writer.bytes());
    return HuffmanCode::read(reader).has_value();
  };
  EXPECT_TRUE(is_read([](BitWriter& w) { w.uniform_table(4, 2); }));
  EXPECT_TRUE(is_read([](BitWriter& w) { w.bits(0, 14); })) << "no symbols";
  EXPECT_FALSE(is_read([](BitWriter& w) { w.uniform_table(5, 2); })) << "five codes of two bits";
  EXPECT_FALSE(is_read([](BitWriter& w) {
    w.bits(4, 14);
    w.bits(22, 5);
  })) << "more lengths of lengths than there are";
  EXPECT_FALSE(is_read([](BitWriter& w) {
    w.table_head(4);
    w.length_symbol(19);
  })) << "a repetition of nothing";
  EXPECT_FALSE(is_read([](BitWriter& w) {
    w.table_head(4);
    w.length_symbol(0);
    w.length_symbol(19);
  })) << "a repetition of 0";
  EXPECT_FALSE(is_read([](BitWriter& w) {
    w.table_head(4);
    w.length_symbol(18);
  })) << "a run beyond the end";
  BitWriter cut_short;
  cut_short.uniform_table(300, 9);
  BitReader reader(std::span(cut_short.bytes()).first(60));
  EXPECT_FALSE(HuffmanCode::read(reader).has_value());
}

}  // namespace
}  // namespace fire3dv::scene::ktx2
