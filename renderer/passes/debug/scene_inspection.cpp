// Inspection passes of SceneRenderer: see inspection.h.
#include <string>

#include "renderer/passes/scene_renderer.h"

namespace fire3dv::passes {

Result<void> SceneRenderer::can_inspect() const {
  if (path_ == RasterPath::visibility) return {};
  return Error{"picking, outlines and debug views come from the visibility buffer" +
               (settings_.raster == RasterPath::forward
                    ? std::string(": leave --raster forward out")
                    : ", for which " + device_.report().name +
                          " lacks 64-bit atomics: choose another device with --device")};
}

Result<void> SceneRenderer::can_show(DebugView view) const {
  if (view == DebugView::none) return {};
  if (Result<void> can = can_inspect(); !can) return can;
  if (view == DebugView::shadow_doubt && !shadow_way_.hybrid) {
    return Error{
        std::string("shadow doubt is what shadow maps leave to rays, but here shadows are found by ") +
        describe(shadow_way_) + ": take both, as --shadows ray does without --shadow-rays all"};
  }
  return {};
}

Inspection SceneRenderer::possible_of(Inspection wanted, const ImageOutputs& outputs) const {
  if (targets_->views > 1 || !outputs.has(wire::kColorSrgb8) || !can_inspect()) return {};
  const bool loses_light = replaces_shading(wanted.debug_view) && outputs.has(wire::kColorLinearF16);
  if (loses_light || !can_show(wanted.debug_view)) wanted.debug_view = DebugView::none;
  const VkExtent2D extent = targets_->extent;
  if (wanted.pick && (wanted.pick->x >= extent.width || wanted.pick->y >= extent.height)) wanted.pick.reset();
  return wanted;
}

// Picking and debug view, before the coverage merge.
void SceneRenderer::inspect(gpu::Recorder& recorder, gpu::StagingRing& belt, const View& view,
                            VkDeviceAddress globals, const Inspection& inspection) {
  if (!inspector_)
    inspector_ = std::make_unique<Inspector>(device_, layout_.get(), scene_set_layout_.get(),
                                             samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1);
  inspector_->draw_on(*targets_, image());
  const SeenView seen{*scene_, *gpu_scene_, targets_->visibility.buffer, view, globals, targets_->extent};
  if (inspection.pick) inspector_->pick(recorder, seen, *inspection.pick);
  if (!replaces_shading(inspection.debug_view)) return;
  inspector_->debug_views().show(recorder, belt, seen, inspection.debug_view,
                                 {settings_.cull, shows_levels()}, image());
}

// Overlays on the finished image.
void SceneRenderer::mark(gpu::Recorder& recorder, gpu::StagingRing& belt, const View& view,
                         VkDeviceAddress globals, const Inspection& inspection, bool masked) {
  const SeenView seen{*scene_, *gpu_scene_, targets_->visibility.buffer, view, globals, targets_->extent};
  if (inspection.debug_view == DebugView::shadow_doubt)
    inspector_->debug_views().mark_doubt(recorder, seen, shadows_, masked, image());
  if (inspection.selected != scene::kNone)
    inspector_->outline(recorder, belt, seen, inspection.selected, image());
}

void SceneRenderer::submitted(uint64_t timeline_value) {
  if (inspector_ && inspector_->picks()) inspector_->picks()->submitted(timeline_value);
}

std::vector<Picked> SceneRenderer::take_picked() {
  return inspector_ && inspector_->picks() ? inspector_->picks()->take_picked() : std::vector<Picked>();
}

}  // namespace fire3dv::passes
