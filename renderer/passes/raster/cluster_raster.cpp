#include "renderer/passes/raster/cluster_raster.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <string>

#include "renderer/passes/resources/shader_variant.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr uint32_t kPreparedCapacity = 1u << 18;
constexpr uint32_t kTileCapacity = 1u << 20;
constexpr uint32_t kTileSide = 1u << FIRE3DV_TILE_SHIFT;
// Cluster counts above which groups of 32 threads are faster (measured on an H200): they fill the device, and
// hardly any triangle exceeds a few pixels.
constexpr uint32_t kManyInMaps = 1u << 14, kManyInImages = 1u << 17;
constexpr uint32_t kHugeAtFirst = 1u << 22;  // 32 MiB, for very large scenes only
constexpr gpu::Access kArgumentsAndCompute{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
    VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, true};

// Break-even: occlusion culling costs about as much as drawing this many clusters.
constexpr uint32_t kMinClustersForOcclusion = 1u << 14;
constexpr float kMaxVisibleShare = 0.85f;  // maximum share of visible clusters for which occlusion culling
                                           // pays
constexpr uint32_t kTrialPeriod = 512,
                   kTrialFrames = 6;  // frames; each trial lasts until its counts are back

// Pass names by round.
struct RoundNames {
  const char *cull, *raster, *expand, *tiles;
};
constexpr RoundNames kRoundNames[2] = {{"cull", "raster", "expand", "tiles"},
                                       {"late cull", "late raster", "late expand", "late tiles"}};

// Size of the HiZ pyramid, all levels; see shaders/visibility/hiz.glsl.
uint32_t hiz_texel_count(VkExtent2D extent) {
  uint32_t count = 0;
  for (uint32_t shift = 3; shift < 7; ++shift) {
    const uint32_t more = (1u << shift) - 1;
    count += ((extent.width + more) >> shift) * ((extent.height + more) >> shift);
  }
  return count;
}

// Counters read back from a frame, per round; work has the list lengths of the first view.
struct Counts {
  gpu_types::LargeWork large[2];
  gpu_types::ViewWork work[2];
};

uint32_t clusters_in(const gpu_types::ViewWork& work) {
  return std::max(work.solid.groups_x, work.solid.count) + std::max(work.masked.groups_x, work.masked.count);
}

// Layout of ClusterRaster::work_: LargeWork of both rounds, then the views' ViewWork of the first and second
// round. Behind those of a round is one for common dispatches of all views.
VkDeviceSize large_work_at(uint32_t round) {
  return round * sizeof(gpu_types::LargeWork);
}
VkDeviceSize view_work_at(uint32_t round, uint32_t view_count) {
  return large_work_at(2) + VkDeviceSize{round} * (view_count + 1) * sizeof(gpu_types::ViewWork);
}

// Records one pass for all sets.
template <typename AddUses, typename CommandsOf>
void stage(gpu::Recorder& recorder, const char* name, std::span<ClusterRaster* const> sets,
           AddUses&& add_uses, CommandsOf&& commands_of) {
  std::vector<Use> uses;
  for (ClusterRaster* set : sets) add_uses(*set, uses);
  recorder.pass(name, uses, [&](VkCommandBuffer commands) {
    for (ClusterRaster* set : sets) commands_of(*set, commands);
  });
}

std::string suffix_of(RasterKind kind) {
  switch (kind) {
    case RasterKind::lights:
      return "_light.comp";
    case RasterKind::lights_center_only:
      return "_center.comp";
    case RasterKind::camera_4_samples:
      return "_4.comp";
    case RasterKind::camera_counts:
      return "_count.comp";
    default:
      return "_1.comp";
  }
}

}  // namespace

VkExtent2D tiles_of(VkExtent2D extent) {
  return {(extent.width + kTileSide - 1) / kTileSide, (extent.height + kTileSide - 1) / kTileSide};
}

ClusterRaster::ClusterRaster(gpu::Device& device, VkPipelineLayout layout, RasterKind kind)
    : device_(device),
      layout_(layout),
      kind_(kind),
      tile_by_tile_(kind != RasterKind::camera_counts && gpu::uses_cpu_variants(device)) {
  const std::string suffix = suffix_of(kind);
  const bool counting = kind == RasterKind::camera_counts;
  make_cull(false, gpu::Compile::immediately);
  make_raster(false, false, gpu::Compile::immediately);
  make_large(false, false, gpu::Compile::immediately);
  if (!is_of_lights(kind) && !counting)
    pipelines_.hiz = gpu::create_compute_pipeline(device, layout, "hiz" + suffix);
  for (gpu::Buffer& counts : counts_) {
    counts = gpu::create_buffer(device, sizeof(Counts), 0, gpu::Memory::readback);
    std::memset(counts.mapped, 0, sizeof(Counts));
  }
}

void ClusterRaster::make_cull(bool common, gpu::Compile when) {
  if (pipelines_.cull[common]) return;
  ShaderVariant variant;
  variant.several_worlds = common;
  pipelines_.cull[common] =
      gpu::create_compute_pipeline(device_, layout_,
                                   "cull" + (is_of_lights(kind_)                  ? "_light.comp"
                                             : kind_ == RasterKind::camera_counts ? "_1.comp"
                                                                                  : suffix_of(kind_)),
                                   when, variant.constants());
}

void ClusterRaster::make_raster(bool masks, bool common, gpu::Compile when) {
  ShaderVariant variant;
  variant.several_worlds = common;
  const auto make = [&](gpu::Pipeline& pipeline, const char* shader) {
    if (!pipeline)
      pipeline = gpu::create_compute_pipeline(device_, layout_, shader + suffix_of(kind_), when,
                                              variant.constants());
  };
  if (masks) return make(pipelines_.raster_mask[common], "raster_mask");
  make(pipelines_.raster[common], "raster");
  if (!tile_by_tile_ && kind_ != RasterKind::camera_counts)
    make(pipelines_.raster_narrow[common], "raster_narrow");
}

void ClusterRaster::make_large(bool masks, bool common, gpu::Compile when) {
  LargePipelines& large = pipelines_.large[masks][common];
  if (large.tiles) return;
  ShaderVariant variant;
  variant.masks = masks;
  variant.several_worlds = common;
  const auto make = [&](const char* shader) {
    return gpu::create_compute_pipeline(device_, layout_, shader + suffix_of(kind_), when,
                                        variant.constants());
  };
  large = {make("expand"), make("tiles")};
}

void ClusterRaster::expect_masks() {
  make_large(true, false, gpu::Compile::next);
  make_raster(true, false, gpu::Compile::next);
}

void ClusterRaster::expect_common(bool masks) {
  make_large(masks, true, gpu::Compile::next);
  if (masks) make_raster(true, true, gpu::Compile::next);
  make_raster(false, true, gpu::Compile::next);
  make_cull(true, gpu::Compile::next);
}

// Measures both modes periodically and selects the faster one. The image is the same.
bool ClusterRaster::culls_occluded(const Job& job) const {
  if (!pipelines_.hiz || job.view_count > 1) return false;
  if (job.cull != settings::Cull::automatic) return job.cull == settings::Cull::hidden;
  if (job.scene->lod0_cluster_instance_count < kMinClustersForOcclusion) return false;
  const uint64_t step = frame_ % kTrialPeriod;
  if (step < kTrialFrames) return true;
  if (step < 2 * kTrialFrames) return false;
  return clusters_not_occluded_ < kMaxVisibleShare * static_cast<float>(clusters_in_view_);
}

void ClusterRaster::read_counts() {
  // The slot's earlier frame is complete.
  Counts counts;
  std::memcpy(&counts, counts_[frame_ % gpu::kFramesInFlight].mapped, sizeof(counts));
  const uint32_t huge_count = std::max(counts.large[0].expand.count, counts.large[1].expand.count);
  while (huge_count > huge_capacity_ && huge_capacity_ < (1u << 27)) huge_capacity_ *= 2;
  const uint32_t rounds = rounds_counted_[frame_ % gpu::kFramesInFlight];
  rounds_counted_[frame_ % gpu::kFramesInFlight] = 0;
  drawn_.late_clusters = rounds == 2 ? clusters_in(counts.work[1]) : 0;
  drawn_.clusters = clusters_in(counts.work[0]) + drawn_.late_clusters;
  if (rounds == 1) clusters_in_view_ = drawn_.clusters;
  if (rounds == 2) clusters_not_occluded_ = drawn_.clusters;
}

// One list head per tile of the image, or of all maps in sequence.
VkDeviceSize ClusterRaster::tile_list_bytes(const Job& job) const {
  const VkExtent2D tiles = tiles_of(job.extent);
  const VkDeviceSize texels = job.target_bytes / sizeof(uint32_t);
  const VkDeviceSize count = is_of_lights(kind_) ? texels / (kTileSide * kTileSide)
                                                 : VkDeviceSize{tiles.width} * tiles.height * job.view_count;
  return count * sizeof(uint32_t);
}

void ClusterRaster::allocate(const Job& job) {
  if (job.scene->has_masked) expect_masks();
  const VkDeviceSize instances = job.instance_count(), entries = job.view_count * instances;
  // Room for every triangle of all but the largest scenes, so that the first image is complete.
  while (huge_capacity_ < kHugeAtFirst && huge_capacity_ < entries * scene::kClusterTriangles)
    huge_capacity_ *= 2;
  gpu::grow_storage_buffer(device_, lists_, entries * sizeof(uint32_t));
  gpu::grow_storage_buffer(device_, work_, view_work_at(2, job.view_count),
                           VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  gpu::grow_storage_buffer(device_, huge_, VkDeviceSize{huge_capacity_} * sizeof(gpu_types::HugeTriangle));
  gpu::grow_storage_buffer(device_, prepared_,
                           VkDeviceSize{kPreparedCapacity} * sizeof(gpu_types::PreparedTriangle));
  gpu::grow_storage_buffer(device_, tile_entries_,
                           VkDeviceSize{kTileCapacity} * sizeof(gpu_types::TileEntry));
  if (tile_by_tile_) {
    gpu::grow_storage_buffer(device_, tile_lists_, 2 * tile_list_bytes(job));
    gpu::grow_storage_buffer(device_, tile_next_, VkDeviceSize{kTileCapacity} * sizeof(uint32_t));
  }
  if (culls_occluded(job)) {
    was_visible_is_new_ |= gpu::grow_storage_buffer(device_, was_visible_, instances * sizeof(uint32_t));
    gpu::grow_storage_buffer(device_, hiz_, hiz_texel_count(job.extent) * sizeof(float));
  }
}

void ClusterRaster::begin(gpu::StagingRing& staging, const Job& job) {
  job_ = job;
  round_count_ = culls_occluded(job) ? 2 : 1;
  read_counts();
  allocate(job);
  if (job.is_common()) expect_common(job.scene->has_masked);
  gpu_types::RasterSet set{};
  set.views = job.views;
  set.lists = lists_.address;
  set.huge = huge_.address;
  set.prepared = prepared_.address;
  set.tiles = tile_entries_.address;
  set.tile_next = tile_next_.address;
  set.target = job.target->buffer.address;
  set.generation = job.target->generation();
  set.was_visible = was_visible_.address;
  set.hiz = hiz_.address;
  if (job.is_common())
    set.view_globals = staging.write(std::span<const VkDeviceAddress>(job.globals_of_views)).address;
  set.instance_count = job.instance_count();
  set.huge_capacity = huge_capacity_;
  set.prepared_capacity = kPreparedCapacity;
  set.tile_capacity = kTileCapacity;
  set.cull = job.cull == settings::Cull::off ? 0 : 1;
  set.read_before_write = device_.report().type == gpu::DeviceType::software ? 1 : 0;
  set.one_row = device_.limits().maxComputeWorkGroupCount[0] >= job.instance_count() ? 1 : 0;
  set.cull_groups = cull_groups();
  for (uint32_t round = 0; round < round_count_; ++round) {
    set.work = work_.address + view_work_at(round, job.view_count);
    set.large = work_.address + large_work_at(round);
    if (tile_by_tile_) set.tile_lists = tile_lists_.address + round * tile_list_bytes(job);
    set.clear_quads = static_cast<uint32_t>(clear_quads(round));
    set.round = round_count_ == 1 ? FIRE3DV_ROUND_ONLY
                : round == 0      ? FIRE3DV_ROUND_EARLY
                                  : FIRE3DV_ROUND_LATE;
    round_sets_[round] = staging.write(std::span<const gpu_types::RasterSet>(&set, 1)).address;
  }
}

void ClusterRaster::add_uses(std::vector<Use>& uses) {
  job_.scene->add_reads(uses, access::compute_read);
  if (job_.views_written) uses.emplace_back(*job_.views_written, access::compute_read);
  uses.emplace_back(work_, kArgumentsAndCompute);
  uses.emplace_back(lists_, access::compute_write);
  uses.emplace_back(huge_, access::compute_write);
  uses.emplace_back(prepared_, access::compute_write);
  uses.emplace_back(tile_entries_, access::compute_write);
  if (!tile_by_tile_) return;
  uses.emplace_back(tile_lists_, access::compute_write);
  uses.emplace_back(tile_next_, access::compute_write);
}

void ClusterRaster::clear(VkCommandBuffer commands) {
  vkCmdFillBuffer(commands, work_.get(), 0, view_work_at(0, job_.view_count), 0);
  constexpr gpu_types::ClusterList kEmpty{0, 1, 1, 0};
  constexpr VkDeviceSize kMaxAtOnce = 65536 / sizeof(gpu_types::ViewWork);  // limit of vkCmdUpdateBuffer, in
                                                                            // bytes
  std::vector<gpu_types::ViewWork> empty(2 * (VkDeviceSize{job_.view_count} + 1), {kEmpty, kEmpty});
  for (const size_t common : {empty.size() / 2 - 1, empty.size() - 1})
    empty[common].solid.groups_z = empty[common].masked.groups_z = job_.view_count;
  for (VkDeviceSize i = 0; i < empty.size(); i += kMaxAtOnce) {
    const VkDeviceSize count = std::min(kMaxAtOnce, empty.size() - i), bytes = sizeof(gpu_types::ViewWork);
    vkCmdUpdateBuffer(commands, work_.get(), view_work_at(0, job_.view_count) + i * bytes, count * bytes,
                      &empty[i]);
  }
  const VkDeviceSize cleared_later = clear_quads(0) * 16;
  if (job_.target->needs_clear() && cleared_later < job_.target_bytes)
    vkCmdFillBuffer(commands, job_.target->buffer.get(), cleared_later, job_.target_bytes - cleared_later, 0);
  if (tile_by_tile_) vkCmdFillBuffer(commands, tile_lists_.get(), 0, VK_WHOLE_SIZE, 0);
  if (round_count_ == 2 && was_visible_is_new_) {
    vkCmdFillBuffer(commands, was_visible_.get(), 0, VK_WHOLE_SIZE, 0);
    was_visible_is_new_ = false;
  }
}

void ClusterRaster::bind(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t round,
                         uint32_t view) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
  const VkDescriptorSet set = job_.scene->textures.set();
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
  const VkDeviceAddress globals = job_.is_common() ? job_.globals_of_views[view] : job_.globals;
  const gpu_types::RasterPush push{globals, round_sets_[round], view};
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
}

uint32_t ClusterRaster::cull_groups() const {
  return (job_.instance_count() + 63) / 64;
}

// The culling dispatch clears the camera's target. Shadow maps, and all targets on a CPU, are cleared by the
// driver's fill; see clear_of().
VkDeviceSize ClusterRaster::clear_quads(uint32_t round) const {
  const bool here = job_.target->needs_clear() && !tile_by_tile_ && !is_of_lights(kind_);
  return round == 0 && here ? job_.target_bytes / 16 : 0;
}

void ClusterRaster::cull(VkCommandBuffer commands, uint32_t round) const {
  bind(commands, pipelines_.cull[job_.is_common()], round, 0);
  // Each view has its culling groups and a share of the groups that clear the common target.
  const VkDeviceSize quads_of_row = VkDeviceSize{64} * FIRE3DV_CLEAR_QUADS * job_.view_count;
  const uint32_t groups =
      cull_groups() + static_cast<uint32_t>((clear_quads(round) + quads_of_row - 1) / quads_of_row);
  if (groups) vkCmdDispatch(commands, std::min(groups, 65535u), (groups + 65534) / 65535, job_.view_count);
}

bool ClusterRaster::is_narrow() const {
  if (!pipelines_.raster_narrow[0]) return false;
  const uint64_t clusters = uint64_t{job_.instance_count()} * (job_.is_common() ? job_.view_count : 1);
  return clusters >= (is_of_lights(kind_) ? kManyInMaps : kManyInImages);
}

void ClusterRaster::raster(VkCommandBuffer commands, uint32_t round) const {
  const bool common = job_.is_common();
  const gpu::Pipeline& solid = is_narrow() ? pipelines_.raster_narrow[common] : pipelines_.raster[common];
  // The common dispatch of all views is behind theirs.
  for (uint32_t view = common ? job_.view_count : 0; view < job_.view_count + (common ? 1 : 0); ++view) {
    const VkDeviceSize work = view_work_at(round, job_.view_count) + view * sizeof(gpu_types::ViewWork);
    bind(commands, solid, round, common ? 0 : view);
    vkCmdDispatchIndirect(commands, work_.get(), work + offsetof(gpu_types::ViewWork, solid));
    if (!job_.scene->has_masked) continue;
    bind(commands, pipelines_.raster_mask[common], round, common ? 0 : view);
    vkCmdDispatchIndirect(commands, work_.get(), work + offsetof(gpu_types::ViewWork, masked));
  }
}

void ClusterRaster::large_stage(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t round,
                                VkDeviceSize arguments) const {
  bind(commands, pipeline, round, 0);
  vkCmdDispatchIndirect(commands, work_.get(), large_work_at(round) + arguments);
}

void ClusterRaster::draw_tiles(VkCommandBuffer commands, uint32_t round) const {
  if (!tile_by_tile_)
    return large_stage(commands, large().tiles, round, offsetof(gpu_types::LargeWork, tiles));
  bind(commands, large().tiles, round, 0);
  const VkExtent2D tiles = tiles_of(job_.extent);
  vkCmdDispatch(commands, tiles.width, tiles.height, job_.view_count);
}

void ClusterRaster::build_hiz(VkCommandBuffer commands) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.hiz.get());
  const gpu_types::HizPush push{job_.target->buffer.address, hiz_.address, job_.target->generation(),
                                job_.extent.width, job_.extent.height};
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
  vkCmdDispatch(commands, (job_.extent.width + 63) / 64, (job_.extent.height + 63) / 64, 1);
}

void ClusterRaster::record_round(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets,
                                 uint32_t round) {
  const RoundNames& names = kRoundNames[round];
  auto list_uses = [round](ClusterRaster& set, std::vector<Use>& uses) {
    set.add_uses(uses);
    if (set.clear_quads(round)) uses.emplace_back(set.job_.target->buffer, access::compute_write);
    if (set.round_count_ != 2) return;
    uses.emplace_back(set.was_visible_, access::compute_write);
    uses.emplace_back(set.hiz_, access::compute_read);
  };
  auto first_uses = [](ClusterRaster& set, std::vector<Use>& uses) {
    set.add_uses(uses);
    uses.emplace_back(set.job_.target->buffer, access::compute_write);
  };
  // The target is declared in the first stage only: atomic maxima commute and need no barriers. Per-tile
  // raster needs the earlier stages' results.
  auto later_uses = [](ClusterRaster& set, std::vector<Use>& uses) { set.add_uses(uses); };
  auto tile_uses = [](ClusterRaster& set, std::vector<Use>& uses) {
    set.add_uses(uses);
    if (set.tile_by_tile_) uses.emplace_back(set.job_.target->buffer, access::compute_write);
  };

  stage(recorder, names.cull, sets, list_uses,
        [&](ClusterRaster& set, VkCommandBuffer commands) { set.cull(commands, round); });
  stage(recorder, names.raster, sets, first_uses,
        [&](ClusterRaster& set, VkCommandBuffer commands) { set.raster(commands, round); });
  stage(recorder, names.expand, sets, later_uses, [&](ClusterRaster& set, VkCommandBuffer commands) {
    set.large_stage(commands, set.large().expand, round, offsetof(gpu_types::LargeWork, expand));
  });
  stage(recorder, names.tiles, sets, tile_uses,
        [&](ClusterRaster& set, VkCommandBuffer commands) { set.draw_tiles(commands, round); });
}

void ClusterRaster::keep_counts(gpu::Recorder& recorder) {
  rounds_counted_[frame_ % gpu::kFramesInFlight] = round_count_;
  gpu::Buffer& counts = counts_[frame_++ % gpu::kFramesInFlight];
  const VkDeviceSize one = sizeof(gpu_types::ViewWork);
  static_assert(offsetof(Counts, work) == sizeof(Counts::large));  // same layout as in `work_`
  std::vector<VkBufferCopy> regions{{0, 0, sizeof(Counts::large) + one}};
  if (round_count_ == 2)
    regions.push_back({view_work_at(1, job_.view_count), offsetof(Counts, work) + one, one});
  recorder.copy_at_end(work_, counts, std::move(regions));
}

ClusterRaster::Clear ClusterRaster::clear_of(std::span<ClusterRaster* const> sets) {
  Clear clear_of;
  for (ClusterRaster* set : sets) {
    clear_of.uses.emplace_back(set->work_, access::transfer_write);
    if (set->job_.target->needs_clear())
      clear_of.uses.emplace_back(set->job_.target->buffer, access::transfer_write);
    if (set->tile_by_tile_) clear_of.uses.emplace_back(set->tile_lists_, access::transfer_write);
    if (set->round_count_ == 2 && set->was_visible_is_new_)
      clear_of.uses.emplace_back(set->was_visible_, access::transfer_write);
  }
  clear_of.commands = [all = std::vector(sets.begin(), sets.end())](VkCommandBuffer commands) {
    for (ClusterRaster* set : all) set->clear(commands);
  };
  return clear_of;
}

void ClusterRaster::record(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets) {
  record_round(recorder, sets, 0);

  std::vector<ClusterRaster*> late;
  std::copy_if(sets.begin(), sets.end(), std::back_inserter(late),
               [](const ClusterRaster* set) { return set->round_count_ == 2; });
  if (!late.empty()) {
    stage(
        recorder, "depth pyramid", late,
        [](ClusterRaster& set, std::vector<Use>& uses) {
          uses.emplace_back(set.job_.target->buffer, access::compute_read);
          uses.emplace_back(set.hiz_, access::compute_write);
        },
        [](ClusterRaster& set, VkCommandBuffer commands) { set.build_hiz(commands); });
    record_round(recorder, late, 1);
  }
  for (ClusterRaster* set : sets) set->keep_counts(recorder);
}

}  // namespace fire3dv::passes
