// Conformance test of the wire codec against golden messages: bytes decode to the JSON, and the JSON encodes
// to the bytes. The committed files are the only reference, so a matching change of encoder and decoder
// fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "protocol/wire/decode.h"
#include "tests/conformance/json_message.h"

namespace fire3dv::conformance {
namespace {

using Json = nlohmann::ordered_json;

const std::filesystem::path kFolder = FIRE3DV_CONFORMANCE_DATA;

wire::Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_FALSE(text.empty()) << path;
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

struct Golden {
  std::string name;
  Json meaning;
  wire::Bytes bytes;
};

std::vector<Golden> all_golden() {
  std::vector<Golden> result;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() != ".json") continue;
    std::ifstream file(entry.path());
    std::filesystem::path bin = entry.path();
    result.push_back({entry.path().stem(), Json::parse(file), read_bytes(bin.replace_extension(".bin"))});
  }
  EXPECT_GE(result.size(), 50u) << "golden messages are missing from " << kFolder;
  return result;
}

TEST(Conformance, BytesMeanWhatTheJsonSays) {
  wire::Decoder decoder;
  std::set<std::string> types;
  for (const Golden& golden : all_golden()) {
    if (!golden.meaning.contains("message")) continue;
    const auto message = decoder.decode(golden.bytes);
    ASSERT_TRUE(message.ok()) << golden.name << ": " << message.error().message;
    EXPECT_EQ(to_json(*message).dump(1), golden.meaning.at("message").dump(1)) << golden.name;
    types.insert(golden.meaning.at("message").at("type").get<std::string>());
  }
  EXPECT_EQ(types.size(), std::variant_size_v<wire::Message>) << "a message has no golden file";
}

// Aligned bytes are decoded without a copy, others after one; both results are those of decode().
TEST(Conformance, DecodesInPlaceLikeFromCopy) {
  wire::Decoder decoder;
  for (const Golden& golden : all_golden()) {
    const auto from_copy = decoder.decode(golden.bytes);
    const std::string expected = from_copy.ok() ? to_json(*from_copy).dump() : from_copy.error().message;
    wire::Bytes memory(golden.bytes.size() + 32);
    const size_t aligned = (16 - reinterpret_cast<uintptr_t>(memory.data()) % 16) % 16;
    for (const size_t offset : {aligned, aligned + 1, aligned + 8}) {
      std::ranges::copy(golden.bytes, memory.begin() + static_cast<std::ptrdiff_t>(offset));
      const std::span<const std::byte> bytes(memory.data() + offset, golden.bytes.size());
      const auto in_place = decoder.decode_in_place(bytes);
      ASSERT_EQ(in_place.ok(), from_copy.ok()) << golden.name << " at offset " << offset;
      EXPECT_EQ(in_place.ok() ? to_json(*in_place).dump() : in_place.error().message, expected)
          << golden.name;
      const auto* frame = in_place.ok() ? std::get_if<wire::PoseFrameView>(&*in_place) : nullptr;
      if (frame == nullptr || frame->poses.empty()) continue;
      const auto* poses = reinterpret_cast<const std::byte*>(frame->poses.data());
      EXPECT_EQ(poses >= bytes.data() && poses < bytes.data() + bytes.size(), offset == aligned)
          << golden.name;
    }
  }
}

TEST(Conformance, TheJsonEncodesToTheBytes) {
  for (const Golden& golden : all_golden()) {
    if (!golden.meaning.contains("message") || golden.meaning.contains("only_read")) continue;
    EXPECT_EQ(encode_json(golden.meaning.at("message")), golden.bytes) << golden.name;
  }
}

TEST(Conformance, RefusalsNameTheField) {
  wire::Decoder decoder;
  for (const Golden& golden : all_golden()) {
    if (!golden.meaning.contains("refused")) continue;
    const std::string field = golden.meaning.at("refused");
    const auto message = decoder.decode(golden.bytes);
    ASSERT_FALSE(message.ok()) << golden.name;
    EXPECT_NE(message.error().message.find(field), std::string::npos)
        << golden.name << ": " << message.error().message;
    EXPECT_EQ(message.error().message.find('\n'), std::string::npos) << golden.name;
  }
}

TEST(Conformance, EveryTruncationIsRefused) {
  wire::Decoder decoder;
  for (const Golden& golden : all_golden()) {
    // A reader of this version ignores these fields, so their absence goes unnoticed.
    if (!golden.meaning.contains("message") || golden.meaning.contains("only_read")) continue;
    const std::span<const std::byte> bytes(golden.bytes);
    // Up to 8 trailing bytes may be padding.
    for (size_t length = 0; length + 8 < bytes.size(); ++length) {
      const auto message = decoder.decode(bytes.first(length));
      ASSERT_FALSE(message.ok()) << golden.name << " cut to " << length << " of " << bytes.size() << " bytes";
      ASSERT_FALSE(message.error().message.empty());
    }
  }
}

TEST(Conformance, AWrongIdentifierIsRefused) {
  wire::Decoder decoder;
  for (Golden& golden : all_golden()) {
    for (size_t i = 4; i < 8; ++i) {
      wire::Bytes bytes = golden.bytes;
      bytes[i] ^= std::byte{0x20};
      const auto message = decoder.decode(bytes);
      ASSERT_FALSE(message.ok()) << golden.name;
      EXPECT_NE(message.error().message.find("identifier"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace fire3dv::conformance
