// Test of the wire codec beyond the golden messages: layout, limits, allocations, and mutated input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "protocol/wire/check.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"
#include "tests/unit/allocation_count.h"

namespace fire3dv::wire {
namespace {

constexpr size_t kPoseFrameHead = 120;  // as in SPEC.md

std::vector<Affine3x4> poses_of(size_t count) {
  std::vector<Affine3x4> poses(count);
  for (size_t i = 0; i < count * 12; ++i) poses[i / 12].m[i % 12] = static_cast<float>(i) * 0.37f - 100;
  return poses;
}

PoseFrameView frame_of(std::span<const Affine3x4> poses, uint64_t sequence = 1) {
  PoseFrameView frame;
  frame.header = {0x0102030405060708, sequence, -7, 0x1112131415161718, 3, kFrameDiscontinuity};
  frame.node_count = static_cast<uint32_t>(poses.size());
  frame.poses = poses;
  return frame;
}

Bytes join(const MessagePieces& pieces) {
  Bytes bytes(pieces.head.begin(), pieces.head.end());
  bytes.insert(bytes.end(), pieces.body.begin(), pieces.body.end());
  return bytes;
}

template <typename T>
T read_at(const Bytes& bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

std::vector<Bytes> one_of_each() {
  StreamDescription description;
  description.epoch = 5;
  description.adapter_name = "test";
  description.node_names = {"a", "b", "c/d", "ü"};
  description.body_from_node = poses_of(4);
  description.scene_uri = "scene.glb";
  description.clock.boot_id = "boot";
  Welcome welcome;
  welcome.epoch = 5;
  welcome.message = "hello";
  welcome.unmatched_names = {"a", "b"};
  welcome.conflicting_names = {"c/d"};
  return {encode(description), encode(frame_of(poses_of(4))), encode(welcome),   encode(Ack{5, 6}),
          encode(Ping{1, 2}),  encode(Pong{1, 2, 3}),         encode(Goodbye{5})};
}

TEST(PoseFrameEncoder, PiecesAreTheMessage) {
  PoseFrameEncoder encoder;
  const std::vector<Affine3x4> poses = poses_of(1000);
  uint64_t sequence = 0;
  for (const size_t count : {0u, 1u, 2u, 3u, 17u, 1000u, 2u, 0u}) {
    PoseFrameView frame = frame_of(std::span(poses).first(count), ++sequence);
    frame.node_count = 1000;
    frame.first_node = static_cast<uint32_t>(1000 - count);
    const MessagePieces pieces = encoder.encode(frame);
    EXPECT_EQ(join(pieces), encode(frame)) << count;
    EXPECT_EQ(pieces.body.data(), reinterpret_cast<const std::byte*>(poses.data())) << "poses were copied";
  }
}

TEST(PoseFrameEncoder, LayoutMatchesSpecification) {
  const std::vector<Affine3x4> poses = poses_of(2);
  PoseFrameView frame = frame_of(poses, 42);
  frame.node_count = 9;
  frame.first_node = 7;
  const Bytes bytes = encode(frame);
  ASSERT_EQ(bytes.size(), kPoseFrameHead + 2 * sizeof(Affine3x4));
  EXPECT_EQ(std::memcmp(bytes.data() + 4, "F3DV", 4), 0);
  EXPECT_EQ(read_at<uint8_t>(bytes, 23), 2);
  EXPECT_EQ(read_at<uint64_t>(bytes, 56), frame.header.epoch);
  EXPECT_EQ(read_at<uint64_t>(bytes, 64), 42u);
  EXPECT_EQ(read_at<int64_t>(bytes, 72), -7);
  EXPECT_EQ(read_at<uint64_t>(bytes, 80), frame.header.publish_time_ns);
  EXPECT_EQ(read_at<uint64_t>(bytes, 88), 3u);
  EXPECT_EQ(read_at<uint32_t>(bytes, 100), 7u);
  EXPECT_EQ(read_at<uint32_t>(bytes, 104), 9u);
  EXPECT_EQ(read_at<uint32_t>(bytes, 108), 1u);
  EXPECT_EQ(read_at<uint32_t>(bytes, 116), 2u);
  EXPECT_EQ(std::memcmp(bytes.data() + kPoseFrameHead, poses.data(), 96), 0);
}

TEST(PoseFrameEncoder, LaterFramesDoNotAllocate) {
  PoseFrameEncoder encoder;
  const std::vector<Affine3x4> poses = poses_of(1000);
  size_t bytes = encoder.encode(frame_of(poses)).size();
  const uint64_t before = test::allocations_of_this_thread();
  ASSERT_GT(before, 0u) << "the counter counts nothing";
  for (uint64_t i = 0; i < 1000; ++i) bytes += encoder.encode(frame_of(std::span(poses).first(i), i)).size();
  EXPECT_EQ(test::allocations_of_this_thread() - before, 0u);
  EXPECT_GT(bytes, 1000u * kPoseFrameHead);
}

TEST(Decoder, PoseFramesDoNotAllocate) {
  Decoder decoder;
  const Bytes bytes = encode(frame_of(poses_of(1000)));
  ASSERT_TRUE(decoder.decode(bytes).ok());
  const uint64_t before = test::allocations_of_this_thread();
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(decoder.decode(bytes).ok());
  EXPECT_EQ(test::allocations_of_this_thread() - before, 0u);
}

TEST(PosesPerPart, MessageIsFilled) {
  const std::vector<Affine3x4> poses = poses_of(100);
  for (const size_t limit : {168u, 200u, 508u, 1200u, 1472u}) {
    const uint32_t count = poses_per_part(limit);
    ASSERT_GT(count, 0u);
    EXPECT_LE(encode(frame_of(std::span(poses).first(count))).size(), limit);
    EXPECT_GT(encode(frame_of(std::span(poses).first(count + 1))).size(), limit);
  }
  EXPECT_EQ(poses_per_part(0), 0u);
  EXPECT_EQ(poses_per_part(167), 0u);
}

TEST(Decoder, KeepsPrivateCopyAtAnyAlignment) {
  const std::vector<Affine3x4> poses = poses_of(5);
  const Bytes bytes = encode(frame_of(poses));
  Decoder decoder;
  for (size_t shift = 0; shift < 16; ++shift) {
    Bytes moved(shift + bytes.size());
    std::copy(bytes.begin(), bytes.end(), moved.begin() + static_cast<std::ptrdiff_t>(shift));
    const auto message = decoder.decode(std::span(moved).subspan(shift));
    ASSERT_TRUE(message.ok()) << message.error().message;
    std::fill(moved.begin(), moved.end(), std::byte{0xff});  // a writer that changes the data after the check
    const auto& frame = std::get<PoseFrameView>(*message);
    EXPECT_TRUE(std::equal(frame.poses.begin(), frame.poses.end(), poses.begin(), poses.end()));
    EXPECT_EQ(reinterpret_cast<uintptr_t>(frame.poses.data()) % alignof(Affine3x4), 0u);
  }
}

TEST(Decoder, HoldsToItsLimits) {
  DecodeLimits limits;
  limits.max_nodes = 3;
  limits.max_name_bytes = 4;
  limits.max_abs_value = 10;
  StreamDescription description;
  description.epoch = 1;
  description.node_names = {"a", "b", "four"};
  Decoder decoder(limits);
  EXPECT_TRUE(decoder.decode(encode(description)).ok());
  description.node_names[2] = "five5";
  EXPECT_FALSE(decoder.decode(encode(description)).ok());
  description.node_names = {"a", "b", "c", "d"};
  EXPECT_FALSE(decoder.decode(encode(description)).ok());
  description.node_names = {};
  description.world_from_stream.m[3] = 10;
  EXPECT_TRUE(decoder.decode(encode(description)).ok());
  description.world_from_stream.m[3] = -10.5;
  EXPECT_FALSE(decoder.decode(encode(description)).ok());

  std::vector<Affine3x4> poses(4);
  EXPECT_TRUE(decoder.decode(encode(frame_of(std::span(poses).first(3)))).ok());
  EXPECT_FALSE(decoder.decode(encode(frame_of(poses))).ok());

  limits = {};
  limits.max_message_bytes = 100;
  Decoder small(limits);
  EXPECT_TRUE(small.decode(encode(Ack{1, 1})).ok());
  const auto message = small.decode(encode(frame_of(poses)));
  ASSERT_FALSE(message.ok());
  EXPECT_NE(message.error().message.find("at most 100"), std::string::npos) << message.error().message;
}

TEST(Decoder, CountsOutsideAreRefused) {
  const Bytes good = encode(frame_of(poses_of(3)));
  Decoder decoder;
  ASSERT_TRUE(decoder.decode(good).ok());
  for (const uint32_t count :
       {4u, 5u, 1000u, 0x0fffffffu, 0x55555556u, 0x7fffffffu, 0x80000000u, 0xffffffffu}) {
    Bytes bytes = good;
    std::memcpy(bytes.data() + kPoseFrameHead - 4, &count, 4);
    EXPECT_FALSE(decoder.decode(bytes).ok()) << count;
  }
}

// Checks a result: errors are printable, and accepted messages respect the limits.
void look_at(const Result<Message>& message, size_t input_bytes) {
  if (!message.ok()) {
    ASSERT_FALSE(message.error().message.empty());
    ASSERT_TRUE(check_text("error", message.error().message, 4096).ok());
  } else if (const auto* frame = std::get_if<PoseFrameView>(&*message)) {
    ASSERT_TRUE(check(*frame, {}).ok());
    ASSERT_LE(frame->poses.size_bytes(), input_bytes);
  } else if (const auto* description = std::get_if<StreamDescription>(&*message)) {
    ASSERT_TRUE(check(*description, {}).ok());
  } else if (const auto* welcome = std::get_if<Welcome>(&*message)) {
    ASSERT_TRUE(check(*welcome, {}).ok());
  }
}

TEST(Decoder, SurvivesRandomMutations) {
  std::mt19937 random(1);
  const std::vector<Bytes> originals = one_of_each();
  Decoder decoder;
  uint32_t accepted = 0, refused = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Bytes& original = originals[random() % originals.size()];
    Bytes bytes = original;
    for (uint32_t changes = 1 + random() % 4; changes > 0; --changes) {
      const size_t at = random() % bytes.size();
      switch (random() % 5) {
        case 0:
          bytes[at] = static_cast<std::byte>(random());
          break;
        case 1:
          bytes[at] ^= static_cast<std::byte>(1u << random() % 8);
          break;
        case 2:
          bytes[at] = random() % 2 ? std::byte{0xff} : std::byte{0x7f};
          break;
        case 3: {  // a whole word, like offsets and lengths
          const uint32_t word = static_cast<uint32_t>(random() % 3 ? random() % 512 : random());
          std::memcpy(bytes.data() + std::min(at & ~size_t{3}, bytes.size() - 4), &word, 4);
          break;
        }
        case 4:
          bytes.resize(std::max<size_t>(at, 1));
          break;
      }
      if (bytes.size() < 4) break;
    }
    const auto message = decoder.decode(bytes);
    look_at(message, bytes.size());
    if (HasFatalFailure()) FAIL() << "mutation " << i;
    ++(message.ok() ? accepted : refused);
  }
  // Both outcomes must be frequent, or the mutations test nothing.
  EXPECT_GT(accepted, 10'000u);
  EXPECT_GT(refused, 10'000u);
}

TEST(Decoder, SurvivesBytesOfNoMessage) {
  std::mt19937 random(2);
  Decoder decoder;
  for (int i = 0; i < 20'000; ++i) {
    Bytes bytes(random() % 256);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() % (i % 2 ? 256 : 32));
    if (bytes.size() >= 8) std::memcpy(bytes.data() + 4, "F3DV", 4);
    look_at(decoder.decode(bytes), bytes.size());
    if (HasFatalFailure()) FAIL() << i;
  }
}

TEST(Decoder, GoesOnAfterARefusal) {
  Decoder decoder;
  const std::vector<Bytes> messages = one_of_each();
  for (const Bytes& bytes : messages) {
    EXPECT_FALSE(decoder.decode(std::span(bytes).first(bytes.size() / 2)).ok());
    EXPECT_TRUE(decoder.decode(bytes).ok());
  }
}

TEST(Printable, NeverCutsCharacterNorPassesControl) {
  EXPECT_EQ(printable("plain"), "plain");
  EXPECT_EQ(printable("a\x1b[2Jb\n"), "a?[2Jb?");
  EXPECT_EQ(printable("\xff\xc3"), "??");
  EXPECT_EQ(printable("ääää", 5), "ää");
  EXPECT_TRUE(check_text("x", printable("🤖\xf0\x9f\xa4", 5), 5).ok());
}

}  // namespace
}  // namespace fire3dv::wire
