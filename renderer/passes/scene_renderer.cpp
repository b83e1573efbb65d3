#include "renderer/passes/scene_renderer.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "base/plural.h"
#include "renderer/passes/frame.h"
#include "renderer/passes/frame_plan.h"
#include "renderer/passes/outputs/silhouettes.h"
#include "renderer/passes/resources/lamp_lights.h"
#include "renderer/passes/resources/scene_parts.h"
#include "renderer/passes/resources/sun_light.h"
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
      shared_(std::make_unique<SharedPasses>(device, settings)),
      still_(std::make_unique<ImagePasses>(*shared_, settings, settings_)),
      drawn_(still_.get()) {
  shared_->prepare_environment(settings);
}

SceneRenderer::~SceneRenderer() = default;

void SceneRenderer::apply(const settings::DrawSettings& settings) {
  const settings::LampSettings lamps_before = settings_.draw().lamps;
  settings_.apply(settings);
  if (motion_settings_) {
    if (const std::optional<settings::DrawSettings> reduced = settings::settings_in_motion(settings))
      motion_settings_->apply(*reduced);
  }
  if (!still_->passes.path_tracer) return;
  still_->passes.path_tracer->set(*settings_.draw().path);
  if (settings_.draw().lamps != lamps_before) still_->passes.path_tracer->drop();
}

bool SceneRenderer::reduces_motion() const {
  return !lacks_motion_memory_ && device_.report().type == gpu::DeviceType::software &&
         settings_.raster_path() == settings::RasterPath::visibility && !traces_paths() &&
         settings::settings_in_motion(settings_.draw());
}

// Images with planes are data; debug views show the passes of images at rest.
ImagePasses& SceneRenderer::passes_for(const FrameRequest& request) {
  const bool is_reduced = request.in_motion && request.views == 1 &&
                          request.outputs.bits() == wire::kColorSrgb8 &&
                          request.inspection.debug_view == settings::DebugView::none && reduces_motion();
  if (!is_reduced) return *still_;
  if (!moving_) create_motion_passes();
  return moving_ ? *moving_ : *still_;
}

// Without memory for them, images in motion are those at rest.
void SceneRenderer::create_motion_passes() {
  const settings::DrawSettings reduced = *settings::settings_in_motion(settings_.draw());
  motion_settings_.emplace(device_, reduced);
  motion_settings_->apply(reduced);
  try {
    moving_ = std::make_unique<ImagePasses>(*shared_, reduced, *motion_settings_);
    set_motion_scene();
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    drop_motion_passes();
  }
}

void SceneRenderer::set_motion_scene() {
  ScenePasses& passes = moving_->passes;
  passes.expect_scene(*motion_settings_, *scene_);
  forget_scene(*moving_);
  passes.shadows.set_scene(*scene_, *gpu_scene_);
  if (edits_)
    passes.shadows.set_lights_or_drop_shadows(drawn_lights(*scene_, edits_, added_lights(*gpu_scene_)));
}

void SceneRenderer::drop_motion_passes() {
  lacks_motion_memory_ = true;
  drawn_ = still_.get();
  moving_.reset();
}

// Passes refer to the scene by the numbers of its objects.
void SceneRenderer::forget_scene(ImagePasses& images) {
  ScenePasses& passes = images.passes;
  passes.markers.forget();
  passes.forward.invalidate();
  if (passes.outputs) passes.outputs->set_scene();
  images.targets.invalidate_ids();
}

void SceneRenderer::set_scene(const scene::Scene& scene, uint32_t worlds) {
  set_scene(scene, scene::derive(scene, levels_for(settings_.draw().levels_of_detail)), worlds);
}

void SceneRenderer::set_scene(const scene::Scene& scene, const scene::Derived& derived, uint32_t worlds) {
  FIRE3DV_ASSERT(worlds <= kMaxWorlds);
  ScenePasses& passes = still_->passes;
  passes.expect_scene(settings_, scene);
  if (worlds > 1) shared_->transforms.expect_worlds();
  SceneUses uses = passes.uses_of(settings_, scene);
  uses.worlds = worlds;
  auto gpu_scene = std::make_unique<GpuScene>(device_, scene, derived, shared_->scene_set_layout.get(),
                                              shared_->environment->textures(), uses, gpu_scene_.get());
  passes.shadows.set_scene(scene, *gpu_scene);
  // No call below fails.
  gpu_scene_ = std::move(gpu_scene);
  scene_ = &scene;
  if (passes.path_tracer) passes.path_tracer->drop();
  limits_ = {any_forward_only(scene, uses.refracts), any_lens(scene)};
  shared_->edit_uploader.reset();
  shared_->transforms.invalidate();
  shared_->deform.invalidate();
  forget_scene(*still_);
  if (!moving_) return;
  try {
    set_motion_scene();
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    drop_motion_passes();
  }
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
  // Views are stacked in one image, and one dispatch draws all of them.
  const VkPhysicalDeviceLimits& device_limits = device_.limits();
  const uint32_t most_views =
      std::min(device_limits.maxImageDimension2D / std::max(request.extent.height, 1u),
               device_limits.maxComputeWorkGroupCount[2]);
  if (request.views > 1 && request.views > most_views) {
    reason = Shortage::too_many_views;
    return Error{counted(request.views, "view") + " of " + std::to_string(request.extent.width) + " x " +
                 std::to_string(request.extent.height) +
                 " pixels do not fit one image of this device: take at most " + std::to_string(most_views) +
                 " at once"};
  }
  drawn_ = &passes_for(request);
  ScenePasses& passes = drawn_->passes;
  TargetCache& targets = drawn_->targets;
  if (request.scene == SceneUpdate::update && still_->passes.outputs)
    still_->passes.outputs->invalidate_snapshot();
  if (passes.outputs && request.has_history) {
    Result<void> has_room =
        passes.outputs->check_room_for_histories(images_of(request, *gpu_scene_), *gpu_scene_);
    if (!has_room) {
      reason = Shortage::motion_snapshots;
      return has_room.error();
    }
  }
  if (request.outputs.has(wire::kAmodal) &&
      silhouette_bytes(gpu_scene_->mesh_node_count, request.extent.width, request.extent.height) >
          kMaxSilhouetteBytes) {
    reason = Shortage::unsupported_outputs;
    return Error{"masks of " + counted(gpu_scene_->mesh_node_count, "instance") + " in an image of " +
                 std::to_string(request.extent.width) + " x " + std::to_string(request.extent.height) +
                 " take more than 256 MiB; ask for a smaller image, or leave amodal out"};
  }
  FrameRequest usable = request;
  try {
    targets.select(
        request.extent, request.views,
        [&passes](Targets& created) {
          if (created.views == 1) passes.post.bind(created);
        },
        [&passes](Targets& selected) { passes.use(selected); });
    usable.inspection = available(request.inspection, request.outputs);
    const FramePlan plan = plan_frame(facts(usable), usable.outputs, usable.inspection, usable.views);
    passes.allocate(drawn_->settings, usable, plan, *targets.current(), {*gpu_scene_, *scene_, edits_});
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
  ScenePasses& passes = drawn_->passes;
  Targets* const targets = drawn_->targets.current();
  FIRE3DV_ASSERT(prepared.number_ == prepared_ && targets && views.size() == targets->views &&
                 poses.size() == gpu_scene_->world_count);
  // Edits, transforms and deformed vertices. Edits may show other draws and lights, so the plan comes later.
  const bool draws_samples =
      gpu_scene_->has_forward_only || shows_markers(request) || settings_.draw().post.reads_samples();
  const bool is_updated = passes.path_tracer && request.refines;  // by trace_paths()
  if (request.scene == SceneUpdate::update && !is_updated) {
    if (passes.path_tracer && !shared_->traced_scene.equals(*poses[views[0].world], edit_revisions()))
      passes.path_tracer->drop();
    update_scene(recorder, staging, poses, views[0], draws_samples);
  }
  if (request.outputs.shaded() && !passes.path_tracer) light_lamps(recorder, staging, poses, views);
  const FramePlan plan = plan_frame(facts(request), request.outputs, request.inspection, request.views);
  // Markers that are new since the last image.
  if (plan.markers) {
    passes.markers.update(recorder, staging, *markers_);
    passes.markers.select(*markers_, views[0], request.extent);
  }
  // Lights and planar casters that were set since the last image.
  passes.shadows.upload_changes(recorder, staging);
  // Ray lists, early, where their clear delays no other pass.
  if (plan.shadows) passes.shadows.clear_ray_lists(recorder);
  // Acceleration structures, overlapped with rasterisation on the async compute queue where available.
  if (plan.acceleration_structures) build_acceleration_structures(recorder);
  // Generations of the targets, and the constants of each view.
  const FrameSource source{passes,  drawn_->settings, *targets, *gpu_scene_, *scene_, image(),
                           request, recorder,         staging,  poses,       views,   edits_};
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
  if (plan.tone_map || plan.linear || plan.fxaa_only) frame.post_process();
  // Planes beyond the content mask, of which the linear one has been written only now.
  if (plan.mask_planes) frame.mask_planes();
  // Unresolved pixels and outline, on the finished image.
  if (plan.inspection) frame.draw_overlays();
}

void SceneRenderer::light_lamps(gpu::Recorder& recorder, gpu::StagingRing& staging, PosesOfWorlds poses,
                                std::span<const View> views) {
  if (gpu_scene_->lamp_count == 0) return;
  std::vector<glm::vec3> centers;
  for (const View& view : views) centers.push_back(scope_center(view, *scene_, *poses[view.world]));
  place_lamps(recorder, staging, *gpu_scene_, settings_.draw().lamps, views, centers);
}

void SceneRenderer::update_scene(gpu::Recorder& recorder, gpu::StagingRing& staging, PosesOfWorlds poses,
                                 const View& view, bool draws_forward) {
  has_acceleration_structures_ = false;
  if (edits_) {
    const EditUploader::Changed changed =
        shared_->edit_uploader.upload(recorder, staging, *gpu_scene_, *scene_, *edits_);
    for (ImagePasses* const images : {still_.get(), moving_.get()}) {
      if (!images) continue;
      ShadowPass& shadows = images->passes.shadows;
      if (changed.visibility) shadows.choose_planar_casters(*scene_, *gpu_scene_);
      if (changed.lights)
        shadows.set_lights_or_drop_shadows(drawn_lights(*scene_, edits_, added_lights(*gpu_scene_)));
    }
    if (changed.vertices) shared_->deform.invalidate_vertices();
  }
  shared_->transforms.record(recorder, staging, *gpu_scene_, poses);
  place_sun(recorder, staging, *gpu_scene_, settings_.draw().environment_intensity,
            settings_.draw().environment_rotation_rad);
  // Only the raster pipeline sorts draws by winding; compute passes read it from the transforms pass.
  if (settings_.raster_path() == settings::RasterPath::forward || draws_forward)
    gpu_scene_->update_winding(recorder, staging, *scene_, view.world, *poses[view.world]);
  shared_->deform.record(recorder, staging, *gpu_scene_, poses);
}

void SceneRenderer::build_acceleration_structures(gpu::Recorder& recorder) {
  if (std::exchange(has_acceleration_structures_, true)) return;  // by an earlier image of the frame
  recorder.async_compute("tlas wait", [&] { record_acceleration_structures(recorder); });
}

void SceneRenderer::record_acceleration_structures(gpu::Recorder& recorder) {
  GpuScene& scene = *gpu_scene_;
  shared_->deform.record_levels(recorder, scene);
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
  ScenePasses& passes = drawn_->passes;
  const Targets* const targets = drawn_->targets.current();
  FIRE3DV_ASSERT(passes.path_tracer && prepared.number_ == prepared_ && targets && targets->views == 1 &&
                 gpu_scene_->world_count == 1);
  const auto globals_of = [&] {
    gpu_types::Globals of_view = passes.globals_of_all_views(settings_, *gpu_scene_, *targets, false);
    passes.write_view_globals(of_view, settings_, *gpu_scene_, view, 0);
    return of_view;
  };
  const gpu_types::Globals globals = globals_of();
  const FrameRequest& request = prepared.request();
  const bool is_same_scene =
      request.scene == SceneUpdate::reuse || shared_->traced_scene.equals(poses, edit_revisions());
  const bool goes_on = request.refines && (passes.path_tracer->has_begun(globals.width, globals.height) ||
                                           (is_same_scene && passes.path_tracer->is_current(globals, view)));
  gpu::FrameRing& ring = passes.path_tracer->submissions();
  const state::PoseState* const world = &poses;
  const std::span<const View> views(&view, 1);
  if (!goes_on) {
    if (!is_same_scene) passes.path_tracer->drop();
    gpu::Recorder& recorder = ring.begin();
    update_scene(recorder, ring.staging(), std::span(&world, 1), view, false);
    light_lamps(recorder, ring.staging(), std::span(&world, 1), views);
    passes.shadows.upload_changes(recorder, ring.staging());
    record_acceleration_structures(recorder);
    // The edits of this update may have replaced buffers.
    passes.path_tracer->begin(recorder, globals_of(), view, hooks.resume);
    (void)ring.submit();
    shared_->traced_scene.set(poses, edit_revisions());
  } else if (gpu_scene_->lamp_count > 0) {
    // Images of other cameras may have placed them since.
    gpu::Recorder& recorder = ring.begin();
    light_lamps(recorder, ring.staging(), std::span(&world, 1), views);
    (void)ring.submit();
  }
  return passes.path_tracer->trace(*gpu_scene_, hooks);
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
  if (still_->passes.path_tracer && request.outputs.shaded() && !trace_paths(*prepared, poses, view, hooks))
    return std::optional<BegunFrame>();
  return std::optional<BegunFrame>(BegunFrame{*prepared, frames.begin()});
}

bool SceneRenderer::shows_markers(const FrameRequest& request) const {
  return request.markers && markers_ && !markers_->empty();
}

FrameFacts SceneRenderer::facts(const FrameRequest& request) const {
  FrameFacts facts;
  const RendererSettings& settings = drawn_->settings;
  const ShadowPass& shadows = drawn_->passes.shadows;
  facts.raster_path = settings.raster_path();
  facts.can_write_samples = settings.can_write_samples();
  facts.levels_of_detail = settings.draw().levels_of_detail;
  facts.scene_has_levels = gpu_scene_->cluster_instance_count > gpu_scene_->lod0_cluster_instance_count;
  facts.has_forward_only = gpu_scene_->has_forward_only;
  facts.has_markers = shows_markers(request);
  facts.shadows_on = settings.shadows_on();
  facts.shadow_technique = settings.shadow_technique();
  facts.is_path_traced = traces_paths();
  facts.ray_effects = traces_ray_effects();
  facts.has_lights = shadows.has_lights();
  facts.needs_shadow_maps = shadows.needs_maps();
  facts.bloom = settings.draw().post.bloom > 0;
  facts.metered = settings.draw().post.metered;
  facts.depth_of_field = settings.has_depth_of_field(limits_, request.lens);
  facts.has_optics = settings.draw().post.optics.any();
  facts.has_mask = settings.draw().post.optics.mask_radius > 0 && !request.distorts;
  return facts;
}

Inspection SceneRenderer::available(Inspection inspection, const ImageOutputs& outputs) const {
  const Targets& targets = *drawn_->targets.current();
  if (targets.views > 1 || !outputs.has(wire::kColorSrgb8) || !can_inspect()) return {};
  const bool loses_light =
      settings::replaces_shading(inspection.debug_view) && outputs.has(wire::kColorLinearF16);
  if (loses_light || !can_show(inspection.debug_view)) inspection.debug_view = settings::DebugView::none;
  const VkExtent2D extent = targets.extent;
  if (inspection.pick && (inspection.pick->x >= extent.width || inspection.pick->y >= extent.height))
    inspection.pick.reset();
  return inspection;
}

scene::EditRevisions SceneRenderer::edit_revisions() const {
  return edits_ ? edits_->revisions() : scene::EditRevisions();
}

void SceneRenderer::submitted(uint64_t timeline_value) {
  for (ImagePasses* const images : {still_.get(), moving_.get()}) {
    if (images && images->passes.inspector && images->passes.inspector->picks())
      images->passes.inspector->picks()->submitted(timeline_value);
  }
}

std::vector<Picked> SceneRenderer::take_picked() {
  std::vector<Picked> picked;
  for (ImagePasses* const images : {still_.get(), moving_.get()}) {
    if (images && images->passes.inspector && images->passes.inspector->picks())
      std::ranges::move(images->passes.inspector->picks()->take_picked(), std::back_inserter(picked));
  }
  return picked;
}

void SceneRenderer::draw_stale_overlay(gpu::Recorder& recorder, state::Condition condition) {
  drawn_->passes.stale_overlay.record(recorder, *drawn_->targets.current(), image(), condition);
}

gpu::Image& SceneRenderer::image() {
  return PostPass::result(*drawn_->targets.current(), settings_.draw().post);
}

gpu::Buffer& SceneRenderer::planes() {
  return drawn_->passes.outputs->planes();
}

gpu::Buffer& SceneRenderer::flow() {
  return drawn_->passes.outputs->flow();
}

const std::vector<PlaneRange>& SceneRenderer::plane_ranges() const {
  return drawn_->passes.outputs->places();
}

gpu::Buffer* SceneRenderer::undeveloped_light() {
  return settings_.draw().post.optics.any() ? &drawn_->passes.sensor->light() : nullptr;
}

gpu::Image& SceneRenderer::develop(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Buffer& light,
                                   VkExtent2D extent, const View& view, const state::PoseState& poses) {
  const settings::PostSettings& post = drawn_->settings.draw().post;
  return drawn_->passes.sensor->develop(recorder, staging, light, extent,
                                        {view, poses.sim_time_ns(), post, {}, nullptr});
}

VkExtent2D SceneRenderer::extent() const {
  const Targets* const targets = drawn_->targets.current();
  return targets ? targets->extent : VkExtent2D{};
}

RenderCounts SceneRenderer::counts() const {
  const ScenePasses& passes = drawn_->passes;
  RenderCounts counts;
  if (passes.visibility) {
    counts.clusters = passes.visibility->drawn().clusters;
    counts.late_clusters = passes.visibility->drawn().late_clusters;
  }
  counts.shadow_rays = passes.shadows.rays_traced();
  counts.lights_without_shadow = passes.shadows.lights_without_shadow();
  counts.markers = passes.markers.selected_count();
  counts.uploaded_marker_bytes = passes.markers.uploaded_bytes();
  counts.markers_lack_memory = passes.markers.lacks_memory();
  return counts;
}

bool SceneRenderer::traces_shadow_rays() const {
  return still_->passes.shadows.traces();
}

settings::RayBackEnd SceneRenderer::ray_effect_back_end() const {
  return still_->passes.ray_effects ? still_->passes.ray_effects->back_end() : settings::RayBackEnd::none;
}

PathPass* SceneRenderer::path_tracer() const {
  return still_->passes.path_tracer.get();
}

}  // namespace fire3dv::passes
