#include "renderer/passes/frame.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>

#include "renderer/passes/resources/image_globals.h"
#include "renderer/passes/resources/scene_materials.h"
#include "renderer/passes/resources/scene_parts.h"
#include "renderer/passes/resources/sun_light.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

scene::EnvironmentImage environment_of(const settings::DrawSettings& settings) {
  return settings.environment ? *settings.environment : scene::studio_environment();
}

bool any_soft(const std::vector<scene::PlacedLight>& lights) {
  return std::any_of(lights.begin(), lights.end(),
                     [](const scene::PlacedLight& placed) { return is_soft(placed.light); });
}

// Views of one world from which on common dispatches pay.
constexpr size_t kFewestCommonViews = 4;

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

SharedPasses::SharedPasses(gpu::Device& on, const settings::DrawSettings& wanted)
    : device(on),
      scene_set_layout(gpu::BindlessTextures::create_layout(device, wanted.max_textures)),
      layout(gpu::create_pipeline_layout(device, std::array{scene_set_layout.get()})),
      edit_uploader(device),
      transforms(device, layout.get()),
      deform(device, layout.get()) {}

void SharedPasses::prepare_environment(const settings::DrawSettings& wanted) {
  const scene::EnvironmentImage image = environment_of(wanted);
  std::optional<scene::SplitEnvironment> split;
  if (wanted.environment && wanted.environment_sun) split = scene::split_sun(image);
  if (split) sun = split->sun;
  const bool without_sun = split && !wanted.path;
  environment.emplace(device, image, without_sun ? split->rest : image, wanted.cached_environments.get());
}

ScenePasses::ScenePasses(SharedPasses& borrowed, const settings::DrawSettings& wanted,
                         const RendererSettings& settings)
    : shared(borrowed),
      device(shared.device),
      forward(device, shared.layout.get(), settings.samples()),
      markers(device, shared.layout.get(), settings.samples()),
      visibility(settings.has_visibility_buffer()
                     ? std::optional<VisibilityPass>(std::in_place, device, shared.layout.get(),
                                                     shared.scene_set_layout.get(),
                                                     settings.compute_samples())
                     : std::optional<VisibilityPass>()),
      outputs(settings.raster_path() == settings::RasterPath::visibility
                  ? std::optional<OutputsPass>(std::in_place, device, shared.layout.get(),
                                               settings.compute_samples())
                  : std::optional<OutputsPass>()),
      shadows(device, shared.layout.get(), settings.compute_samples(), settings.shadow_technique()),
      post(device, settings.samples()),
      stale_overlay(device) {
  if (wanted.path)
    path_tracer =
        std::make_unique<PathPass>(device, shared.layout.get(), *wanted.path, environment_of(wanted));
  if (settings.has_ray_effects())
    ray_effects = std::make_unique<RayEffectsPass>(device, shared.layout.get(), settings.compute_samples(),
                                                   wanted.ray_effects.back_end);
}

ImagePasses::ImagePasses(SharedPasses& shared, const settings::DrawSettings& wanted,
                         const RendererSettings& of_images)
    : settings(of_images), passes(shared, wanted, settings), targets(shared.device, settings.samples()) {}

void ScenePasses::expect_scene(const RendererSettings& settings, const scene::Scene& scene) {
  expect_shading(settings, scene);
  if (!any_masked(scene)) return;
  if (visibility) visibility->expect_masks();
  shadows.expect_masks();
}

void ScenePasses::expect_shading(const RendererSettings& settings, const scene::Scene& scene) {
  if (settings.raster_path() != settings::RasterPath::visibility || path_tracer) return;
  const settings::PostSettings& post_settings = settings.draw().post;
  const ShadowTechnique& technique = settings.shadow_technique();
  VisibilityPass::Shading shading;
  shading.ray_effects = settings.traces_ray_effects(settings.refracts() && any_transmissive(scene));
  shading.core_materials = !shading.ray_effects && !any_extended(scene.materials);
  shading.textures = any_textured(scene.materials);
  shading.second_uv = any_second_uv(scene.materials);
  shading.material_flags = optional_flags(scene.materials);
  shading.writes_samples = any_forward_only(scene, settings.refracts()) || post_settings.reads_samples() ||
                           any_lens(scene) || !post_settings.lens.is_pinhole();
  if (shading.writes_samples && !visibility->can_write_samples()) return;
  // The pipeline expected last is compiled first. Shadows may be switched off at any time, but a CPU takes
  // too long to precompile that variant.
  if (!gpu::uses_cpu_variants(device)) visibility->expect(shading);
  shading.shadows = shadow_mode(settings, technique.method == settings::ShadowMethod::ray);
  const std::vector<scene::PlacedLight> lights =
      drawn_lights(scene, nullptr, {settings.draw().lamps.count, shared.sun});
  shading.tests_maps = settings.shadows_on() && technique.hybrid && !lights.empty() && !any_soft(lights);
  visibility->expect(shading);
}

SceneUses ScenePasses::uses_of(const RendererSettings& settings, const scene::Scene& scene) const {
  const ShadowTechnique& technique = settings.shadow_technique();
  const bool hits_surfaces = path_tracer || ray_effects;
  // Maps save most rays, except those to soft lights.
  const bool has_few_rays =
      !hits_surfaces && technique.hybrid &&
      !any_soft(drawn_lights(scene, nullptr, {settings.draw().lamps.count, shared.sun}));
  SceneUses uses;
  uses.sun = shared.sun;
  uses.lamps = settings.draw().lamps.count;
  uses.anisotropy = settings.draw().anisotropy;
  uses.rays = has_few_rays ? gpu::Rays::few : gpu::Rays::many;
  uses.path_traced = path_tracer != nullptr;
  uses.refracts = settings.refracts();
  uses.rays_to_boxes =
      !hits_surfaces && gpu::traces_to_boxes(device) && technique.back_end != settings::RayBackEnd::pipeline;
  // Without storage of samples, images with effects are drawn forward.
  uses.drawn_forward = settings.raster_path() != settings::RasterPath::visibility ||
                       (settings.draw().post.reads_samples() && !visibility->can_write_samples());
  return uses;
}

bool may_have_common_dispatches(const FrameRequest& request, const GpuScene& scene) {
  return request.views >= kFewestCommonViews || (request.views > 1 && scene.world_count > 1);
}

OutputsPass::Images images_of(const FrameRequest& request, const GpuScene& scene) {
  return {request.outputs,
          request.extent,
          request.views,
          request.has_history,
          request.flow_from != nullptr,
          request.keeps_surfaces,
          request.replaced,
          may_have_common_dispatches(request, scene)};
}

void ScenePasses::use(Targets& targets) {
  try {
    if (visibility) visibility->set_targets(targets);
    shadows.set_targets(targets);
  } catch (const gpu::VulkanFailure&) {
    if (visibility) visibility->reset_targets();
    shadows.reset_targets();
    throw;
  }
}

void ScenePasses::allocate(const RendererSettings& settings, const FrameRequest& request,
                           const FramePlan& plan, Targets& targets, const AllocatedScene& scene) {
  GpuScene& gpu_scene = scene.gpu_scene;
  if (outputs)
    outputs->begin(images_of(request, gpu_scene),
                   {scene.scene, gpu_scene, settings.draw().label_alpha, scene.edits});
  if (may_have_common_dispatches(request, gpu_scene)) expect_common(settings, plan, gpu_scene);
  if (plan.visibility_buffer) visibility->allocate(gpu_scene, settings.draw().cull, plan.camera_levels);
  if (plan.ray_effects)
    ray_effects->allocate(targets, gpu_scene.refracts, settings.draw().ray_effects.on.bounce);
  if (path_tracer && request.outputs.shaded())
    path_tracer->allocate(uint64_t{request.extent.width} * request.extent.height,
                          request.shows_previous_image);
  if (plan.fxaa_only && settings.draw().post.fxaa && targets.views > 1) post.bind_layers(device, targets);
  if (plan.forward && any_blended(gpu_scene.draw_list)) allocate_layers(settings, request.extent);
  if (plan.depth_of_field) {
    if (!depth_of_field) depth_of_field = std::make_unique<DepthOfFieldPass>(device, settings.samples());
    depth_of_field->allocate(targets);
  }
  if (plan.metering) {
    if (!light_meter)
      light_meter = std::make_unique<LightMeterPass>(device, settings.samples(), path_tracer != nullptr);
    light_meter->bind(targets);
  }
  if (plan.bloom) {
    if (!bloom) bloom = std::make_unique<BloomPass>(device, settings.samples(), path_tracer != nullptr);
    if (bloom->allocate(targets)) {
      if (path_tracer) {
        path_tracer->bind_bloom(targets);
      } else {
        post.bind_bloom(device, targets);
      }
    }
  }
  if (plan.sensor) {
    if (!sensor) sensor = std::make_unique<SensorPass>(device, settings.samples(), path_tracer != nullptr);
    settings::PostSettings post_settings = settings.draw().post;
    if (!plan.bloom) post_settings.bloom = 0;
    sensor->allocate(targets, nullptr, post_settings);
  }
  if (plan.mask_planes && !mask_planes) mask_planes = std::make_unique<MaskPlanesPass>(device);
}

void ScenePasses::expect_common(const RendererSettings& settings, const FramePlan& plan,
                                const GpuScene& gpu_scene) {
  if (plan.shadow_maps && gpu_scene.world_count > 1) shadows.expect_worlds(gpu_scene.has_masked);
  // With a mask, views are shaded one after the other.
  if (plan.visibility_buffer)
    visibility->expect_common(gpu_scene, plan.compute_shading && !plan.shadow_mask,
                              shadow_mode(settings, false), plan.coverage_merge, plan.shadow_mask);
}

void ScenePasses::allocate_layers(const RendererSettings& settings, VkExtent2D extent) {
  if (!LayerPass::is_supported(device)) return;
  if (!layers) layers = std::make_unique<LayerPass>(device, shared.layout.get(), settings.samples());
  layers->allocate(extent);
}

uint32_t ScenePasses::shadow_mode(const RendererSettings& settings, bool masked) const {
  return settings.shadows_on() ? shadows.shader_mode(masked) : FIRE3DV_SHADOWS_OFF;
}

gpu_types::Globals ScenePasses::globals_of_all_views(const RendererSettings& settings, const GpuScene& scene,
                                                     const Targets& targets, bool shadow_mask) const {
  const settings::DrawSettings& draw = settings.draw();
  gpu_types::Globals globals{};
  scene.write_globals(globals);
  shared.environment->describe(globals, draw.environment_intensity, draw.environment_rotation_rad);
  globals.environment_sun = FIRE3DV_NO_INDEX;
  if (scene.sun && draw.environment_intensity > 0) {
    if (path_tracer) globals.environment_sun = --globals.light_count;
  } else if (scene.sun) {
    --globals.light_count;
  }
  globals.background = draw.background.color;
  globals.background_zenith = draw.background.zenith.value_or(draw.background.color);
  const bool has_sky = draw.background.show_sky && scene.sky;
  globals.sky_texture = has_sky ? scene.sky->texture : FIRE3DV_NO_INDEX;
  shadows.write_globals(globals);
  globals.shadows = shadow_mode(settings, shadow_mask);
  globals.visibility_generation = targets.visibility.generation();
  globals.width = targets.extent.width;
  globals.height = targets.extent.height;
  return globals;
}

void ScenePasses::write_view_globals(gpu_types::Globals& globals, const RendererSettings& settings,
                                     const GpuScene& scene, const View& view, uint32_t map_set) const {
  const settings::DrawSettings& draw = settings.draw();
  const uint32_t height = globals.height;
  scene.write_world_globals(globals, view.world);
  shadows.write_map_globals(globals, map_set);
  globals.clip_from_world = view.clip_from_world;
  globals.eye_world = view.eye_world;
  const NearWindow window = near_window(view);
  globals.near_window = glm::vec4(window.center_world, window.radius_m);
  globals.near_plane = window.plane_world;
  if (view.ground && !view.orthographic) {
    globals.ground_height_m = view.ground->height_m;
    globals.ground_radius_m = view.ground->radius_m;
    globals.ground_center = view.ground->center_world;
  }
  globals.background_lod =
      draw.background.show_environment ? shared.environment->background_level(view, height) : -1;
  if (globals.sky_texture != FIRE3DV_NO_INDEX)
    globals.sky_lod = equirectangular_level(view, height, scene.sky->image_height_px);
  globals.world_from_ndc_x = view.world_from_ndc_x;
  globals.world_from_ndc_y = view.world_from_ndc_y;
  globals.world_from_ndc_origin = view.world_from_ndc_origin;
  globals.half_pixel_depth = half_pixel_depth(view, height);
}

Frame::Frame(const FrameSource& source, const FramePlan& plan)
    : source_(source), plan_(plan), passes_(source.passes), recorder_(source.recorder) {
  const FrameRequest& request = source.request;
  find_map_sets();
  if (plan.visibility_buffer) passes_.visibility->begin();
  if (plan.shadow_maps) passes_.shadows.begin_maps(map_sets_.count);
  if (passes_.outputs)
    passes_.outputs->begin(
        images_of(request, source.gpu_scene),
        {source.scene, source.gpu_scene, source.settings.draw().label_alpha, source.edits});
  upload_globals();
  const bool is_bounded = plan.compute_shading && plan.forward;
  forward_area_ = is_bounded
                      ? forward_bounds(source.gpu_scene, source.scene, source.poses_of(source.views[0]),
                                       source.views[0], request.extent)
                      : whole_area();
  if (is_bounded && plan.markers) forward_area_ = united(forward_area_, passes_.markers.bounds());
  if (!plan.tone_map) return;  // shading tone-maps all pixels
  // Effects need the samples of all pixels.
  const bool has_effects = plan.metering || plan.bloom || plan.depth_of_field || plan.sensor;
  const bool is_partial = is_bounded && !has_effects &&
                          passes_.visibility->tone_maps_other_pixels(source.gpu_scene, plan.ray_effects);
  hdr_area_ = is_partial ? forward_area_ : whole_area();
}

bool Frame::has_common_dispatches() const {
  return map_sets_.count > 1 || source_.views.size() >= kFewestCommonViews;
}

void Frame::find_map_sets() {
  constexpr uint32_t kNoSet = UINT32_MAX;
  std::vector<uint32_t> set_of_world(source_.gpu_scene.world_count, kNoSet);
  map_set_of_.reserve(source_.views.size());
  for (const View& view : source_.views) {
    uint32_t& set = set_of_world[view.world];
    if (set == kNoSet) set = map_sets_.count++;
    map_set_of_.push_back(set);
  }
}

// Thousands of views are written for each frame: in one piece, and what they have in common is found once.
void Frame::upload_globals() {
  constexpr VkDeviceSize kStride = (sizeof(ImageGlobals) + 255) / 256 * 256;
  const gpu::StagingRing::Piece piece = source_.staging.allocate(kStride * source_.views.size());
  const ImageGlobals all{
      passes_.globals_of_all_views(source_.settings, source_.gpu_scene, source_.targets, plan_.shadow_mask)};
  globals_.reserve(source_.views.size());
  for (size_t v = 0; v < source_.views.size(); ++v) {
    ImageGlobals image = all;
    passes_.write_view_globals(image.globals, source_.settings, source_.gpu_scene, source_.views[v],
                               map_set_of_[v]);
    std::byte* const mapped = piece.mapped + v * kStride;
    std::memcpy(mapped, &image, sizeof(image));
    globals_.push_back(piece.address + v * kStride);
    source_.staging.add_end_word(reinterpret_cast<uint64_t*>(mapped + offsetof(ImageGlobals, ends_early)));
  }
  map_sets_.set_cameras(map_set_of_, globals_);
}

InspectedView Frame::inspected_view() const {
  return {source_.scene,    source_.gpu_scene, source_.targets.visibility.buffer,
          source_.views[0], globals_[0],       source_.targets.extent};
}

void Frame::rasterise() {
  std::vector<ClusterRaster*> sets;
  if (plan_.visibility_buffer) {
    sets.push_back(&passes_.visibility->prepare(source_.staging, source_.gpu_scene, source_.views, globals_,
                                                has_common_dispatches(), source_.settings.draw().cull,
                                                plan_.camera_levels));
  }
  if (plan_.shadow_maps) {
    ClusterRaster* maps =
        passes_.shadows.prepare_maps(source_.staging, source_.gpu_scene, map_sets_,
                                     source_.settings.draw().cull, plan_.shadow_map_levels_of_detail);
    if (maps) sets.push_back(maps);
  }
  ClusterRaster::Clear clear = ClusterRaster::clear_of(sets);
  if (plan_.shadow_maps) {
    passes_.shadows.fit_map_views(recorder_, source_.staging, source_.gpu_scene, map_sets_,
                                  plan_.shadow_map_levels_of_detail, std::move(clear));
  } else if (!sets.empty()) {
    recorder_.pass("clear", clear.uses, clear.commands);
  }
  if (!sets.empty()) ClusterRaster::record(recorder_, sets);
}

void Frame::write_planes(std::span<CameraHistory> histories) {
  passes_.outputs->record(
      recorder_, source_.staging,
      {source_.scene, source_.gpu_scene, passes_.visibility->buffer(), source_.views, globals_,
       source_.settings.draw().label_alpha, source_.edits, source_.request.flow_from.get(),
       source_.request.keeps_surfaces, has_common_dispatches()},
      histories);
}

void Frame::mask_planes() {
  passes_.mask_planes->record(recorder_, passes_.outputs->planes(), passes_.outputs->places(),
                              source_.request.extent, source_.settings.draw().post.optics);
}

void Frame::draw_debug_view() {
  const Inspection& inspection = source_.request.inspection;
  if (!passes_.inspector)
    passes_.inspector = std::make_unique<Inspector>(passes_.device, passes_.shared.layout.get(),
                                                    passes_.shared.scene_set_layout.get(),
                                                    source_.settings.compute_samples());
  passes_.inspector->draw_on(source_.targets, source_.image);
  const InspectedView view = inspected_view();
  if (inspection.pick) passes_.inspector->pick(recorder_, view, *inspection.pick);
  if (!settings::replaces_shading(inspection.debug_view)) return;
  passes_.inspector->debug_views().show(recorder_, source_.staging, view, inspection.debug_view,
                                        {source_.settings.draw().cull, plan_.camera_levels}, source_.image);
}

void Frame::merge_coverage() {
  passes_.visibility->merge_coverage(recorder_, source_.gpu_scene, globals_, plan_.shadow_mask, common());
}

void Frame::trace_ray_effects() {
  // Edits may have changed the plan since prepare().
  passes_.ray_effects->allocate(source_.targets, source_.gpu_scene.refracts,
                                source_.settings.draw().ray_effects.on.bounce);
  const float radius_m = 0.5f * glm::length(source_.scene.bounds_max - source_.scene.bounds_min);
  passes_.ray_effects->record(recorder_,
                              {source_.gpu_scene, source_.targets, source_.views[0], globals_[0], radius_m},
                              source_.settings.draw().ray_effects);
}

void Frame::shade() {
  const VisibilityPass::Samples samples{plan_.hdr_samples, hdr_area_, plan_.linear};
  const uint32_t mode = passes_.shadow_mode(source_.settings, plan_.shadow_mask);
  if (!plan_.shadow_mask) {
    passes_.visibility->shade(recorder_, source_.gpu_scene, passes_.shadows, source_.targets,
                              {0, source_.views, globals_, mode, plan_.ray_effects, common()},
                              source_.settings.draw().post, samples);
    return;
  }
  // In sequence, since all views share one ray list and one mask.
  for (uint32_t view = 0; view < source_.views.size(); ++view) {
    if (view > 0) passes_.shadows.clear_ray_lists(recorder_);
    const VisibilityPass::Shaded shaded{view, source_.views.subspan(view, 1),
                                        std::span(globals_).subspan(view, 1), mode, plan_.ray_effects};
    if (plan_.compute_shading && passes_.shadows.tests_maps_while_shading()) {
      passes_.visibility->shade_and_trace(recorder_, source_.gpu_scene, passes_.shadows, source_.targets,
                                          shaded, source_.settings.draw().post, samples);
      continue;
    }
    passes_.shadows.record(recorder_, source_.gpu_scene,
                           {passes_.visibility->buffer(), passes_.visibility->address_of(view)},
                           globals_[view]);
    if (plan_.compute_shading)
      passes_.visibility->shade(recorder_, source_.gpu_scene, passes_.shadows, source_.targets, shaded,
                                source_.settings.draw().post, samples);
  }
}

void Frame::draw_forward() {
  if (forward_area_.extent.width == 0) return;  // no forward-only draw is in the image
  const bool is_blended = any_blended(source_.gpu_scene.draw_list);
  const bool in_layers = layers_for(is_blended || (sorts_markers() && passes_.markers.has_blended()));
  const ForwardPass::Frame frame{source_.gpu_scene,
                                 source_.scene,
                                 source_.poses_of(source_.views[0]),
                                 source_.targets,
                                 source_.views[0],
                                 globals_[0],
                                 source_.settings.draw().background,
                                 &passes_.shadows,
                                 plan_.compute_shading ? &source_.targets.visibility : nullptr,
                                 forward_area_,
                                 in_layers};
  passes_.forward.record(recorder_, source_.staging, frame);
  if (!in_layers) return;
  const MarkerPass::Frame markers = marker_frame();
  std::vector<LayerDraws> draws;
  if (is_blended) draws.push_back(passes_.forward.layer_draws(frame));
  if (sorts_markers()) {
    passes_.markers.record(recorder_, markers, {MarkerPass::Layer::opaque});
    if (passes_.markers.has_blended()) draws.push_back(passes_.markers.layer_draws(markers));
    has_sorted_markers_ = true;
  }
  passes_.layers->record(recorder_, source_.staging, source_.targets, forward_area_, draws);
}

bool Frame::layers_for(bool is_blended) {
  // Edits may have changed the plan since prepare().
  if (is_blended) passes_.allocate_layers(source_.settings, source_.request.extent);
  return is_blended && passes_.layers;
}

void Frame::post_process() {
  settings::PostSettings post = source_.settings.draw().post;
  post.exposure = exposure_of(source_.views[0], post);
  if (!plan_.bloom) post.bloom = 0;
  if (plan_.fxaa_only) {
    if (post.fxaa) recorder_.overlap_copies_with_next();
    passes_.post.smooth(recorder_, source_.targets, post);
    return;
  }
  PostPass::Linear linear;
  if (source_.request.outputs.has(wire::kColorLinearF16))
    linear = {&passes_.outputs->planes(), passes_.outputs->address_of(wire::kColorLinearF16)};
  gpu::Buffer* const sums = plan_.path_resolve ? &passes_.path_tracer->sums() : nullptr;
  MeteredExposure metered;
  // A camera with an exposure of its own keeps it.
  if (plan_.metering && !(source_.views[0].exposure > 0))
    metered = passes_.light_meter->record(recorder_, source_.targets, post.exposure, sums);
  if (plan_.bloom) passes_.bloom->record(recorder_, source_.targets, post.exposure, metered, sums);
  if (plan_.path_resolve && (!plan_.sensor || linear.buffer))
    passes_.path_tracer->resolve(recorder_, source_.targets, post, linear, metered);
  if (plan_.sensor) {
    if (!plan_.path_resolve && linear.buffer)
      passes_.post.record(recorder_, source_.targets, post, linear, metered, {});
    const View& view = source_.views[0];
    const SensorPass::Source light{view, source_.poses_of(view).sim_time_ns(), post, metered, sums};
    passes_.sensor->record_light(recorder_, source_.staging, source_.targets, light);
    if (!source_.request.distorts)
      passes_.sensor->develop(recorder_, source_.staging, source_.targets, light);
    return;
  }
  if (plan_.path_resolve) return;
  passes_.post.record(recorder_, source_.targets, post, linear, metered, hdr_area_);
}

void Frame::draw_overlays() {
  const Inspection& inspection = source_.request.inspection;
  const InspectedView view = inspected_view();
  if (inspection.debug_view == settings::DebugView::unresolved_shadows)
    passes_.inspector->debug_views().mark_unresolved(recorder_, view, passes_.shadows, plan_.shadow_mask,
                                                     source_.image);
  if (inspection.selected != scene::kNone)
    passes_.inspector->outline(recorder_, source_.staging, view, inspection.selected, source_.image);
}

void Frame::blur() {
  const View& view = source_.views[0];
  const scene::ThinLens& lens = lens_of(view, source_.settings.draw().post.lens);
  if (view.orthographic || lens.is_pinhole()) return;
  passes_.depth_of_field->record(recorder_, source_.targets, globals_[0],
                                 circle_of_confusion(view, lens, source_.request.extent));
}

MarkerPass::Frame Frame::marker_frame() const {
  return {source_.targets, source_.views[0], globals_[0], forward_area_, source_.staging.has_limit()};
}

void Frame::draw_markers() {
  if (forward_area_.extent.width == 0) return;
  using Layer = MarkerPass::Layer;
  const MarkerPass::Frame frame = marker_frame();
  if (has_sorted_markers_) return passes_.markers.record(recorder_, frame, {Layer::overlaid});
  if (!layers_for(passes_.markers.has_blended()))
    return passes_.markers.record(recorder_, frame, {Layer::opaque, Layer::blended, Layer::overlaid});
  passes_.markers.record(recorder_, frame, {Layer::opaque});
  const LayerDraws draws = passes_.markers.layer_draws(frame);
  passes_.layers->record(recorder_, source_.staging, source_.targets, forward_area_, std::span(&draws, 1));
  passes_.markers.record(recorder_, frame, {Layer::overlaid});
}

}  // namespace fire3dv::passes
