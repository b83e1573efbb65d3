#include "renderer/passes/scene_renderer.h"

#include <string>
#include <utility>

#include "renderer/passes/frame.h"
#include "renderer/passes/frame_plan.h"
#include "renderer/passes/resources/scene_parts.h"
#include "renderer/passes/resources/target_cache.h"

namespace fire3dv::passes {

using gpu::Use;
namespace access = gpu::access;

scene::Levels levels_for(settings::LevelsOfDetail wanted) {
  if (wanted == settings::LevelsOfDetail::off) return scene::Levels::none;
  return wanted == settings::LevelsOfDetail::automatic ? scene::Levels::automatic_levels : scene::Levels::all;
}

SceneRenderer::SceneRenderer(gpu::Device& device, const settings::DrawSettings& settings)
    : device_(device),
      settings_(device, settings),
      passes_(std::make_unique<ScenePasses>(device, settings, settings_)),
      targets_(std::make_unique<TargetCache>(device, settings_.samples())) {}

SceneRenderer::~SceneRenderer() = default;

void SceneRenderer::apply(const settings::DrawSettings& settings) {
  settings_.apply(settings);
  if (passes_->path_tracer) passes_->path_tracer->set(*settings_.draw().path);
}

void SceneRenderer::set_scene(const scene::Scene& scene, uint32_t worlds) {
  set_scene(scene, scene::derive(scene, levels_for(settings_.draw().levels_of_detail)), worlds);
}

void SceneRenderer::set_scene(const scene::Scene& scene, const scene::Derived& derived, uint32_t worlds) {
  passes_->expect_shading(settings_, scene);
  if (any_masked(scene)) {
    if (passes_->visibility) passes_->visibility->expect_masks();
    passes_->shadows.expect_masks();
  }
  SceneUses uses = passes_->uses_of(settings_, scene);
  uses.worlds = worlds;
  auto gpu_scene = std::make_unique<GpuScene>(device_, scene, derived, passes_->scene_set_layout.get(),
                                              passes_->environment.textures(), uses, gpu_scene_.get());
  passes_->shadows.set_scene(scene, *gpu_scene);
  // No call below fails.
  gpu_scene_ = std::move(gpu_scene);
  scene_ = &scene;
  if (passes_->path_tracer) passes_->path_tracer->drop();
  passes_->markers.forget();
  limits_ = {any_forward_only(scene, uses.refracts), any_lens(scene)};
  passes_->edit_uploader.reset();
  passes_->transforms.invalidate();
  passes_->deform.invalidate();
  passes_->forward.invalidate();
  if (passes_->outputs) passes_->outputs->set_scene();
  // The new scene has other ids.
  targets_->invalidate_ids();
}

SceneLimits SceneRenderer::limits() const {
  SceneLimits limits = limits_;
  limits.refracts = gpu_scene_ && gpu_scene_->refracts;
  return limits;
}

Result<PreparedFrame> SceneRenderer::prepare(const FrameRequest& request, Shortage* shortage) {
  ++prepared_;  // earlier prepared frames are no longer valid
  Shortage ignored{};
  Shortage& reason = shortage ? *shortage : ignored;
  if (Result<void> can = can_take(request.outputs, request.views); !can) {
    reason = Shortage::unsupported_outputs;
    return can.error();
  }
  if (request.scene == SceneUpdate::update && passes_->outputs) passes_->outputs->invalidate_snapshot();
  if (request.outputs.has(wire::kMotion) && !passes_->outputs->has_room_for_snapshot(*gpu_scene_)) {
    reason = Shortage::motion_snapshots;
    return Error{
        "the device keeps where everything was for images of other frames that want motion, and has no "
        "room for more; ask for motion with every frame, or in fewer requests"};
  }
  FrameRequest usable = request;
  try {
    targets_->select(
        request.extent, request.views,
        [this](Targets& created) {
          if (created.views == 1) passes_->post.bind(created);
        },
        [this](Targets& targets) { passes_->use(targets); });
    usable.inspection = available(request.inspection, request.outputs);
    const FramePlan plan = plan_frame(facts(usable), usable.outputs, usable.inspection, usable.views);
    passes_->allocate(settings_, usable, plan, *targets_->current(), *gpu_scene_);
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    reason = Shortage::device_memory;
    return Error{"the device has no memory for an image of " + std::to_string(request.extent.width) + " x " +
                 std::to_string(request.extent.height) + "; ask for a smaller one"};
  }
  reason = Shortage::none;
  return PreparedFrame(std::move(usable), prepared_);
}

void SceneRenderer::record(const PreparedFrame& prepared, gpu::Recorder& recorder, gpu::StagingRing& staging,
                           PosesOfWorlds poses, std::span<const View> views,
                           std::span<CameraHistory> histories) {
  const FrameRequest& request = prepared.request();
  FIRE3DV_ASSERT(prepared.number_ == prepared_ && targets_->current() &&
                 views.size() == targets_->current()->views && poses.size() == gpu_scene_->world_count);
  // Edits, transforms and deformed vertices. Edits may show other draws and lights, so the plan comes later.
  const bool draws_samples =
      gpu_scene_->has_forward_only || shows_markers(request) || settings_.draw().post.reads_samples();
  const bool is_updated = passes_->path_tracer && request.refines;  // by trace_paths()
  if (request.scene == SceneUpdate::update && !is_updated) {
    if (passes_->path_tracer && !passes_->traced_scene.equals(*poses[views[0].world], edit_revisions()))
      passes_->path_tracer->drop();
    update_scene(recorder, staging, poses, views[0], draws_samples);
  }
  const FramePlan plan = plan_frame(facts(request), request.outputs, request.inspection, request.views);
  // Markers that are new since the last image.
  if (plan.markers) {
    passes_->markers.update(recorder, staging, *markers_);
    passes_->markers.select(*markers_, views[0], request.extent);
  }
  // Lights and planar casters that were set since the last image.
  passes_->shadows.upload_changes(recorder, staging);
  // Ray lists, early, where their clear delays no other pass.
  if (plan.shadows) passes_->shadows.clear_ray_lists(recorder);
  // Acceleration structures, overlapped with rasterisation on the async compute queue where available.
  if (plan.acceleration_structures) build_acceleration_structures(recorder);
  // Generations of the targets, and the constants of each view.
  const FrameSource source{
      *passes_, settings_, *targets_->current(), *gpu_scene_, *scene_, image(), request, recorder, staging,
      poses,    views};
  Frame frame(source, plan);
  // Visibility buffer of the cameras, and shadow maps.
  frame.rasterise();
  // Planes derived from ids and depths.
  if (plan.surface_planes) frame.write_planes(histories);
  // Picking and debug view, before the coverage merge changes ids.
  if (plan.inspection) frame.draw_debug_view();
  // One shading sample for the triangles of one surface in a pixel.
  if (plan.coverage_merge) frame.merge_coverage();
  // Reflected light and occlusion of the visible surfaces, by rays.
  if (plan.ray_effects) frame.trace_ray_effects();
  // Shadow mask, and colours from the visibility buffer.
  if (plan.shadow_mask || plan.compute_shading) frame.shade();
  // The whole scene, or blended surfaces, lines and points.
  if (plan.forward) frame.draw_forward();
  // The lens of the camera.
  if (plan.depth_of_field) frame.blur();
  // Points, lines and shapes that streams show besides bodies.
  if (plan.markers) frame.draw_markers();
  // Colours of the path tracer.
  if (plan.path_resolve) frame.post_process();
  // Tone mapping, resolve and FXAA.
  if (plan.tone_map || plan.fxaa_only) frame.post_process();
  // Unresolved pixels and outline, on the finished image.
  if (plan.inspection) frame.draw_overlays();
}

void SceneRenderer::update_scene(gpu::Recorder& recorder, gpu::StagingRing& staging, PosesOfWorlds poses,
                                 const View& view, bool draws_forward) {
  has_acceleration_structures_ = false;
  if (edits_) {
    const EditUploader::Changed changed =
        passes_->edit_uploader.upload(recorder, staging, *gpu_scene_, *scene_, *edits_);
    if (changed.visibility) passes_->shadows.choose_planar_casters(*scene_, *gpu_scene_);
    if (changed.lights) passes_->shadows.set_lights_or_drop_shadows(scene::lights_of(*scene_, edits_));
    if (changed.vertices) passes_->deform.invalidate_vertices();
  }
  passes_->transforms.record(recorder, staging, *gpu_scene_, poses);
  // Only the raster pipeline sorts draws by winding; compute passes read it from the transforms pass.
  if (settings_.raster_path() == settings::RasterPath::forward || draws_forward)
    gpu_scene_->update_winding(recorder, staging, *scene_, view.world, *poses[view.world]);
  passes_->deform.record(recorder, staging, *gpu_scene_, poses);
}

void SceneRenderer::build_acceleration_structures(gpu::Recorder& recorder) {
  if (std::exchange(has_acceleration_structures_, true)) return;  // by an earlier image of the frame
  recorder.async_compute("tlas wait", [&] { record_acceleration_structures(recorder); });
}

void SceneRenderer::record_acceleration_structures(gpu::Recorder& recorder) {
  GpuScene& scene = *gpu_scene_;
  passes_->deform.record_levels(recorder, scene);
  recorder.pass(
      "tlas",
      {Use(scene.instances, access::build_input), Use(scene.top_level.storage(), access::build_write),
       Use(scene.top_level.scratch(), access::build_write)},
      [&](VkCommandBuffer commands) {
        scene.top_level.record_build(commands, scene.instances.address, scene.instance_count);
      });
}

bool SceneRenderer::trace_paths(const PreparedFrame& prepared, const state::PoseState& poses,
                                const View& view, const PathHooks& hooks) {
  FIRE3DV_ASSERT(passes_->path_tracer && prepared.number_ == prepared_ && targets_->current() &&
                 targets_->current()->views == 1 && gpu_scene_->world_count == 1);
  const auto globals_of = [&] {
    return passes_->make_globals(settings_, *gpu_scene_, *targets_->current(), view, false, 0);
  };
  const gpu_types::Globals globals = globals_of();
  const FrameRequest& request = prepared.request();
  const bool is_same_scene =
      request.scene == SceneUpdate::reuse || passes_->traced_scene.equals(poses, edit_revisions());
  const bool goes_on =
      request.refines && (passes_->path_tracer->has_begun(globals.width, globals.height) ||
                          (is_same_scene && passes_->path_tracer->is_current(globals, view)));
  if (!goes_on) {
    if (!is_same_scene) passes_->path_tracer->drop();
    gpu::FrameRing& ring = passes_->path_tracer->submissions();
    gpu::Recorder& recorder = ring.begin();
    const state::PoseState* const world = &poses;
    update_scene(recorder, ring.staging(), std::span(&world, 1), view, false);
    passes_->shadows.upload_changes(recorder, ring.staging());
    record_acceleration_structures(recorder);
    // The edits of this update may have replaced buffers.
    passes_->path_tracer->begin(recorder, globals_of(), view, hooks.resume);
    (void)ring.submit();
    passes_->traced_scene.set(poses, edit_revisions());
  }
  return passes_->path_tracer->trace(*gpu_scene_, hooks);
}

Result<std::optional<SceneRenderer::BegunFrame>> SceneRenderer::begin_next(gpu::FrameRing& frames,
                                                                           const FrameRequest& request,
                                                                           const state::PoseState& poses,
                                                                           const View& view,
                                                                           const PathHooks& hooks) {
  FrameRequest of_view = request;
  of_view.lens = has_thin_lens(view);
  const Result<PreparedFrame> prepared = prepare(of_view);
  if (!prepared) return prepared.error();
  if (passes_->path_tracer && request.outputs.shaded() && !trace_paths(*prepared, poses, view, hooks))
    return std::optional<BegunFrame>();
  return std::optional<BegunFrame>(BegunFrame{*prepared, frames.begin()});
}

bool SceneRenderer::shows_markers(const FrameRequest& request) const {
  return request.markers && markers_ && !markers_->empty();
}

FrameFacts SceneRenderer::facts(const FrameRequest& request) const {
  FrameFacts facts;
  facts.raster_path = settings_.raster_path();
  facts.can_write_samples = settings_.can_write_samples();
  facts.levels_of_detail = settings_.draw().levels_of_detail;
  facts.scene_has_levels = gpu_scene_->cluster_instance_count > gpu_scene_->lod0_cluster_instance_count;
  facts.has_forward_only = gpu_scene_->has_forward_only;
  facts.has_markers = shows_markers(request);
  facts.shadows_on = settings_.shadows_on();
  facts.shadow_technique = settings_.shadow_technique();
  facts.is_path_traced = traces_paths();
  facts.ray_effects = traces_ray_effects();
  facts.has_lights = passes_->shadows.has_lights();
  facts.needs_shadow_maps = passes_->shadows.needs_maps();
  facts.bloom = settings_.draw().post.bloom > 0;
  facts.metered = settings_.draw().post.metered;
  facts.depth_of_field = settings_.has_depth_of_field(limits_, request.lens);
  return facts;
}

Inspection SceneRenderer::available(Inspection inspection, const ImageOutputs& outputs) const {
  if (targets_->current()->views > 1 || !outputs.has(wire::kColorSrgb8) || !can_inspect()) return {};
  const bool loses_light = replaces_shading(inspection.debug_view) && outputs.has(wire::kColorLinearF16);
  if (loses_light || !can_show(inspection.debug_view)) inspection.debug_view = settings::DebugView::none;
  const VkExtent2D extent = targets_->current()->extent;
  if (inspection.pick && (inspection.pick->x >= extent.width || inspection.pick->y >= extent.height))
    inspection.pick.reset();
  return inspection;
}

scene::EditRevisions SceneRenderer::edit_revisions() const {
  return edits_ ? edits_->revisions() : scene::EditRevisions();
}

void SceneRenderer::submitted(uint64_t timeline_value) {
  if (passes_->inspector && passes_->inspector->picks())
    passes_->inspector->picks()->submitted(timeline_value);
}

std::vector<Picked> SceneRenderer::take_picked() {
  return passes_->inspector && passes_->inspector->picks() ? passes_->inspector->picks()->take_picked()
                                                           : std::vector<Picked>();
}

void SceneRenderer::draw_stale_overlay(gpu::Recorder& recorder, state::Condition condition) {
  passes_->stale_overlay.record(recorder, *targets_->current(), image(), condition);
}

gpu::Image& SceneRenderer::image() {
  return PostPass::result(*targets_->current(), settings_.draw().post);
}

gpu::Buffer& SceneRenderer::planes() {
  return passes_->outputs->planes();
}

const std::vector<PlaneRange>& SceneRenderer::plane_ranges() const {
  return passes_->outputs->places();
}

VkExtent2D SceneRenderer::extent() const {
  return targets_->current() ? targets_->current()->extent : VkExtent2D{};
}

RenderCounts SceneRenderer::counts() const {
  RenderCounts counts;
  if (passes_->visibility) {
    counts.clusters = passes_->visibility->drawn().clusters;
    counts.late_clusters = passes_->visibility->drawn().late_clusters;
  }
  counts.shadow_rays = passes_->shadows.rays_traced();
  counts.lights_without_shadow = passes_->shadows.lights_without_shadow();
  counts.markers = passes_->markers.selected_count();
  counts.uploaded_marker_bytes = passes_->markers.uploaded_bytes();
  counts.markers_lack_memory = passes_->markers.lacks_memory();
  return counts;
}

bool SceneRenderer::traces_shadow_rays() const {
  return passes_->shadows.traces();
}

settings::RayBackEnd SceneRenderer::ray_effect_back_end() const {
  return passes_->ray_effects ? passes_->ray_effects->back_end() : settings::RayBackEnd::none;
}

PathPass* SceneRenderer::path_tracer() const {
  return passes_->path_tracer.get();
}

}  // namespace fire3dv::passes
