#include "renderer/passes/scene_renderer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "renderer/passes/forward/forward_pass.h"
#include "renderer/passes/resources/scene_materials.h"
#include "renderer/passes/resources/scene_parts.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

RasterPath choose_path(const gpu::Device& device, RasterPath wanted) {
  return wanted != RasterPath::forward && device.report().int64_atomics ? RasterPath::visibility
                                                                        : RasterPath::forward;
}

// Largest sample count that the device supports and the settings allow.
VkSampleCountFlagBits choose_samples(const gpu::Device& device, RasterPath path, uint32_t wanted) {
  const VkSampleCountFlags possible =
      device.limits().framebufferColorSampleCounts & device.limits().framebufferDepthSampleCounts;
  if (path == RasterPath::visibility) wanted = wanted >= 4 ? 4 : 1;  // counts of the compute path
  for (uint32_t count = 16; count > 1; count /= 2) {
    if (count <= wanted && (possible & count)) return static_cast<VkSampleCountFlagBits>(count);
  }
  return VK_SAMPLE_COUNT_1_BIT;
}

bool any_soft(const std::vector<scene::PlacedLight>& lights) {
  return std::any_of(lights.begin(), lights.end(),
                     [](const scene::PlacedLight& placed) { return is_soft(placed.light); });
}

bool any_lens(const scene::Scene& scene) {
  return std::any_of(scene.cameras.begin(), scene.cameras.end(), [](const scene::Camera& camera) {
    return !camera.orthographic && !camera.lens.is_pinhole();
  });
}

// An empty rectangle adds nothing.
VkRect2D united(const VkRect2D& a, const VkRect2D& b) {
  if (a.extent.width == 0) return b;
  if (b.extent.width == 0) return a;
  const auto right = [](const VkRect2D& r) { return r.offset.x + static_cast<int32_t>(r.extent.width); };
  const auto bottom = [](const VkRect2D& r) { return r.offset.y + static_cast<int32_t>(r.extent.height); };
  const VkOffset2D low{std::min(a.offset.x, b.offset.x), std::min(a.offset.y, b.offset.y)};
  return {low,
          {static_cast<uint32_t>(std::max(right(a), right(b)) - low.x),
           static_cast<uint32_t>(std::max(bottom(a), bottom(b)) - low.y)}};
}

}  // namespace

scene::Levels levels_for(LevelsOfDetail wanted) {
  if (wanted == LevelsOfDetail::off) return scene::Levels::none;
  return wanted == LevelsOfDetail::automatic ? scene::Levels::automatic_levels : scene::Levels::all;
}

SceneRenderer::SceneRenderer(gpu::Device& device, const DrawSettings& settings)
    : device_(device),
      settings_(settings),
      environment_source_(settings.environment),
      uses_studio_(!settings.environment),
      path_(choose_path(device, settings.raster)),
      samples_(choose_samples(device, path_, settings.samples)),
      scene_set_layout_(gpu::BindlessTextures::create_layout(device, settings.max_textures)),
      layout_(gpu::create_pipeline_layout(device, std::array{scene_set_layout_.get()})),
      edit_uploader_(device),
      transforms_(device, layout_.get()),
      deform_(device, layout_.get()),
      forward_(device, layout_.get(), samples_),
      marker_pass_(device, layout_.get(), samples_),
      shadow_technique_(
          settings.path ? ShadowTechnique()  // paths trace shadows themselves
                        : choose_shadow_technique(device, settings.shadows, path_ == RasterPath::visibility)),
      // The forward path takes ray origins from a visibility buffer, where its fragment shader cannot trace
      // rays.
      visibility_(path_ == RasterPath::visibility || shadow_technique_.back_end == RayBackEnd::pipeline
                      ? std::optional<VisibilityPass>(std::in_place, device, layout_.get(),
                                                      scene_set_layout_.get(),
                                                      samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1)
                      : std::optional<VisibilityPass>()),
      outputs_(path_ == RasterPath::visibility
                   ? std::optional<OutputsPass>(std::in_place, device, layout_.get(),
                                                samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1)
                   : std::optional<OutputsPass>()),
      shadows_(device, layout_.get(), samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1, shadow_technique_),
      post_(device, samples_),
      stale_overlay_(device),
      environment_(device, settings.environment ? *settings.environment : scene::studio_environment(),
                   settings.cached_environments.get()) {
  if (settings.path) {
    settings_.post.fxaa = false;
    path_tracer_ = std::make_unique<PathPass>(
        device, layout_.get(), *settings.path,
        settings.environment ? *settings.environment : scene::studio_environment());
  }
  const bool compute = path_ == RasterPath::visibility;
  if (settings.ray_effects.on.any() && !settings.path && can_trace_ray_effects(device, compute))
    ray_effects_ = std::make_unique<RayEffectsPass>(
        device, layout_.get(), samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1, settings.ray_effects.back_end);
  refracts_ = can_refract(settings);
  settings_.environment.reset();  // the GPU copy is complete
}

// Without storage of samples, scenes with blended surfaces are drawn forward, where no light is refracted.
bool SceneRenderer::can_refract(const DrawSettings& settings) const {
  return ray_effects_ && settings.ray_effects.on.refraction && visibility_->can_write_samples();
}

void SceneRenderer::apply(const DrawSettings& settings) {
  settings_.cull = settings.cull;
  settings_.levels_of_detail = settings.levels_of_detail;
  settings_.environment_intensity = settings.environment_intensity;
  settings_.environment_rotation_rad = settings.environment_rotation_rad;
  settings_.background = settings.background;
  shadows_on_ = settings.shadows.method != ShadowMethod::off;
  settings_.ray_effects = settings.ray_effects;
  settings_.post = settings.post;
  if (!path_tracer_) return;
  settings_.post.fxaa = false;
  if (settings.path) path_tracer_->set(*settings.path);
}

bool SceneRenderer::needs_new_renderer(const DrawSettings& settings) const {
  const RasterPath path = choose_path(device_, settings.raster);
  const bool compute = path == RasterPath::visibility;
  const bool other_shadows = !path_tracer_ && settings.shadows.method != ShadowMethod::off &&
                             choose_shadow_technique(device_, settings.shadows, compute) != shadow_technique_;
  const bool other_environment = settings.environment
                                     ? uses_studio_ || environment_source_.lock() != settings.environment
                                     : !uses_studio_;
  // Without storage of samples, effects draw the whole scene forward, which set_scene() must know.
  const bool other_draws = visibility_ && !visibility_->can_write_samples() &&
                           settings.post.reads_samples() != settings_.post.reads_samples();
  const bool other_renderer = settings.path.has_value() != (path_tracer_ != nullptr);
  // Rays that hit surfaces need triangles where shadow rays may have boxes.
  const bool lacks_ray_effects = settings.ray_effects.on.any() && !path_tracer_ && !ray_effects_ &&
                                 can_trace_ray_effects(device_, compute);
  const bool other_refraction = ray_effects_ && can_refract(settings) != refracts_;
  return other_renderer || path != path_ || other_shadows || other_environment || other_draws ||
         lacks_ray_effects || other_refraction ||
         choose_samples(device_, path, settings.samples) != samples_ ||
         settings.anisotropy != settings_.anisotropy || settings.max_textures > settings_.max_textures;
}

void SceneRenderer::set_scene(const scene::Scene& scene, const scene::Derived& derived) {
  expect_shading(scene);
  if (any_masked(scene)) {
    if (visibility_) visibility_->expect_masks();
    shadows_.expect_masks();
  }
  SceneUses uses;
  uses.anisotropy = settings_.anisotropy;
  uses.rays = path_tracer_ || ray_effects_ ? gpu::Rays::many : expected_rays(scene);
  uses.path_traced = path_tracer_ != nullptr;
  uses.refracts = refracts_;
  uses.rays_to_boxes = !path_tracer_ && !ray_effects_ && gpu::traces_to_boxes(device_) &&
                       shadow_technique_.back_end != RayBackEnd::pipeline;
  // Without storage of samples, images with effects are drawn forward.
  uses.drawn_forward = path_ != RasterPath::visibility ||
                       (settings_.post.reads_samples() && !visibility_->can_write_samples());
  auto gpu_scene = std::make_unique<GpuScene>(device_, scene, derived, scene_set_layout_.get(),
                                              environment_.textures(), uses, gpu_scene_.get());
  shadows_.set_scene(scene, *gpu_scene);
  // No call below fails.
  gpu_scene_ = std::move(gpu_scene);
  scene_ = &scene;
  if (path_tracer_) path_tracer_->drop();
  marker_pass_.forget();
  may_have_forward_only_ = any_forward_only(scene, uses.refracts);
  cameras_have_lenses_ = any_lens(scene);
  edit_uploader_.reset();
  transforms_.invalidate();
  deform_.invalidate();
  forward_.invalidate();
  if (outputs_) outputs_->set_scene();
  // The new scene has other ids.
  for (const std::unique_ptr<Targets>& targets : target_cache_) targets->visibility.invalidate();
}

// Maps save most rays, except those to soft lights.
gpu::Rays SceneRenderer::expected_rays(const scene::Scene& scene) const {
  return shadow_technique_.hybrid && !any_soft(scene::lights_of(scene, nullptr)) ? gpu::Rays::few
                                                                                 : gpu::Rays::many;
}

// Starts compilation of the shading pipelines that record() will probably use, during the scene upload.
void SceneRenderer::expect_shading(const scene::Scene& scene) {
  if (path_ != RasterPath::visibility || path_tracer_) return;
  VisibilityPass::Shading shading;
  shading.ray_effects = traces_ray_effects();
  shading.core_materials = !shading.ray_effects && !any_extended(scene.materials);
  shading.textures = any_textured(scene.materials);
  shading.second_uv = any_second_uv(scene.materials);
  shading.material_flags = optional_flags(scene.materials);
  shading.writes_samples = any_forward_only(scene, refracts_) || settings_.post.reads_samples() ||
                           any_lens(scene) || !settings_.post.lens.is_pinhole();
  if (shading.writes_samples && !visibility_->can_write_samples()) return;
  // The pipeline expected last is compiled first. Shadows may be switched off at any time, but a CPU takes
  // too long to precompile that variant.
  if (!gpu::uses_cpu_variants(device_)) visibility_->expect(shading);
  shading.shadows = shadow_mode(shadow_technique_.method == ShadowMethod::ray);
  const std::vector<scene::PlacedLight> lights = scene::lights_of(scene, nullptr);
  shading.tests_maps = shadows_on_ && shadow_technique_.hybrid && !lights.empty() && !any_soft(lights);
  visibility_->expect(shading);
}

void SceneRenderer::record(const PreparedFrame& prepared, gpu::Recorder& recorder, gpu::StagingRing& staging,
                           const state::PoseState& poses, std::span<const View> views,
                           std::span<CameraHistory> histories) {
  const FrameRequest& request = prepared.request();
  FIRE3DV_ASSERT(prepared.number_ == prepared_ && targets_ && views.size() == targets_->views);
  // Edits, transforms and deformed vertices. Edits may show other draws and lights, so the plan comes later.
  const bool draws_samples =
      gpu_scene_->has_forward_only || shows_markers(request) || settings_.post.reads_samples();
  const bool is_updated = path_tracer_ && request.refines;  // by trace_paths()
  if (request.scene == SceneUpdate::update && !is_updated) {
    if (path_tracer_ && !traced_scene_.equals(poses, edit_revisions())) path_tracer_->drop();
    update_scene(recorder, staging, poses, draws_samples);
  }
  const FramePlan plan = plan_frame(facts(request), request.outputs, request.inspection, request.views);
  Frame frame{request, plan, recorder, staging, poses, views, {}};
  // Markers that are new since the last image.
  if (plan.markers) {
    marker_pass_.update(recorder, staging, *markers_);
    marker_pass_.select(*markers_, views[0], request.extent);
  }
  // Lights and planar casters that were set since the last image.
  shadows_.upload_changes(recorder, staging);
  // Ray lists, early, where their clear delays no other pass.
  if (plan.shadows) shadows_.clear_ray_lists(recorder);
  // Acceleration structures, overlapped with rasterisation on the async compute queue where available.
  if (plan.acceleration_structures) build_acceleration_structures(recorder);
  // Generations of the targets, and the constants of each view.
  begin_targets(frame);
  // Visibility buffer of the cameras, and shadow maps.
  rasterise(frame);
  // Planes derived from ids and depths.
  if (plan.surface_planes) write_planes(frame, histories);
  // Picking and debug view, before the coverage merge changes ids.
  if (plan.inspection) draw_debug_view(frame);
  // One shading sample for the triangles of one surface in a pixel.
  if (plan.coverage_merge) merge_coverage(frame);
  // Reflected light and occlusion of the visible surfaces, by rays.
  if (plan.ray_effects) trace_ray_effects(frame);
  // Shadow mask, and colours from the visibility buffer.
  if (plan.shadow_mask || plan.compute_shading) shade(frame);
  // The whole scene, or blended surfaces, lines and points.
  if (plan.forward) draw_forward(frame);
  // The lens of the camera.
  if (plan.depth_of_field) blur(frame);
  // Points, lines and shapes that streams show besides bodies.
  if (plan.markers) draw_markers(frame);
  // Colours of the path tracer.
  if (plan.path_resolve) post_process(frame);
  // Tone mapping, resolve and FXAA.
  if (plan.tone_map || plan.fxaa_only) post_process(frame);
  // Unresolved pixels and outline, on the finished image.
  if (plan.inspection) draw_overlays(frame);
}

void SceneRenderer::update_scene(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                 const state::PoseState& poses, bool draws_forward) {
  has_acceleration_structures_ = false;
  if (edits_) {
    const EditUploader::Changed changed =
        edit_uploader_.upload(recorder, staging, *gpu_scene_, *scene_, *edits_);
    if (changed.visibility) shadows_.choose_planar_casters(*scene_, *gpu_scene_);
    if (changed.lights) shadows_.set_lights_or_drop_shadows(scene::lights_of(*scene_, edits_));
    if (changed.vertices) deform_.invalidate_vertices();
  }
  transforms_.record(recorder, staging, *gpu_scene_, poses);
  // Only the raster pipeline sorts draws by winding; compute passes read it from the transforms pass.
  if (path_ == RasterPath::forward || draws_forward)
    gpu_scene_->update_winding(recorder, staging, *scene_, poses);
  deform_.record(recorder, staging, *gpu_scene_, poses);
}

void SceneRenderer::build_acceleration_structures(gpu::Recorder& recorder) {
  if (std::exchange(has_acceleration_structures_, true)) return;  // by an earlier image of the frame
  recorder.async_compute("tlas wait", [&] { record_acceleration_structures(recorder); });
}

void SceneRenderer::record_acceleration_structures(gpu::Recorder& recorder) {
  GpuScene& scene = *gpu_scene_;
  deform_.record_levels(recorder, scene);
  recorder.pass(
      "tlas",
      {Use(scene.instances, access::build_input), Use(scene.top_level.storage(), access::build_write),
       Use(scene.top_level.scratch(), access::build_write)},
      [&](VkCommandBuffer commands) {
        scene.top_level.record_build(commands, scene.instances.address, scene.instance_count);
      });
}

void SceneRenderer::begin_targets(Frame& frame) {
  const FramePlan& plan = frame.plan;
  if (plan.visibility_buffer) visibility_->begin();
  if (plan.shadow_maps) shadows_.begin_maps();
  if (outputs_)
    outputs_->begin(frame.request.outputs, *gpu_scene_, frame.request.extent, frame.request.views);
  for (const View& view : frame.views) frame.globals.push_back(upload_globals(frame, view));
  const bool is_bounded = plan.compute_shading && plan.forward;
  frame.forward_area =
      is_bounded ? forward_bounds(*gpu_scene_, *scene_, frame.poses, frame.views[0], frame.request.extent)
                 : frame.whole_area();
  if (is_bounded && plan.markers) frame.forward_area = united(frame.forward_area, marker_pass_.bounds());
  // The linear plane and effects need the samples of all pixels.
  const bool is_whole =
      plan.metering || plan.bloom || plan.depth_of_field || frame.request.outputs.has(wire::kColorLinearF16);
  frame.hdr_area = is_whole ? frame.whole_area() : frame.forward_area;
}

void SceneRenderer::rasterise(const Frame& frame) {
  const FramePlan& plan = frame.plan;
  std::vector<ClusterRaster*> sets;
  if (plan.visibility_buffer) {
    sets.push_back(&visibility_->prepare(frame.staging, *gpu_scene_, frame.views, frame.globals[0],
                                         settings_.cull, plan.camera_levels_of_detail));
  }
  if (plan.shadow_maps) {
    ClusterRaster* maps = shadows_.prepare_maps(frame.staging, *gpu_scene_, frame.globals[0], settings_.cull,
                                                plan.shadow_map_levels_of_detail);
    if (maps) sets.push_back(maps);
  }
  ClusterRaster::Clear clear = ClusterRaster::clear_of(sets);
  if (plan.shadow_maps) {
    shadows_.fit_map_views(frame.recorder, frame.staging, *gpu_scene_, frame.globals,
                           plan.shadow_map_levels_of_detail, std::move(clear));
  } else if (!sets.empty()) {
    frame.recorder.pass("clear", clear.uses, clear.commands);
  }
  if (!sets.empty()) ClusterRaster::record(frame.recorder, sets);
}

void SceneRenderer::write_planes(const Frame& frame, std::span<CameraHistory> histories) {
  outputs_->record(frame.recorder, frame.staging,
                   {*scene_, *gpu_scene_, visibility_->buffer(), frame.views, frame.globals}, histories);
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

void SceneRenderer::merge_coverage(const Frame& frame) {
  visibility_->merge_coverage(frame.recorder, *gpu_scene_, frame.globals, frame.plan.shadow_mask);
}

void SceneRenderer::trace_ray_effects(const Frame& frame) {
  // Edits may have changed the plan since prepare().
  ray_effects_->allocate(*targets_, gpu_scene_->refracts, settings_.ray_effects.on.bounce);
  const float radius_m = 0.5f * glm::length(scene_->bounds_max - scene_->bounds_min);
  ray_effects_->record(frame.recorder, {*gpu_scene_, *targets_, frame.views[0], frame.globals[0], radius_m},
                       settings_.ray_effects);
}

void SceneRenderer::shade(const Frame& frame) {
  const FramePlan& plan = frame.plan;
  gpu::Recorder& recorder = frame.recorder;
  const VkRect2D* const hdr_area = plan.hdr_samples ? &frame.hdr_area : nullptr;
  const uint32_t mode = shadow_mode(plan.shadow_mask);
  if (!plan.shadow_mask) {
    visibility_->shade(recorder, *gpu_scene_, shadows_, *targets_,
                       {0, frame.views, frame.globals, mode, plan.ray_effects}, settings_.post, hdr_area);
    return;
  }
  // In sequence, since all views share one ray list and one mask.
  for (uint32_t view = 0; view < frame.views.size(); ++view) {
    if (view > 0) shadows_.clear_ray_lists(recorder);
    const VisibilityPass::Shaded shaded{view, frame.views.subspan(view, 1),
                                        std::span(frame.globals).subspan(view, 1), mode, plan.ray_effects};
    if (plan.compute_shading && shadows_.tests_maps_while_shading()) {
      visibility_->shade_and_trace(recorder, *gpu_scene_, shadows_, *targets_, shaded, settings_.post,
                                   hdr_area);
      continue;
    }
    shadows_.record(recorder, *gpu_scene_, {visibility_->buffer(), visibility_->address_of(view)},
                    frame.globals[view]);
    if (plan.compute_shading)
      visibility_->shade(recorder, *gpu_scene_, shadows_, *targets_, shaded, settings_.post, hdr_area);
  }
}

void SceneRenderer::draw_forward(const Frame& frame) {
  if (frame.forward_area.extent.width == 0) return;  // no forward-only draw is in the image
  forward_.record(
      frame.recorder, frame.staging,
      {*gpu_scene_, *scene_, frame.poses, *targets_, frame.views[0], frame.globals[0], settings_.background,
       &shadows_, frame.plan.compute_shading ? &targets_->visibility : nullptr, frame.forward_area});
}

void SceneRenderer::post_process(const Frame& frame) {
  const FramePlan& plan = frame.plan;
  PostSettings post = settings_.post;
  post.exposure = exposure_of(frame.views[0], post);
  if (!plan.bloom) post.bloom = 0;
  if (plan.fxaa_only) {
    if (post.fxaa) frame.recorder.overlap_copies_with_next();
    post_.smooth(frame.recorder, *targets_, post);
    return;
  }
  PostPass::Linear linear;
  if (frame.request.outputs.has(wire::kColorLinearF16))
    linear = {&outputs_->planes(), outputs_->address_of(wire::kColorLinearF16)};
  gpu::Buffer* const sums = plan.path_resolve ? &path_tracer_->sums() : nullptr;
  MeteredExposure metered;
  // A camera with an exposure of its own keeps it.
  if (plan.metering && !(frame.views[0].exposure > 0))
    metered = light_meter_->record(frame.recorder, *targets_, post.exposure, sums);
  if (plan.bloom) bloom_->record(frame.recorder, *targets_, post.exposure, metered, sums);
  if (plan.path_resolve) {
    path_tracer_->resolve(frame.recorder, *targets_, post, linear, metered);
    return;
  }
  const bool is_partial =
      plan.compute_shading && visibility_->tone_maps_other_pixels(*gpu_scene_, plan.ray_effects);
  post_.record(frame.recorder, *targets_, post, linear, metered,
               is_partial ? frame.hdr_area : frame.whole_area());
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

void SceneRenderer::blur(const Frame& frame) {
  const View& view = frame.views[0];
  const scene::ThinLens& lens = lens_of(view, settings_.post.lens);
  if (view.orthographic || lens.is_pinhole()) return;
  depth_of_field_->record(frame.recorder, *targets_, circle_of_confusion(view, lens, frame.request.extent));
}

void SceneRenderer::draw_markers(const Frame& frame) {
  if (frame.forward_area.extent.width == 0) return;
  marker_pass_.record(frame.recorder, {*targets_, frame.views[0], frame.globals[0], frame.forward_area});
}

uint32_t SceneRenderer::shadow_mode(bool masked) const {
  return shadows_on_ ? shadows_.shader_mode(masked) : FIRE3DV_SHADOWS_OFF;
}

gpu_types::Globals SceneRenderer::make_globals(const View& view, bool shadow_mask) const {
  const GpuScene& scene = *gpu_scene_;
  gpu_types::Globals globals{};
  globals.world_from_node = scene.world_from_node.address;
  globals.node_facts = scene.node_facts();
  globals.first_primitive_of_node = scene.first_primitive_of_node.address;
  globals.draws = scene.draws.address;
  globals.primitives = scene.primitives.address;
  globals.materials = scene.materials.address;
  globals.material_extensions = scene.material_extensions.address;
  globals.lights = scene.lights.address;
  globals.light_poses = scene.light_poses();
  globals.positions = scene.positions.address;
  globals.frames = scene.frames.address;
  globals.tangents = scene.tangents.address;
  globals.uvs = scene.uvs.address;
  globals.extras = scene.extras.address;
  globals.indices = scene.indices.address;
  globals.parts = scene.parts.address;
  globals.clusters = scene.clusters.address;
  globals.level_groups = scene.level_groups.address;
  globals.cluster_triangles = scene.cluster_triangles.address;
  globals.ray_boxes = scene.ray_boxes.address;
  globals.ray_box_count = scene.ray_box_count;
  globals.primitive_count = static_cast<uint32_t>(scene.geometry.size());
  globals.cluster_instances = scene.cluster_instances.address;
  globals.clip_from_world = view.clip_from_world;
  globals.eye_world = view.eye_world;
  const NearWindow window = near_window(view);
  globals.near_window = glm::vec4(window.center_world, window.radius_m);
  globals.near_plane = window.plane_world;
  globals.light_count = scene.light_count;
  environment_.describe(globals, settings_.environment_intensity, settings_.environment_rotation_rad);
  globals.background = settings_.background.color;
  globals.background_zenith = settings_.background.zenith.value_or(settings_.background.color);
  if (view.ground && !view.orthographic) {
    globals.ground_height_m = view.ground->height_m;
    globals.ground_radius_m = view.ground->radius_m;
    globals.ground_center = view.ground->center_world;
  }
  globals.background_lod = settings_.background.show_environment
                               ? environment_.background_level(view, targets_->extent.height)
                               : -1;
  globals.world_from_ndc_x = view.world_from_ndc_x;
  globals.world_from_ndc_y = view.world_from_ndc_y;
  globals.world_from_ndc_origin = view.world_from_ndc_origin;
  globals.half_pixel_depth = half_pixel_depth(view, targets_->extent.height);
  globals.part_count = scene.part_count;
  shadows_.write_globals(globals);
  globals.shadows = shadow_mode(shadow_mask);
  globals.visibility_generation = targets_->visibility.generation();
  globals.width = targets_->extent.width;
  globals.height = targets_->extent.height;
  return globals;
}

VkDeviceAddress SceneRenderer::upload_globals(const Frame& frame, const View& view) const {
  const gpu_types::Globals globals = make_globals(view, frame.plan.shadow_mask);
  return frame.staging.write(std::span<const gpu_types::Globals>(&globals, 1)).address;
}

void SceneRenderer::submitted(uint64_t timeline_value) {
  if (inspector_ && inspector_->picks()) inspector_->picks()->submitted(timeline_value);
}

std::vector<Picked> SceneRenderer::take_picked() {
  return inspector_ && inspector_->picks() ? inspector_->picks()->take_picked() : std::vector<Picked>();
}

}  // namespace fire3dv::passes
