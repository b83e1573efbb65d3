#include "renderer/passes/debug/inspector.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "renderer/passes/visibility/visibility_pass.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

uint32_t number_of(settings::DebugView view) {
  switch (view) {
    case settings::DebugView::normals:
      return FIRE3DV_DEBUG_NORMALS;
    case settings::DebugView::depth:
      return FIRE3DV_DEBUG_DEPTH;
    case settings::DebugView::clusters:
      return FIRE3DV_DEBUG_CLUSTERS;
    case settings::DebugView::overdraw:
      return FIRE3DV_DEBUG_OVERDRAW;
    case settings::DebugView::instances:
    case settings::DebugView::none:
    case settings::DebugView::unresolved_shadows:
      break;
  }
  return FIRE3DV_DEBUG_INSTANCES;
}

void dispatch_pixels(VkCommandBuffer commands, VkExtent2D extent) {
  vkCmdDispatch(commands, (extent.width + 7) / 8, (extent.height + 7) / 8, 1);
}

// Bit mask of the parts of a node and its descendants. Parents precede their children.
std::vector<uint32_t> bits_of_all_below(const scene::Scene& scene, const GpuScene& gpu_scene,
                                        uint32_t selected) {
  std::vector<bool> is_selected(scene.nodes.size(), false);
  for (uint32_t node = selected; node < scene.nodes.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    is_selected[node] = node == selected || (parent != scene::kNone && is_selected[parent]);
  }
  const std::vector<uint32_t> nodes = gpu_scene.nodes_of_parts();
  std::vector<uint32_t> bits(nodes.size() / 32 + 1, 0);
  for (uint32_t part = 0; part < nodes.size(); ++part) {
    if (is_selected[nodes[part]]) bits[part / 32] |= 1u << (part % 32);
  }
  return bits;
}

}  // namespace
ImageOverlay::ImageOverlay(gpu::Device& device, VkDescriptorSetLayout scene_set_layout) : device_(device) {
  const VkDescriptorSetLayoutBinding binding{FIRE3DV_BINDING_DISPLAY, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1,
                                             VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  set_layout_ = gpu::create_set_layout(device, {&binding, 1});
  layout_ = gpu::create_pipeline_layout(device, std::array{scene_set_layout, set_layout_.get()});
}

void ImageOverlay::draw_on(Targets& targets, const gpu::Image& image) {
  if (targets.overlay_view != image.view.get()) {
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1};
    targets.overlay_set = gpu::DescriptorSet(device_, set_layout_.get(), {&size, 1});
    const VkDescriptorImageInfo info{VK_NULL_HANDLE, image.view.get(), VK_IMAGE_LAYOUT_GENERAL};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = targets.overlay_set.get();
    write.dstBinding = FIRE3DV_BINDING_DISPLAY;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    write.pImageInfo = &info;
    vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
    targets.overlay_view = image.view.get();
  }
  set_ = targets.overlay_set.get();
}

void ImageOverlay::begin(VkCommandBuffer commands, const gpu::Pipeline& pipeline, const GpuScene& scene,
                         const void* push, uint32_t push_bytes) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
  const VkDescriptorSet sets[] = {scene.textures.set(), set_};
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 2, sets, 0, nullptr);
  vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, push_bytes, push);
}

PickPass::PickPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples)
    : layout_(layout),
      pipeline_(gpu::create_compute_pipeline(device, layout, samples == 4 ? "pick_4.comp" : "pick_1.comp")),
      picked_(gpu::create_buffer(device, sizeof(gpu_types::PickedSurface), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                 gpu::Memory::device)),
      ring_(device) {}

void PickPass::record(gpu::Recorder& recorder, const InspectedView& seen, const Pick& pick) {
  FIRE3DV_ASSERT(pick.x < seen.extent.width && pick.y < seen.extent.height);
  std::vector<Use> uses{Use(seen.visibility, access::compute_read), Use(picked_, access::compute_write)};
  seen.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("pick", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    const VkDescriptorSet set = seen.gpu_scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    gpu_types::PickPush push{};
    push.globals = seen.globals;
    push.visibility = seen.visibility.address;
    push.picked = picked_.address;
    push.look_world = seen.view.look_world;
    push.orthographic = seen.view.orthographic ? 1 : 0;
    push.x = pick.x;
    push.y = pick.y;
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, 1, 1, 1);
  });
  ring_.record(recorder, nullptr, {0, 0}, {&picked_, sizeof(gpu_types::PickedSurface)},
               {pick.tag, seen.gpu_scene.nodes_of_parts(), seen.gpu_scene.node_count});
}

std::vector<Picked> PickPass::take_picked() {
  std::vector<Picked> found;
  ring_.poll([&](const Pending& pending, VkExtent2D, std::span<const uint8_t> bytes) {
    gpu_types::PickedSurface surface;
    std::memcpy(&surface, bytes.data(), sizeof(surface));
    Picked& picked = found.emplace_back();
    picked.tag = pending.tag;
    picked.depth_m = surface.depth_m;
    if (surface.part >= pending.nodes_of_parts.size()) return;  // the background
    picked.node = pending.nodes_of_parts[surface.part];
    picked.position_world = surface.world;
    const gpu_types::AffineRows& rows = surface.world_from_node;
    picked.world_from_node.reset();
    if (surface.transform < pending.node_count)
      picked.world_from_node =
          glm::transpose(glm::mat4(rows.row0, rows.row1, rows.row2, glm::vec4(0, 0, 0, 1)));
  });
  return found;
}

DebugViews::DebugViews(gpu::Device& device, VkPipelineLayout layout, const ImageOverlay& overlay,
                       uint32_t samples)
    : device_(device), layout_(layout), overlay_(overlay), samples_(samples) {
  range_ = gpu::create_buffer(device, sizeof(gpu_types::DepthRange), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                              gpu::Memory::device);
}

// Rasters the scene again and counts triangles at the pixels' centres, hidden ones included.
void DebugViews::count(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen,
                       const Drawn& drawn) {
  if (!counting_) counting_.emplace(device_, layout_, RasterKind::camera_counts);
  const VkDeviceSize bytes = VkDeviceSize{8} * seen.extent.width * seen.extent.height;
  if (!counts_.buffer || counts_.buffer.size_bytes != bytes)
    counts_.buffer =
        gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  counts_.begin_empty(bytes);
  const gpu_types::RasterView view = raster_view(seen.view, seen.extent, drawn.levels);
  ClusterRaster::Job job;
  job.scene = &seen.gpu_scene;
  job.target = &counts_;
  job.target_bytes = bytes;
  job.views = staging.write(std::span<const gpu_types::RasterView>(&view, 1)).address;
  job.globals = seen.globals;
  job.extent = seen.extent;
  job.cull = drawn.cull == settings::Cull::off ? settings::Cull::off : settings::Cull::view;
  job.levels_of_detail = drawn.levels != CameraLevels::finest;
  counting_->begin(staging, job);
  ClusterRaster* const set = &*counting_;
  const ClusterRaster::Clear clear_of = ClusterRaster::clear_of({&set, 1});
  recorder.pass("clear", clear_of.uses, clear_of.commands);
  ClusterRaster::record(recorder, {&set, 1});
}

void DebugViews::find_range(gpu::Recorder& recorder, const InspectedView& seen, const gpu::Pipeline& pipeline,
                            gpu_types::DebugViewPush push, gpu::Image& image) {
  push.view = FIRE3DV_DEBUG_DEPTH_RANGE;
  recorder.transition({Use(range_, access::transfer_write)});
  vkCmdFillBuffer(recorder.commands(), range_.get(), 0, VK_WHOLE_SIZE, 0);
  std::vector<Use> uses{Use(seen.visibility, access::compute_read), Use(range_, access::compute_write),
                        Use(image, access::compute_write, true)};  // bound as a storage image
  seen.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("depth range", uses, [&](VkCommandBuffer commands) {
    overlay_.begin(commands, pipeline, seen.gpu_scene, push);
    dispatch_pixels(commands, seen.extent);
  });
}

void DebugViews::show(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen,
                      settings::DebugView view, const Drawn& drawn, gpu::Image& image) {
  if (!view_)
    view_ = gpu::create_compute_pipeline(device_, overlay_.layout(),
                                         samples_ == 4 ? "debug_view_4.comp" : "debug_view_1.comp");
  if (view == settings::DebugView::overdraw) count(recorder, staging, seen, drawn);
  gpu_types::DebugViewPush push{};
  push.globals = seen.globals;
  push.visibility = seen.visibility.address;
  push.counts = counts_.buffer.address;
  push.range = range_.address;
  push.look_world = seen.view.look_world;
  push.orthographic = seen.view.orthographic ? 1 : 0;
  push.view = number_of(view);
  if (view == settings::DebugView::instances)
    push.nodes = staging.write(std::span<const uint32_t>(seen.gpu_scene.nodes_of_parts())).address;
  if (view == settings::DebugView::depth) find_range(recorder, seen, view_, push, image);
  std::vector<Use> uses{Use(seen.visibility, access::compute_read), Use(range_, access::compute_read),
                        Use(image, access::compute_write, true)};
  if (view == settings::DebugView::overdraw) uses.emplace_back(counts_.buffer, access::compute_read);
  seen.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("debug view", uses, [&](VkCommandBuffer commands) {
    overlay_.begin(commands, view_, seen.gpu_scene, push);
    dispatch_pixels(commands, seen.extent);
  });
}

void DebugViews::mark_unresolved(gpu::Recorder& recorder, const InspectedView& seen, ShadowPass& shadows,
                                 bool listed, gpu::Image& image) {
  if (!unresolved_)
    unresolved_ = gpu::create_compute_pipeline(device_, overlay_.layout(), "unresolved_shadows.comp");
  const uint32_t pixels = seen.extent.width * seen.extent.height;
  gpu_types::UnresolvedPixelsPush push{shadows.lists().address, shadows.entries().address, seen.extent.width,
                                       seen.extent.height, 0};
  recorder.pass("debug view", {Use(image, access::compute_write)}, [&](VkCommandBuffer commands) {
    overlay_.begin(commands, unresolved_, seen.gpu_scene, push);
    const uint32_t groups = (pixels + 63) / 64;
    vkCmdDispatch(commands, std::min(groups, 65535u), (groups + 65534) / 65535, 1);
  });
  if (!listed || !shadows.traces()) return;
  push.marks = 1;
  gpu::Access arguments = access::compute_read;  // the list holds dispatch arguments and input
  arguments.stages |= access::indirect_read.stages;
  arguments.access |= access::indirect_read.access;
  recorder.pass("debug view",
                {Use(shadows.lists(), arguments), Use(shadows.entries(), access::compute_read),
                 Use(image, access::compute_write)},
                [&](VkCommandBuffer commands) {
                  overlay_.begin(commands, unresolved_, seen.gpu_scene, push);
                  vkCmdDispatchIndirect(commands, shadows.lists().get(),
                                        offsetof(gpu_types::RayList, groups_x));
                });
}

Inspector::Inspector(gpu::Device& device, VkPipelineLayout layout, VkDescriptorSetLayout scene_set_layout,
                     uint32_t samples)
    : device_(device), layout_(layout), samples_(samples), overlay_(device, scene_set_layout) {}

void Inspector::pick(gpu::Recorder& recorder, const InspectedView& seen, const Pick& pick) {
  if (!pick_) pick_ = std::make_unique<PickPass>(device_, layout_, samples_);
  pick_->record(recorder, seen, pick);
}

DebugViews& Inspector::debug_views() {
  if (!debug_views_) debug_views_ = std::make_unique<DebugViews>(device_, layout_, overlay_, samples_);
  return *debug_views_;
}

void Inspector::outline(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen,
                        uint32_t selected, gpu::Image& image) {
  if (!outline_)
    outline_ = gpu::create_compute_pipeline(device_, overlay_.layout(),
                                            samples_ == 4 ? "outline_4.comp" : "outline_1.comp");
  const std::vector<uint32_t> bits = bits_of_all_below(seen.scene, seen.gpu_scene, selected);
  const gpu_types::OutlinePush push{seen.globals, seen.visibility.address,
                                    staging.write(std::span<const uint32_t>(bits)).address};
  std::vector<Use> uses{Use(seen.visibility, access::compute_read), Use(image, access::compute_write)};
  seen.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("outline", uses, [&](VkCommandBuffer commands) {
    overlay_.begin(commands, outline_, seen.gpu_scene, push);
    vkCmdDispatch(commands, (seen.extent.width + 7) / 8, (seen.extent.height + 7) / 8, 1);
  });
}

}  // namespace fire3dv::passes
