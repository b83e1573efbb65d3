// Equivalence test of the tile shaders on random large triangles: visibility/tiles_cpu.comp (one tile at a
// time on a CPU) and visibility/tiles.comp (64-bit atomics) give bit-identical samples and depths.
#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <vector>

#include "renderer/gpu/loader_commands.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/image_globals.h"
#include "shaders/shared/types.h"
#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

using glm::ivec2;
using gpu::Use;

constexpr VkExtent2D kExtent{70, 50};  // the image border cuts tiles
constexpr uint32_t kTilesAcross = 3, kTilesDown = 2, kTiles = kTilesAcross * kTilesDown;
constexpr uint32_t kIds = 128;  // of one cluster

int64_t area_of(const gpu_types::PreparedTriangle& t) {
  const ivec2 ab = t.b - t.a, ac = t.c - t.a;
  return int64_t{ab.x} * ac.y - int64_t{ab.y} * ac.x;
}

// Vertices within `reach` pixels of the image centre, some on sample positions, some on a common row or
// column.
std::vector<gpu_types::PreparedTriangle> triangles_within(int reach, uint32_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> place(-reach * 256, reach * 256), kind(0, 7), near(-90, 90);
  std::uniform_real_distribution<float> depth(0, 1);
  std::vector<gpu_types::PreparedTriangle> triangles;
  while (triangles.size() < count) {
    gpu_types::PreparedTriangle t{};
    const std::array<ivec2*, 3> corners{&t.a, &t.b, &t.c};
    for (ivec2* corner : corners) {
      *corner = ivec2(place(random), place(random)) + ivec2(35, 25) * 256;
      if (kind(random) == 0) *corner = ivec2(near(random), near(random)) * 128;
    }
    if (kind(random) == 0) t.b.y = t.a.y;
    if (kind(random) == 0) t.c.x = t.a.x;
    t.za = depth(random), t.zb = depth(random), t.zc = depth(random);
    if (kind(random) == 0) t.za = t.zb = t.zc = 0.5f;  // bit-identical depth to others
    if (kind(random) == 0) t.zb = -0.25f;              // beyond the far plane
    if (area_of(t) < 0) {
      std::swap(t.b, t.c);
      std::swap(t.zb, t.zc);
    }
    t.id = kIds + static_cast<uint32_t>(triangles.size()) % kIds;
    if (area_of(t) > 0) triangles.push_back(t);
  }
  return triangles;
}

class Tiles : public ValidationIsSilent {
 protected:
  Tiles() {
    SceneBuilder builder;
    builder.mesh_node("box", builder.box(builder.material(matte({1, 1, 1})), glm::vec3(1)), glm::mat4(1));
    builder.camera_node("camera", {0, 0, 3}, {0, 0, 0});
    scene_ = builder.build();
    bench_ = std::make_unique<RenderBench>(scene_, VkExtent2D{8, 8}, settings_);
  }

  // Draws a visibility buffer. Every tile gets every triangle, in a different order.
  std::vector<uint64_t> drawn(const std::vector<gpu_types::PreparedTriangle>& triangles, uint32_t samples,
                              bool tile_by_tile) {
    std::vector<gpu_types::TileEntry> entries;
    std::vector<uint32_t> lists(kTiles), next;
    for (uint32_t i = 0; i < triangles.size(); ++i) {
      for (uint32_t tile = 0; tile < kTiles; ++tile) {
        next.push_back(lists[tile]);
        entries.push_back({i, tile % kTilesAcross | (tile / kTilesAcross) << 16});
        lists[tile] = static_cast<uint32_t>(entries.size());
      }
    }
    gpu_types::LargeWork work{};
    work.tiles.count = static_cast<uint32_t>(entries.size());
    gpu_types::RasterView view{};
    view.width = kExtent.width;
    view.height = kExtent.height;
    gpu_types::PartRecord part{};  // no alpha mask
    const gpu::Buffer large = uploaded(std::vector{work}), views = uploaded(std::vector{view}),
                      prepared = uploaded(triangles), tiles = uploaded(entries), tile_lists = uploaded(lists),
                      tile_next = uploaded(next), parts = uploaded(std::vector{part}),
                      instances = uploaded(std::vector{gpu_types::ClusterInstance{}});
    gpu_types::Globals globals{};
    globals.parts = parts.address;
    globals.cluster_instances = instances.address;
    globals.width = kExtent.width;
    globals.height = kExtent.height;
    const VkDeviceSize bytes = VkDeviceSize{8} * samples * kExtent.width * kExtent.height;
    gpu::Buffer target = written_by_shaders(bytes);
    gpu_types::RasterSet set{};
    set.views = views.address;
    set.large = large.address;
    set.prepared = prepared.address;
    set.tiles = tiles.address;
    set.tile_lists = tile_lists.address;
    set.tile_next = tile_next.address;
    set.target = target.address;
    set.tile_capacity = work.tiles.count;
    const gpu::Buffer all_globals = uploaded(std::vector{passes::ImageGlobals{globals}}),
                      all_sets = uploaded(std::vector{set});
    const gpu_types::RasterPush push{all_globals.address, all_sets.address, 0};

    const VkPipeline pipeline =
        pipelines_.of("tiles_" + std::to_string(samples) + (tile_by_tile ? "_cpu.comp" : ".comp"));
    gpu::LoaderCommands loader(device());
    loader.recorder().pass("tiles", {Use(target, gpu::access::compute_write)}, [&](VkCommandBuffer commands) {
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      const VkDescriptorSet textures = bench_->renderer().gpu_scene().textures.set();
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), 0, 1, &textures,
                              0, nullptr);
      vkCmdPushConstants(commands, pipelines_.layout(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      if (tile_by_tile) {
        vkCmdDispatch(commands, kTilesAcross, kTilesDown, 1);
      } else {
        vkCmdDispatch(commands, work.tiles.count, 1, 1);
      }
    });
    loader.recorder().transition({Use(target, gpu::access::host_read)});
    loader.finish();
    std::vector<uint64_t> seen(bytes / 8);
    std::memcpy(seen.data(), target.mapped, bytes);
    return seen;
  }

  void expect_same(const std::vector<gpu_types::PreparedTriangle>& triangles) {
    for (uint32_t samples : {1u, 4u}) {
      const std::vector<uint64_t> lanes = drawn(triangles, samples, true),
                                  plain = drawn(triangles, samples, false);
      size_t differ = 0, covered = 0;
      for (size_t i = 0; i < plain.size(); ++i) {
        covered += plain[i] != 0;
        if (lanes[i] != plain[i] && differ++ == 0) {
          ADD_FAILURE() << samples << " samples, sample " << i << ": " << std::hex << lanes[i] << " is not "
                        << plain[i];
        }
      }
      EXPECT_EQ(differ, 0u) << samples << " samples";
      EXPECT_GT(covered, plain.size() / 50) << "little was drawn";
    }
  }

 private:
  settings::DrawSettings settings_ = plain_settings(1);
  scene::Scene scene_;
  std::unique_ptr<RenderBench> bench_;
  ShaderPipelines pipelines_{settings_.max_textures};
};

// Tens of overlapping triangles, so that most are hidden somewhere.
TEST_F(Tiles, SingleTilesAreIdentical) {
  ASSERT_TRUE(gpu::uses_cpu_variants(device())) << "these tests are for lavapipe";
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    expect_same(triangles_within(40, 60, seed));
    expect_same(triangles_within(300, 60, seed));
    expect_same(triangles_within(4000, 40, seed));
  }
}

// A floor below the eye: areas above 2^48, and edge functions beyond 54 bits.
TEST_F(Tiles, OversizedTilesAreIdentical) {
  ASSERT_TRUE(gpu::uses_cpu_variants(device())) << "these tests are for lavapipe";
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    for (int reach : {70'000, 250'000, 520'000}) {
      const std::vector<gpu_types::PreparedTriangle> triangles = triangles_within(reach, 40, seed);
      int64_t largest = 0;
      for (const gpu_types::PreparedTriangle& t : triangles) largest = std::max(largest, area_of(t));
      EXPECT_GE(largest, int64_t{1} << 48);
      expect_same(triangles);
    }
  }
}

// A single triangle shows all its depths instead of the nearest of many.
TEST_F(Tiles, EachAloneIsSameToBit) {
  ASSERT_TRUE(gpu::uses_cpu_variants(device())) << "these tests are for lavapipe";
  for (int reach : {60, 3000, 100'000, 520'000}) {
    SCOPED_TRACE(reach);
    uint32_t shown = 0;
    for (const gpu_types::PreparedTriangle& t : triangles_within(reach, 40, 9)) {
      const auto [low, high] = std::minmax({t.za, t.zb, t.zc});
      if (low < 0 || high == low) continue;
      const std::vector<uint64_t> lanes = drawn({t}, 4, true);
      EXPECT_EQ(lanes, drawn({t}, 4, false));
      shown += lanes[(25 * kExtent.width + 35) * 4] != 0;
    }
    EXPECT_GT(shown, 2u);
  }
}

}  // namespace
}  // namespace fire3dv::test
