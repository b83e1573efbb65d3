// Preparation of frames by SceneRenderer: availability of outputs and inspection, targets, memory, and
// path-traced samples.
#include <algorithm>
#include <string>
#include <utility>

#include "renderer/passes/scene_renderer.h"

namespace fire3dv::passes {
namespace {

// Limits of cached targets of other sizes.
constexpr VkDeviceSize kMaxCacheBytes = VkDeviceSize{256} << 20;
constexpr size_t kMaxCachedSizes = 8;

}  // namespace

Result<PreparedFrame> SceneRenderer::prepare(const FrameRequest& request, Shortage* shortage) {
  ++prepared_;  // earlier prepared frames are no longer valid
  Shortage ignored{};
  Shortage& reason = shortage ? *shortage : ignored;
  if (Result<void> can = can_take(request.outputs, request.views); !can) {
    reason = Shortage::unsupported_outputs;
    return can.error();
  }
  if (request.scene == SceneUpdate::update && outputs_) outputs_->invalidate_snapshot();
  if (request.outputs.has(wire::kMotion) && !outputs_->has_room_for_snapshot(*gpu_scene_)) {
    reason = Shortage::motion_snapshots;
    return Error{
        "the device keeps where everything was for images of other frames that want motion, and has no "
        "room for more; ask for motion with every frame, or in fewer requests"};
  }
  FrameRequest usable = request;
  try {
    set_targets(request.extent, request.views);
    usable.inspection = available(request.inspection, request.outputs);
    allocate(usable);
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    reason = Shortage::device_memory;
    return Error{"the device has no memory for an image of " + std::to_string(request.extent.width) + " x " +
                 std::to_string(request.extent.height) + "; ask for a smaller one"};
  }
  reason = Shortage::none;
  return PreparedFrame(std::move(usable), prepared_);
}

void SceneRenderer::set_targets(VkExtent2D extent, uint32_t views) {
  const bool is_set = targets_ && targets_->extent.width == extent.width &&
                      targets_->extent.height == extent.height && targets_->views == views;
  if (is_set) return;
  targets_ = nullptr;  // after an allocation failure only some passes have the new targets
  Targets& targets = find_or_create_targets(extent, views);
  try {
    if (visibility_) visibility_->set_targets(targets);
    shadows_.set_targets(targets);
  } catch (const gpu::VulkanFailure&) {
    // Drop partially set targets.
    if (visibility_) visibility_->reset_targets();
    shadows_.reset_targets();
    target_cache_.erase(target_cache_.begin());
    throw;
  }
  targets_ = &targets;
  drop_old_targets();
}

Targets& SceneRenderer::find_or_create_targets(VkExtent2D extent, uint32_t views) {
  auto& cache = target_cache_;
  const auto known = std::find_if(cache.begin(), cache.end(), [&](const std::unique_ptr<Targets>& targets) {
    return targets->extent.width == extent.width && targets->extent.height == extent.height &&
           targets->views == views;
  });
  if (known != cache.end()) {
    std::rotate(cache.begin(), known, known + 1);
  } else {
    auto created = std::make_unique<Targets>(device_, extent, views, samples_);
    if (views == 1) post_.bind(*created);
    cache.insert(cache.begin(), std::move(created));
  }
  return *cache.front();
}

void SceneRenderer::drop_old_targets() {
  VkDeviceSize bytes = 0;
  for (size_t i = 1; i < target_cache_.size(); ++i) {
    bytes += bytes_of(*target_cache_[i]);
    if (i < kMaxCachedSizes && bytes <= kMaxCacheBytes) continue;
    target_cache_.resize(i);
    return;
  }
}

// Edits of this frame may still change the plan; record() then allocates the rest.
void SceneRenderer::allocate(const FrameRequest& request) {
  const FramePlan plan = plan_frame(facts(request), request.outputs, request.inspection, request.views);
  if (outputs_) outputs_->begin(request.outputs, *gpu_scene_, request.extent, request.views);
  if (plan.visibility_buffer)
    visibility_->allocate(*gpu_scene_, settings_.cull, plan.camera_levels_of_detail);
  if (plan.ray_effects)
    ray_effects_->allocate(*targets_, gpu_scene_->refracts, settings_.ray_effects.on.bounce);
  if (path_tracer_ && request.outputs.shaded())
    path_tracer_->allocate(uint64_t{request.extent.width} * request.extent.height, request.keeps_last);
  if (plan.depth_of_field) {
    if (!depth_of_field_) depth_of_field_ = std::make_unique<DepthOfFieldPass>(device_, samples_);
    depth_of_field_->allocate(*targets_);
  }
  if (plan.metering) {
    if (!light_meter_)
      light_meter_ = std::make_unique<LightMeterPass>(device_, samples_, path_tracer_ != nullptr);
    light_meter_->bind(*targets_);
  }
  if (plan.bloom) {
    if (!bloom_) bloom_ = std::make_unique<BloomPass>(device_, samples_, path_tracer_ != nullptr);
    if (bloom_->allocate(*targets_)) {
      if (path_tracer_) {
        path_tracer_->bind_bloom(*targets_);
      } else {
        post_.bind_bloom(device_, *targets_);
      }
    }
  }
}

bool SceneRenderer::trace_paths(const PreparedFrame& prepared, const state::PoseState& poses,
                                const View& view, const PathPass::Hooks& hooks) {
  FIRE3DV_ASSERT(path_tracer_ && prepared.number_ == prepared_ && targets_ && targets_->views == 1);
  const gpu_types::Globals globals = make_globals(view, false);
  const FrameRequest& request = prepared.request();
  const bool is_same_scene =
      request.scene == SceneUpdate::reuse || traced_scene_.equals(poses, edit_revisions());
  const bool goes_on = request.refines && (path_tracer_->has_begun(globals.width, globals.height) ||
                                           (is_same_scene && path_tracer_->is_current(globals, view)));
  if (!goes_on) {
    if (!is_same_scene) path_tracer_->drop();
    gpu::FrameRing& ring = path_tracer_->submissions();
    gpu::Recorder& recorder = ring.begin();
    update_scene(recorder, ring.staging(), poses, false);
    shadows_.upload_changes(recorder, ring.staging());
    record_acceleration_structures(recorder);
    // The edits of this update may have replaced buffers.
    path_tracer_->begin(recorder, make_globals(view, false), view, hooks.resume);
    (void)ring.submit();
    traced_scene_.set(poses, edit_revisions());
  }
  return path_tracer_->trace(*gpu_scene_, hooks);
}

Result<std::optional<SceneRenderer::BegunFrame>> SceneRenderer::begin_next(gpu::FrameRing& frames,
                                                                           const FrameRequest& request,
                                                                           const state::PoseState& poses,
                                                                           const View& view,
                                                                           const PathPass::Hooks& hooks) {
  FrameRequest of_view = request;
  of_view.lens = has_thin_lens(view);
  const Result<PreparedFrame> prepared = prepare(of_view);
  if (!prepared) return prepared.error();
  if (path_tracer_ && request.outputs.shaded() && !trace_paths(*prepared, poses, view, hooks))
    return std::optional<BegunFrame>();
  return std::optional<BegunFrame>(BegunFrame{*prepared, frames.begin()});
}

bool SceneRenderer::shows_markers(const FrameRequest& request) const {
  return request.markers && markers_ && !markers_->empty();
}

FrameFacts SceneRenderer::facts(const FrameRequest& request) const {
  FrameFacts facts;
  facts.raster_path = path_;
  facts.can_write_samples = visibility_ && visibility_->can_write_samples();
  facts.levels_of_detail = settings_.levels_of_detail;
  facts.scene_has_levels = gpu_scene_->cluster_instance_count > gpu_scene_->lod0_cluster_instance_count;
  facts.has_forward_only = gpu_scene_->has_forward_only;
  facts.has_markers = shows_markers(request);
  facts.shadows_on = shadows_on_;
  facts.shadow_technique = shadow_technique_;
  facts.is_path_traced = path_tracer_ != nullptr;
  facts.ray_effects = traces_ray_effects();
  facts.has_lights = shadows_.has_lights();
  facts.needs_shadow_maps = shadows_.needs_maps();
  facts.bloom = settings_.post.bloom > 0;
  facts.metered = settings_.post.metered;
  facts.depth_of_field = has_depth_of_field(request.lens);
  return facts;
}

bool SceneRenderer::has_depth_of_field(bool view_has_lens) const {
  return (view_has_lens || cameras_have_lenses_ || !settings_.post.lens.is_pinhole()) && can_blur();
}

const scene::ThinLens& SceneRenderer::lens_of_settings() const {
  return path_tracer_ ? path_tracer_->settings().lens : settings_.post.lens;
}

Result<void> SceneRenderer::can_blur() const {
  if (path_tracer_) return Error{"paths start on the lens: their images need no blur"};
  if (path_ != RasterPath::visibility)
    return Error{"depth of field comes from the visibility buffer" +
                 (settings_.raster == RasterPath::forward
                      ? std::string(": leave --raster forward out")
                      : ", for which " + device_.report().name +
                            " lacks 64-bit atomics: choose another device with --device")};
  if (!visibility_->can_write_samples())
    return Error{"depth of field of several samples needs what " + device_.report().name +
                 " lacks (shaderStorageImageMultisample): take one sample with --samples 1"};
  return {};
}

Result<void> SceneRenderer::can_take(const ImageOutputs& outputs, uint32_t views) const {
  if (views > 1 && path_tracer_) return Error{"paths are traced for one camera at a time"};
  if (views > 1) {
    // Edits may show hidden nodes in the recorded frame.
    const bool has_effects =
        ((settings_.post.reads_samples() || traces_ray_effects()) && outputs.has(wire::kColorSrgb8)) ||
        (has_depth_of_field() && outputs.shaded());
    const bool alone = path_ != RasterPath::visibility || may_have_forward_only_ || has_effects;
    if (alone || outputs.has(wire::kColorLinearF16))
      return Error{
          "several cameras at once need the visibility path, a scene without blended surfaces, lines and "
          "points, no bloom, no metered exposure, no ray effects, no lens and no linear colours: take one "
          "after the other"};
  }
  if (!outputs.has_planes()) return {};
  if (path_ != RasterPath::visibility) {
    return Error{settings_.raster == RasterPath::forward
                     ? "outputs beside color come from the visibility buffer: leave --raster forward out"
                     : "outputs beside color come from the visibility buffer, for which " +
                           device_.report().name +
                           " lacks 64-bit atomics: choose another device with --device"};
  }
  if (outputs.has(wire::kColorLinearF16) && !path_tracer_ && !visibility_->can_write_samples())
    return Error{"linear colours of several samples need what " + device_.report().name +
                 " lacks (shaderStorageImageMultisample): take one sample with --samples 1"};
  return {};
}

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
        std::string("the debug view unresolved-shadows shows pixels that shadow maps leave to rays, but the "
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

}  // namespace fire3dv::passes
