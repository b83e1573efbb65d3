// Test of the assembly of frames from parts that arrive out of order, and of its memory.
#include "protocol/stream/frame_assembler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <random>
#include <utility>
#include <vector>

namespace fire3dv::stream {
namespace {

using Assembly = FrameAssembler::Outcome;

Assembly add_part(FrameAssembler& assembler, uint64_t sequence, uint32_t node_count, uint32_t first,
                  uint32_t count) {
  std::vector<wire::Affine3x4> poses(count);
  for (wire::Affine3x4& pose : poses) pose.m[3] = static_cast<float>(sequence);
  wire::PoseFrameView part;
  part.header.epoch = 1;
  part.header.sequence = sequence;
  part.node_count = node_count;
  part.first_node = first;
  part.poses = poses;
  return assembler.add(part);
}

// 300 nodes in 15 datagrams, 60 Hz, 200 ms of delay and 100 ms of jitter: no datagram is lost.
TEST(FrameAssembler, FramesBecomeWholeUnderJitter) {
  constexpr uint32_t kParts = 15, kNodes = 300, kFrames = 360;
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> delay_ms(100, 300);
  std::vector<std::pair<double, std::pair<uint64_t, uint32_t>>> arrivals;
  for (uint64_t frame = 1; frame <= kFrames; ++frame)
    for (uint32_t part = 0; part < kParts; ++part)
      arrivals.push_back({static_cast<double>(frame) * 1000 / 60 + delay_ms(generator), {frame, part}});
  std::ranges::sort(arrivals);
  FrameAssembler assembler;
  uint64_t shown = 0, newest = 0;
  for (const auto& [at, what] : arrivals) {
    if (what.first <= newest) continue;  // precondition of add()
    if (add_part(assembler, what.first, kNodes, what.second * kNodes / kParts, kNodes / kParts) !=
        Assembly::whole)
      continue;
    ++shown;
    newest = assembler.header().sequence;
    for (const wire::Affine3x4& pose : assembler.poses()) ASSERT_EQ(pose.m[3], static_cast<float>(newest));
    assembler.close_up_to(newest);
  }
  EXPECT_GT(shown, kFrames * 3 / 4) << "the others are overtaken by newer whole frames";
}

// Memory of open frames stays bounded, and the newest ones stay open.
TEST(FrameAssembler, OldFramesAreDroppedBeyondTheMemory) {
  constexpr uint32_t kNodes = 100'000;  // 4.8 MB a frame
  FrameAssembler assembler;
  for (uint64_t frame = 1; frame <= 40; ++frame)
    EXPECT_EQ(add_part(assembler, frame, kNodes, 0, kNodes - 1), Assembly::open);
  EXPECT_LE(assembler.memory_bytes(), kMinOpenFrames * 5'000'000);
  EXPECT_GE(assembler.take_given_up(), 40 - kMinOpenFrames);
  EXPECT_EQ(add_part(assembler, 40, kNodes, kNodes - 1, 1), Assembly::whole);
  EXPECT_EQ(add_part(assembler, 39, kNodes, kNodes - 1, 1), Assembly::whole);
  EXPECT_NE(add_part(assembler, 2, kNodes, kNodes - 1, 1), Assembly::whole) << "long dropped";
}

// A peer whose budget holds two frames shows the newest ones.
TEST(FrameAssembler, OldFramesGiveTheirBudgetToNewerOnes) {
  constexpr uint32_t kNodes = 10'000;
  PeerLimits limits;
  limits.of(Resource::pose_bytes) = 3 * kNodes * sizeof(wire::Affine3x4);
  FrameAssembler assembler(BudgetPool::create(limits)->add_peer("peer"));
  for (uint64_t frame = 1; frame <= 20; ++frame)
    EXPECT_EQ(add_part(assembler, frame, kNodes, 0, kNodes - 1), Assembly::open);
  EXPECT_EQ(add_part(assembler, 20, kNodes, kNodes - 1, 1), Assembly::whole);
}

}  // namespace
}  // namespace fire3dv::stream
