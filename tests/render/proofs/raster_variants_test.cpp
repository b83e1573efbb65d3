// Equivalence test of the cluster raster shaders: one thread per triangle, two triangles per thread, CPU
// lanes. All variants must give bit-identical samples, depths and texels, and forward the same large
// triangles. Culling must list the same clusters in one row of workgroups or several.
#include <algorithm>

#include "renderer/gpu/loader_commands.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/image_globals.h"
#include "renderer/passes/visibility/visibility_pass.h"
#include "shaders/shared/types.h"
#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

using gpu::Use;

constexpr VkExtent2D kVariantsExtent{96, 96};
constexpr uint32_t kRoom = 4096;  // capacity for large triangles, of each kind

// Outputs of a raster shader.
struct Drawn {
  std::vector<uint64_t> target;
  uint32_t huge = 0, prepared = 0, tiles = 0;
  bool operator==(const Drawn&) const = default;
};

class RasterVariants : public ValidationIsSilent {
 protected:
  RasterVariants() {
    SceneBuilder builder;
    const uint32_t grey = builder.material(matte({0.5, 0.5, 0.5}));
    scene::Material both_sides = matte({1, 1, 1});
    both_sides.double_sided = true;
    const uint32_t ball = builder.sphere(grey, 0.5f, 48);
    builder.mesh_node("ball", ball, at({-0.6f, 0, 0}));
    builder.mesh_node("mirrored", ball, glm::scale(at({0.6f, 0.1f, 0}), glm::vec3(-1, 0.8f, 1)));
    builder.mesh_node("far", ball, at({3, 2, -30}));  // triangles much smaller than a pixel
    builder.mesh_node("leaf", builder.box(builder.material(both_sides), {0.3f, 0.3f, 0.01f}),
                      at({0, -0.5f, 0.5f}));
    builder.mesh_node("floor", builder.box(grey, {40, 0.1f, 40}), at({0, -1, 0}));  // passes below the eye
    builder.camera_node("camera", {0, 0.3f, 3}, {0, 0, 0});
    scene_ = builder.build();
    bench_ = std::make_unique<RenderBench>(scene_, kVariantsExtent, settings_);
    bench_->draw_at_rest();
    bench_->renderer().gpu_scene().write_globals(globals_);
    bench_->renderer().gpu_scene().write_world_globals(globals_, 0);
    globals_.width = kVariantsExtent.width;
    globals_.height = kVariantsExtent.height;
    const state::PoseState poses(scene_);
    const passes::View view = first_camera_view(scene_, poses, kVariantsExtent);
    globals_.clip_from_world = view.clip_from_world;
    view_ = passes::raster_view(view, kVariantsExtent, passes::CameraLevels::finest);
    view_.depth_m = 0.1f;  // depth range of a spot light's map
    view_.texel_m = 0.01f;
  }

  uint32_t cluster_count() const { return bench_->renderer().gpu_scene().lod0_cluster_instance_count; }

  // Dispatches one shader with the given number of workgroups.
  void run(const std::string& shader, const gpu_types::RasterSet& set, VkExtent3D groups,
           gpu::Buffer& written) {
    const gpu::Buffer globals = uploaded(std::vector{passes::ImageGlobals{globals_}}),
                      sets = uploaded(std::vector{set});
    const gpu_types::RasterPush push{globals.address, sets.address, 0};
    const VkPipeline pipeline = pipelines_.of(shader);
    gpu::LoaderCommands loader(device());
    loader.recorder().pass(
        "drawn", {Use(written, gpu::access::compute_write)}, [&](VkCommandBuffer commands) {
          vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
          const VkDescriptorSet textures = bench_->renderer().gpu_scene().textures.set();
          vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), 0, 1,
                                  &textures, 0, nullptr);
          vkCmdPushConstants(commands, pipelines_.layout(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
          vkCmdDispatch(commands, groups.width, groups.height, groups.depth);
        });
    loader.recorder().transition({Use(written, gpu::access::host_read)});
    loader.finish();
  }

  // Draws all clusters, every second one single-sided. samples: 0 = two shadow maps of a light.
  Drawn drawn(const std::string& shader, uint32_t samples) {
    std::vector<uint32_t> list;
    for (uint32_t i = 0; i < cluster_count(); ++i) list.push_back(i | (i % 2 ? FIRE3DV_LISTED_ONE_SIDE : 0));
    gpu_types::ViewWork work{};
    work.solid = {cluster_count(), 1, 1, 0};
    const VkDeviceSize texels = VkDeviceSize{kVariantsExtent.width} * kVariantsExtent.height;
    const gpu::Buffer views = uploaded(std::vector{view_}), lists = uploaded(list),
                      works = uploaded(std::vector{work}),
                      large = written_by_shaders(sizeof(gpu_types::LargeWork)),
                      huge = written_by_shaders(kRoom * sizeof(gpu_types::HugeTriangle)),
                      prepared = written_by_shaders((kRoom + 65536) * sizeof(gpu_types::PreparedTriangle)),
                      tiles = written_by_shaders((kRoom + 65536) * sizeof(gpu_types::TileEntry));
    gpu::Buffer target = written_by_shaders(texels * 8 * std::max(samples, 1u));
    gpu_types::RasterSet set{};
    set.views = views.address;
    set.work = works.address;
    set.lists = lists.address;
    set.large = large.address;
    set.huge = huge.address;
    set.prepared = prepared.address;
    set.tiles = tiles.address;
    set.target = target.address;
    set.instance_count = cluster_count();
    set.huge_capacity = kRoom;
    set.prepared_capacity = set.tile_capacity =
        kRoom + 65536;  // the shader switches to `huge` when less than 65536 remain
    run(shader, set, {cluster_count(), 1, 1}, target);
    Drawn result;
    result.target.resize(target.size_bytes / 8);
    std::memcpy(result.target.data(), target.mapped, target.size_bytes);
    gpu_types::LargeWork counts;
    std::memcpy(&counts, large.mapped, sizeof(counts));
    result.huge = counts.expand.count;
    result.prepared = counts.prepared_count;
    result.tiles = counts.tiles.count;
    return result;
  }

  void expect_same(const std::string& wide, const std::string& narrow, const std::string& lanes,
                   uint32_t samples) {
    SCOPED_TRACE(wide);
    const Drawn first = drawn(wide, samples);
    const auto covered =
        std::count_if(first.target.begin(), first.target.end(), [](uint64_t t) { return t != 0; });
    EXPECT_GT(covered, static_cast<ptrdiff_t>(first.target.size() / 20)) << "little was drawn";
    EXPECT_GT(first.huge, 0u) << "nothing passes below the eye";
    EXPECT_TRUE(drawn(narrow, samples) == first) << narrow;
    if (gpu::uses_cpu_variants(device())) {
      EXPECT_TRUE(drawn(lanes, samples) == first) << lanes;
    }
  }

  // Culls two equal views with empty lists and a target that needs clearing; returns the list of the second
  // view.
  std::vector<uint32_t> listed(bool one_row) {
    const gpu_types::ViewWork none{{0, 1, 1, 0}, {0, 1, 1, 0}};
    const gpu::Buffer views = uploaded(std::vector{view_, view_}), works = uploaded(std::vector{none, none});
    gpu::Buffer lists = written_by_shaders(2 * cluster_count() * sizeof(uint32_t));
    const gpu::Buffer target = uploaded(std::vector<uint32_t>(4 * 5000, 7));
    gpu_types::RasterSet set{};
    set.views = views.address;
    set.work = works.address;
    set.lists = lists.address;
    set.target = target.address;
    set.instance_count = cluster_count();
    set.cull = 1;
    set.one_row = one_row ? 1 : 0;
    set.cull_groups = (cluster_count() + 63) / 64;
    set.clear_quads = 4999;
    constexpr uint32_t kQuadsOfRow = 2 * 64 * FIRE3DV_CLEAR_QUADS;
    run("cull_4.comp", set, {set.cull_groups + (set.clear_quads + kQuadsOfRow - 1) / kQuadsOfRow, 1, 2},
        lists);
    gpu_types::ClusterList seen;
    std::memcpy(&seen, works.mapped + sizeof(none), sizeof(seen));
    EXPECT_EQ(seen.groups_y, 1u);
    EXPECT_EQ(seen.groups_z, 1u);
    EXPECT_EQ(seen.count, one_row ? 0 : seen.groups_x);
    std::vector<uint32_t> list(seen.groups_x), left(4 * 5000);
    std::memcpy(list.data(), lists.mapped + cluster_count() * sizeof(uint32_t),
                list.size() * sizeof(uint32_t));
    std::sort(list.begin(), list.end());
    std::memcpy(left.data(), target.mapped, left.size() * sizeof(uint32_t));
    EXPECT_TRUE(std::all_of(left.begin(), left.end() - 4, [](uint32_t word) { return word == 0; }));
    EXPECT_TRUE(std::all_of(left.end() - 4, left.end(), [](uint32_t word) { return word == 7; }))
        << "more was emptied than asked for";
    return list;
  }

 private:
  settings::DrawSettings settings_ = plain_settings(4);
  scene::Scene scene_;
  std::unique_ptr<RenderBench> bench_;
  gpu_types::Globals globals_{};
  gpu_types::RasterView view_{};
  ShaderPipelines pipelines_{settings_.max_textures};
};

TEST_F(RasterVariants, ImageVariantsAreIdentical) {
  expect_same("raster_4.comp", "raster_narrow_4.comp", "raster_4_cpu.comp", 4);
  expect_same("raster_1.comp", "raster_narrow_1.comp", "raster_1_cpu.comp", 1);
}

TEST_F(RasterVariants, LightMapVariantsAreIdentical) {
  expect_same("raster_light.comp", "raster_narrow_light.comp", "raster_light_cpu.comp", 0);
  expect_same("raster_center.comp", "raster_narrow_center.comp", "raster_center_cpu.comp", 0);
}

TEST_F(RasterVariants, ClusterRowsAreEquivalent) {
  const std::vector<uint32_t> one_row = listed(true);
  EXPECT_EQ(one_row, listed(false));
  EXPECT_GT(one_row.size(), 10u);
  EXPECT_LT(one_row.size(), cluster_count()) << "nothing was culled";
}

}  // namespace
}  // namespace fire3dv::test
