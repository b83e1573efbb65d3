#include "renderer/passes/debug/debug_views.h"

#include <algorithm>
#include <cstddef>

#include "renderer/passes/visibility/visibility_pass.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

uint32_t number_of(DebugView view) {
  switch (view) {
    case DebugView::normals:
      return FIRE3DV_DEBUG_NORMALS;
    case DebugView::depth:
      return FIRE3DV_DEBUG_DEPTH;
    case DebugView::clusters:
      return FIRE3DV_DEBUG_CLUSTERS;
    case DebugView::overdraw:
      return FIRE3DV_DEBUG_OVERDRAW;
    case DebugView::instances:
    case DebugView::none:
    case DebugView::unresolved_shadows:
      break;
  }
  return FIRE3DV_DEBUG_INSTANCES;
}

void dispatch_pixels(VkCommandBuffer commands, VkExtent2D extent) {
  vkCmdDispatch(commands, (extent.width + 7) / 8, (extent.height + 7) / 8, 1);
}

}  // namespace

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
  const gpu_types::RasterView view = raster_view(seen.view, seen.extent, drawn.levels_of_detail);
  ClusterRaster::Job job;
  job.scene = &seen.gpu_scene;
  job.target = &counts_;
  job.target_bytes = bytes;
  job.views = staging.write(std::span<const gpu_types::RasterView>(&view, 1)).address;
  job.globals = seen.globals;
  job.extent = seen.extent;
  job.cull = drawn.cull == Cull::off ? Cull::off : Cull::view;
  job.levels_of_detail = drawn.levels_of_detail;
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
                      DebugView view, const Drawn& drawn, gpu::Image& image) {
  if (!view_)
    view_ = gpu::create_compute_pipeline(device_, overlay_.layout(),
                                         samples_ == 4 ? "debug_view_4.comp" : "debug_view_1.comp");
  if (view == DebugView::overdraw) count(recorder, staging, seen, drawn);
  gpu_types::DebugViewPush push{};
  push.globals = seen.globals;
  push.visibility = seen.visibility.address;
  push.counts = counts_.buffer.address;
  push.range = range_.address;
  push.look_world = seen.view.look_world;
  push.orthographic = seen.view.orthographic ? 1 : 0;
  push.view = number_of(view);
  if (view == DebugView::depth) find_range(recorder, seen, view_, push, image);
  std::vector<Use> uses{Use(seen.visibility, access::compute_read), Use(range_, access::compute_read),
                        Use(image, access::compute_write, true)};
  if (view == DebugView::overdraw) uses.emplace_back(counts_.buffer, access::compute_read);
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

}  // namespace fire3dv::passes
