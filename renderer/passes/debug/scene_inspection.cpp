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
  if (view == DebugView::unresolved_shadows && !shadow_technique_.hybrid) {
    return Error{
        std::string("the debug view shadow-doubt shows pixels that shadow maps leave to rays, but the "
                    "shadow technique is ") +
        describe(shadow_technique_) + ": take both, as --shadows ray does without --shadow-rays all"};
  }
  return {};
}

Inspection SceneRenderer::available(Inspection inspection, const ImageOutputs& outputs) const {
  if (targets_->views > 1 || !outputs.has(wire::kColorSrgb8) || !can_inspect()) return {};
  const bool loses_light = replaces_shading(inspection.debug_view) && outputs.has(wire::kColorLinearF16);
  if (loses_light || !can_show(inspection.debug_view)) inspection.debug_view = DebugView::none;
  const VkExtent2D extent = targets_->extent;
  if (inspection.pick && (inspection.pick->x >= extent.width || inspection.pick->y >= extent.height))
    inspection.pick.reset();
  return inspection;
}

void SceneRenderer::draw_debug_view(const Frame& frame) {
  const Inspection& inspection = frame.request.inspection;
  if (!inspector_)
    inspector_ = std::make_unique<Inspector>(device_, layout_.get(), scene_set_layout_.get(),
                                             samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1);
  inspector_->draw_on(*targets_, image());
  const InspectedView view{*scene_,        *gpu_scene_,      targets_->visibility.buffer,
                           frame.views[0], frame.globals[0], targets_->extent};
  if (inspection.pick) inspector_->pick(frame.recorder, view, *inspection.pick);
  if (!replaces_shading(inspection.debug_view)) return;
  inspector_->debug_views().show(frame.recorder, frame.staging, view, inspection.debug_view,
                                 {settings_.cull, frame.plan.camera_levels_of_detail}, image());
}

void SceneRenderer::draw_overlays(const Frame& frame) {
  const Inspection& inspection = frame.request.inspection;
  const InspectedView view{*scene_,        *gpu_scene_,      targets_->visibility.buffer,
                           frame.views[0], frame.globals[0], targets_->extent};
  if (inspection.debug_view == DebugView::unresolved_shadows)
    inspector_->debug_views().mark_unresolved(frame.recorder, view, shadows_, frame.plan.shadow_mask,
                                              image());
  if (inspection.selected != scene::kNone)
    inspector_->outline(frame.recorder, frame.staging, view, inspection.selected, image());
}

void SceneRenderer::submitted(uint64_t timeline_value) {
  if (inspector_ && inspector_->picks()) inspector_->picks()->submitted(timeline_value);
}

std::vector<Picked> SceneRenderer::take_picked() {
  return inspector_ && inspector_->picks() ? inspector_->picks()->take_picked() : std::vector<Picked>();
}

}  // namespace fire3dv::passes
