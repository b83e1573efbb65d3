// Lifetime test of GPU objects: counts and bytes before and after scene replacement, resize and destruction
// of the renderer. A failed allocation leaves the old scene.
#include <gtest/gtest.h>

#include "renderer/live_scene/gpu_bytes.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

scene::Scene small_scene(int textures) {
  SceneBuilder builder;
  for (int i = 0; i < textures; ++i) {
    scene::Material material = matte({1, 1, 1});
    material.base_color_texture.texture =
        builder.texture(8, 8, true, [](float u, float v) { return glm::vec4(u, v, 0.5f, 1); });
    builder.mesh_node("ball_" + std::to_string(i), builder.sphere(builder.material(material), 0.5f, 16),
                      at({static_cast<float>(i), 0, 0}));
  }
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({0, -1, -0.2f}));
  builder.camera_node("camera", {0, 1, 4}, {0, 0, 0});
  return builder.build();
}

std::string difference(const gpu::LiveObjects& before, const gpu::LiveObjects& after) {
  std::string text;
  for (size_t kind = 0; kind < gpu::kObjectKinds; ++kind) {
    if (before[kind] == after[kind]) continue;
    text += std::string(gpu::object_kind_name(static_cast<gpu::ObjectKind>(kind))) + " " +
            std::to_string(before[kind]) + " -> " + std::to_string(after[kind]) + "; ";
  }
  return text;
}

class Lifetime : public ValidationIsSilent {
 protected:
  // Returns the live objects after all retired ones are destroyed.
  static gpu::LiveObjects settled() {
    device().retire_all_now();
    return device().live_objects();
  }
  static uint64_t settled_bytes() {
    device().retire_all_now();
    return device().allocated_bytes();
  }
};

TEST_F(Lifetime, DestroyedRendererLeavesNothing) {
  const gpu::LiveObjects before = settled();
  const uint64_t bytes_before = device().allocated_bytes();
  {
    const scene::Scene scene = small_scene(3);
    RenderBench bench(scene, {64, 48});
    bench.draw_at_rest();
    EXPECT_NE(difference(before, device().live_objects()), "");
  }
  EXPECT_EQ(difference(before, settled()), "");
  EXPECT_EQ(device().allocated_bytes(), bytes_before);
}

TEST_F(Lifetime, ReloadAndResizeLeaveNothingBehind) {
  const scene::Scene first = small_scene(3);
  const scene::Scene second = small_scene(5);
  RenderBench bench(first, {64, 48});
  for (uint32_t frame = 0; frame < 2 * gpu::kFramesInFlight; ++frame)
    bench.draw_at_rest();  // allocates the memory of each frame in flight
  gpu::LiveObjects before{};
  uint64_t bytes_before = 0;
  for (uint32_t i = 0; i < 10; ++i) {
    if (i == 2) {  // targets of a few sizes are cached: by now all sizes of the loop
      before = settled();
      bytes_before = device().allocated_bytes();
    }
    bench.renderer().set_scene(second);
    bench.set_size({80 + i % 2, 40 + i % 2});
    RenderBench(second, {32, 32}).draw_at_rest();
    bench.renderer().set_scene(first);
    bench.set_size({64, 48});
    bench.draw_at_rest();
  }
  EXPECT_EQ(difference(before, settled()), "");
  EXPECT_EQ(device().allocated_bytes(), bytes_before);
}

// Fails each allocation of a new scene in turn; the old scene then gives the same bytes.
TEST_F(Lifetime, SceneWithoutMemoryLeavesOldOne) {
  const scene::Scene first = small_scene(2), second = small_scene(4);
  RenderBench bench(first, {64, 48});
  const sinks::FrameImage before = bench.draw_at_rest();
  const uint64_t bytes = settled_bytes();
  uint64_t failures = 0;
  for (;; ++failures) {
    ASSERT_LT(failures, 1000u);
    device().fail_allocation_after(failures);
    try {
      bench.renderer().set_scene(second);
      break;
    } catch (const gpu::VulkanFailure& failure) {
      EXPECT_TRUE(gpu::is_out_of_memory(failure));
    }
    EXPECT_EQ(bench.draw_at_rest().rgba8, before.rgba8) << "after the failure of allocation " << failures;
  }
  device().fail_allocation_after(UINT64_MAX - 1);
  EXPECT_GT(failures, 20u);
  bench.renderer().set_scene(first);
  EXPECT_EQ(bench.draw_at_rest().rgba8, before.rgba8);
  EXPECT_LE(settled_bytes(), bytes + (uint64_t{1} << 20)) << "nothing is left of what failed";
}

TEST_F(Lifetime, MemoryEstimateIsUpperBound) {
  SceneBuilder builder;
  scene::Material material = matte({1, 1, 1});
  material.base_color_texture.texture =
      builder.texture(512, 512, true, [](float u, float v) { return glm::vec4(u, v, 0.5f, 1); });
  builder.mesh_node("ball", builder.sphere(builder.material(material), 0.5f, 200), at({0, 0, 0}));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({0, -1, -0.2f}));  // equal shadow maps in both
  builder.camera_node("camera", {0, 1, 4}, {0, 0, 0});
  const scene::Scene large = builder.build();
  const scene::Derived derived = scene::derive(large, scene::Levels::none);
  const scene::Scene empty = small_scene(0);
  RenderBench bench(empty, {64, 48});
  bench.draw_at_rest();
  bench.renderer().set_scene(empty);  // allocates the shadow maps for this image size
  const uint64_t before = settled_bytes();
  bench.renderer().set_scene(large, derived);
  const uint64_t taken = settled_bytes() - before, estimate = app::estimate_gpu_bytes(large, derived);
  RecordProperty("taken_bytes", std::to_string(taken));
  RecordProperty("estimated_bytes", std::to_string(estimate));
  EXPECT_GE(estimate, taken - taken / 8);
  EXPECT_LE(estimate, 6 * taken);
  EXPECT_GT(device().available_bytes(), 0u);
}

TEST_F(Lifetime, TargetCacheIsBounded) {
  const scene::Scene scene = small_scene(1);
  RenderBench bench(scene, {64, 48});
  gpu::LiveObjects after_many{};
  for (uint32_t i = 0; i < 24; ++i) {
    bench.set_size({80 + i, 40 + i});
    if (i == 11) after_many = settled();
  }
  EXPECT_EQ(difference(after_many, settled()), "");
}

TEST_F(Lifetime, ObjectOutlivesFramesThatUseIt) {
  const gpu::LiveObjects before = settled();
  const auto buffers = static_cast<size_t>(gpu::ObjectKind::buffer);
  gpu::FrameRing frames(device());
  frames.begin();
  {
    gpu::Buffer buffer =
        gpu::create_buffer(device(), 1024, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
    EXPECT_EQ(device().live_objects()[buffers], before[buffers] + 1);
  }
  device().collect();  // the recording frame may still use it
  EXPECT_EQ(device().live_objects()[buffers], before[buffers] + 1);
  device().wait(frames.submit());
  device().collect();
  EXPECT_EQ(device().live_objects()[buffers], before[buffers]);
}

}  // namespace
}  // namespace fire3dv::test
