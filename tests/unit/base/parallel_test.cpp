// Test of parallel loops: results equal those of one core, for any number of cores.
#include "base/parallel.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/digest.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "tests/unit/renderer/scene/clusters/mesh_scenes.h"

namespace fire3dv::scene {
namespace {

// Pins this thread and its children to one core.
class OnOneCore {
 public:
  OnOneCore() {
    EXPECT_EQ(sched_getaffinity(0, sizeof(before_), &before_), 0);
    cpu_set_t one;
    CPU_ZERO(&one);
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (!CPU_ISSET(cpu, &before_)) continue;
      CPU_SET(cpu, &one);
      break;
    }
    EXPECT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
  }
  ~OnOneCore() { sched_setaffinity(0, sizeof(before_), &before_); }

 private:
  cpu_set_t before_;
};

TEST(Parallel, EachTurnOnce) {
  for (const size_t count : {size_t{0}, size_t{1}, size_t{7}, size_t{1000}}) {
    std::vector<std::atomic<int>> turns(count);
    size_t reported = 0;
    parallel_for(
        count, [&](size_t i) { ++turns[i]; },
        [&](size_t done) {
          EXPECT_GT(done, 0u);
          EXPECT_LE(done, count);
          ++reported;
        });
    for (const std::atomic<int>& turn : turns) EXPECT_EQ(turn, 1);
    EXPECT_LE(reported, count);
  }
}

TEST(Parallel, ExceptionComesThroughAndEndsRest) {
  std::atomic<size_t> begun{0};
  std::atomic<bool> thrown{false};
  EXPECT_THROW(parallel_for(100'000,
                            [&](size_t i) {
                              ++begun;
                              if (i < 3) return;
                              if (i == 3) {
                                thrown = true;
                                throw std::runtime_error("no");
                              }
                              // The others are slow, so that they still run when the exception is thrown.
                              while (!thrown) std::this_thread::yield();
                              std::this_thread::sleep_for(std::chrono::microseconds(100));
                            }),
               std::runtime_error);
  EXPECT_LT(begun, 100'000u);
}

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(Parallel, ResultIsIndependentOfCores) {
  Scene scene;
  // Several meshes, some of them open.
  for (uint32_t i = 0; i < 9; ++i) {
    test::Triangles ball = test::ball_triangles(1.0f + static_cast<float>(i), 64 - 6 * i, 0.2f);
    if (i % 3 == 2) ball.indices.resize(ball.indices.size() - 3);
    test::add_primitive(scene, ball);
    test::add_mesh(scene);
  }
  const Derived many = derive(scene, Levels::all);
  const Derived one = [&] {
    const OnOneCore here;
    return derive(scene, Levels::all);
  }();
  EXPECT_TRUE(same_bytes(many.clusters.source_vertices, one.clusters.source_vertices));
  EXPECT_TRUE(same_bytes(many.clusters.clusters, one.clusters.clusters));
  EXPECT_TRUE(same_bytes(many.clusters.triangles, one.clusters.triangles));
  EXPECT_TRUE(same_bytes(many.clusters.ray_boxes, one.clusters.ray_boxes));
  EXPECT_TRUE(same_bytes(many.clusters.primitives, one.clusters.primitives));
  ASSERT_EQ(many.casters.size(), scene.meshes.size());
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    EXPECT_EQ(many.casters[m].shape, m % 3 == 2 ? CasterShape::open : CasterShape::closed) << m;
    EXPECT_EQ(one.casters[m].shape, many.casters[m].shape) << m;
  }
}

TEST(Digest, OneByteMakesAnother) {
  std::vector<std::byte> bytes(3'000'000, std::byte{7});
  const Digest before = digest_of(bytes);
  {
    const OnOneCore here;
    EXPECT_EQ(digest_of(bytes), before);
  }
  bytes[2'500'000] = std::byte{8};
  EXPECT_NE(digest_of(bytes), before);
  bytes[2'500'000] = std::byte{7};
  EXPECT_EQ(digest_of(bytes), before);
  bytes.push_back(std::byte{7});
  EXPECT_NE(digest_of(bytes), before);
  EXPECT_NE(digest_of({}), digest_of(std::vector<std::byte>(1)));
}

TEST(Checksum, PiecesOrNotAndEveryBit) {
  std::vector<std::byte> bytes(1000);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 31);
  const auto checksum_of = [](std::span<const std::byte> some) {
    Checksum checksum;
    checksum.add(some);
    return checksum.value();
  };
  const uint64_t whole = checksum_of(bytes);
  Checksum pieces;
  pieces.add(std::span(bytes).first(Checksum::kBlock * 5));
  pieces.add(std::span(bytes).subspan(Checksum::kBlock * 5));
  EXPECT_EQ(pieces.value(), whole);
  for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    EXPECT_NE(checksum_of(bytes), whole) << bit;
    bytes[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
  }
  EXPECT_NE(checksum_of(std::span(bytes).first(999)), whole);
}

}  // namespace
}  // namespace fire3dv::scene
