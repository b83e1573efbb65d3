// Test of the decoders of foreign messages: bytes written by hand, and each shorter message.
#include <gtest/gtest.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/import/messages/messages.h"

namespace fire3dv::imported {
namespace {

using Bytes = std::vector<std::byte>;

const Topic kTf{"/tf", "tf2_msgs/msg/TFMessage", "cdr"};
const Topic kJoints{"/joint_states", "sensor_msgs/msg/JointState", "cdr"};
const Topic kProtobuf{"/a", "foxglove.FrameTransform", "protobuf"};
const Topic kJson{"/b", "foxglove.FrameTransforms", "json"};

Bytes bytes_of(std::string_view text) {
  const auto span = std::as_bytes(std::span(text));
  return {span.begin(), span.end()};
}

void put(Bytes& to, uint32_t value) {
  while (to.size() % 4 != 0) to.push_back({});
  for (size_t i = 0; i < 4; ++i) to.push_back(static_cast<std::byte>(value >> (8 * i)));
}
void put_text(Bytes& to, std::string_view text) {
  put(to, static_cast<uint32_t>(text.size() + 1));
  const Bytes bytes = bytes_of(text);
  to.insert(to.end(), bytes.begin(), bytes.end());
  to.push_back({});
}
// Alignment of 8 counts from the end of the header of four bytes.
void put_doubles(Bytes& to, const std::vector<double>& numbers) {
  while (!numbers.empty() && (to.size() - 4) % 8 != 0) to.push_back({});
  for (const double number : numbers)
    for (size_t i = 0; i < 8; ++i)
      to.push_back(static_cast<std::byte>(std::bit_cast<uint64_t>(number) >> (8 * i)));
}

Bytes begin_cdr() {
  return {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
}

Bytes tf_message() {
  Bytes message = begin_cdr();
  put(message, 1);
  put(message, 7);
  put(message, 500);
  put_text(message, "map");
  put_text(message, "base_link");
  put_doubles(message, {1, -2, 3, 0, 0, 0.6, 0.8});
  return message;
}

TEST(ImportMessages, TfMessage) {
  const Bytes message = tf_message();
  std::vector<TransformSample> samples;
  ASSERT_TRUE(decode(kTf, message, samples).ok());
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].parent, "map");
  EXPECT_EQ(samples[0].child, "base_link");
  EXPECT_EQ(samples[0].stamp_ns, 7'000'000'500);
  const frames::Transform wanted{{1, -2, 3}, {0, 0, 0.6, 0.8}};
  EXPECT_EQ(samples[0].parent_from_child, wanted);
  for (size_t length = 0; length < message.size(); ++length)
    EXPECT_FALSE(decode(kTf, std::span(message).first(length), samples).ok()) << length;
}

TEST(ImportMessages, CountsBeyondTheMessage) {
  Bytes message = begin_cdr();
  put(message, UINT32_MAX);
  std::vector<TransformSample> samples;
  EXPECT_FALSE(decode(kTf, message, samples).ok());
  EXPECT_TRUE(samples.empty());
  Bytes other = tf_message();
  other[1] = std::byte{7};  // XCDR version 2
  EXPECT_FALSE(decode(kTf, other, samples).ok());
}

TEST(ImportMessages, JointState) {
  const auto message_of = [](const std::vector<double>& positions) {
    Bytes message = begin_cdr();
    put(message, 3);
    put(message, 0);
    put_text(message, "");
    put(message, 2);
    put_text(message, "shoulder");
    put_text(message, "elbow");
    put(message, static_cast<uint32_t>(positions.size()));
    put_doubles(message, positions);
    return message;
  };
  JointState state;
  ASSERT_TRUE(decode(kJoints, message_of({0.25, -1}), state).ok());
  EXPECT_EQ(state.names, (std::vector<std::string>{"shoulder", "elbow"}));
  EXPECT_EQ(state.positions, (std::vector<double>{0.25, -1}));
  EXPECT_EQ(state.stamp_ns, 3'000'000'000);
  ASSERT_TRUE(decode(kJoints, message_of({}), state).ok());
  EXPECT_TRUE(state.positions.empty());
  const Result<void> one = decode(kJoints, message_of({1}), state);
  ASSERT_FALSE(one.ok());
  EXPECT_EQ(one.error().message, "it has 1 positions of 2 joints");
}

TEST(ImportMessages, Protobuf) {
  // timestamp {seconds: 1, nanos: 5}, parent "p", child "c", translation {y: 2.0}, rotation {w: 1.0}
  const std::string message(
      "\x0a\x04\x08\x01\x10\x05\x12\x01p\x1a\x01"
      "c\x22\x09\x11\0\0\0\0\0\0\0\x40"
      "\x2a\x09\x21\0\0\0\0\0\0\xf0\x3f",
      34);
  std::vector<TransformSample> samples;
  ASSERT_TRUE(decode(kProtobuf, bytes_of(message), samples).ok());
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].parent, "p");
  EXPECT_EQ(samples[0].child, "c");
  EXPECT_EQ(samples[0].stamp_ns, 1'000'000'005);
  const frames::Transform wanted{{0, 2, 0}, {0, 0, 0, 1}};
  EXPECT_EQ(samples[0].parent_from_child, wanted);
  EXPECT_FALSE(decode(kProtobuf, bytes_of(message.substr(0, 30)), samples).ok());
  EXPECT_FALSE(decode(kProtobuf, bytes_of("\x0b"), samples).ok());                  // a group
  EXPECT_FALSE(decode(kProtobuf, bytes_of("\x0a\xff\xff\xff\x7f"), samples).ok());  // a length beyond the end
}

TEST(ImportMessages, Json) {
  const auto message = [](std::string_view rotation) {
    return bytes_of(
        R"({"transforms":[{"timestamp":{"sec":2,"nsec":3},"parent_frame_id":"p","child_frame_id":"c",)"
        R"("translation":{"x":1,"y":2,"z":3},"rotation":)" +
        std::string(rotation) + "}]}");
  };
  std::vector<TransformSample> samples;
  ASSERT_TRUE(decode(kJson, message(R"({"x":0,"y":0,"z":0,"w":1})"), samples).ok());
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].stamp_ns, 2'000'000'003);
  const frames::Transform wanted{{1, 2, 3}, {0, 0, 0, 1}};
  EXPECT_EQ(samples[0].parent_from_child, wanted);
  EXPECT_FALSE(decode(kJson, message(R"({"x":0,"y":0,"z":0})"), samples).ok());
  EXPECT_FALSE(decode(kJson, message(R"({"x":0,"y":0,"z":0,"w":"1"})"), samples).ok());
  EXPECT_FALSE(decode(kJson, bytes_of(std::string(100'000, '[')), samples).ok());
  EXPECT_FALSE(decode(kJson, bytes_of("{"), samples).ok());
}

// Messages of more elements than the limit, and of as many.
TEST(ImportMessages, TooManyElements) {
  for (const size_t count : {kMaxElements, kMaxElements + 1}) {
    const bool is_read = count == kMaxElements;
    std::vector<TransformSample> samples;
    Bytes transforms = begin_cdr(), joints = begin_cdr();
    put(transforms, static_cast<uint32_t>(count));
    for (size_t i = 0; i < count; ++i) {
      for (int k = 0; k < 4; ++k) put(transforms, 0);  // stamp, and names of no bytes
      put_doubles(transforms, {0, 0, 0, 0, 0, 0, 1});
    }
    EXPECT_EQ(decode(kTf, transforms, samples).ok(), is_read);
    EXPECT_EQ(samples.size(), is_read ? count : 0u);

    for (int k = 0; k < 3; ++k) put(joints, 0);
    put(joints, static_cast<uint32_t>(count));
    for (size_t i = 0; i < count; ++i) put(joints, 0);
    put(joints, 0);
    JointState state;
    EXPECT_EQ(decode(kJoints, joints, state).ok(), is_read);
    EXPECT_EQ(state.names.size(), is_read ? count : 0u);

    std::string fields;
    for (size_t i = 0; i < count; ++i) fields += std::string("\x0a\0", 2);
    const Topic many{"/a", "foxglove.FrameTransforms", "protobuf"};
    EXPECT_EQ(decode(many, bytes_of(fields), samples).ok(), is_read);
    EXPECT_EQ(samples.size(), kMaxElements);
  }
  std::string json = R"({"transforms":[0)";
  for (size_t i = 0; i < kMaxElements; ++i) json += ",0";
  std::vector<TransformSample> samples;
  const Result<void> elements = decode(kJson, bytes_of(json + "]}"), samples);
  ASSERT_FALSE(elements.ok());
  EXPECT_EQ(elements.error().message, "it has more than 65536 elements");
  std::string values = "[0";
  for (size_t i = 0; i < 48 * kMaxElements; ++i) values += ",0";
  const Result<void> many_values = decode(kJson, bytes_of(values + "]"), samples);
  ASSERT_FALSE(many_values.ok());
  EXPECT_EQ(many_values.error().message, "it has more than 65536 elements");
}

TEST(ImportMessages, Types) {
  EXPECT_EQ(content_of(kTf), Content::transforms);
  EXPECT_EQ(content_of({"/tf", "tf2_msgs/TFMessage", "cdr"}), Content::transforms);
  EXPECT_EQ(content_of(kJoints), Content::joint_states);
  EXPECT_EQ(content_of({"/scan", "sensor_msgs/msg/LaserScan", "cdr"}), Content::other);
  EXPECT_TRUE(check_encoding(kJson).ok());
  EXPECT_FALSE(check_encoding({"/tf", "tf2_msgs/msg/TFMessage", "json"}).ok());
  EXPECT_FALSE(check_encoding({"/a", "foxglove.FrameTransform", "flatbuffer"}).ok());
}

}  // namespace
}  // namespace fire3dv::imported
