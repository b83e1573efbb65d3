#include "renderer/passes/scene_renderer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "renderer/passes/forward/forward_bounds.h"
#include "renderer/passes/resources/material_records.h"
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

// Limits of cached targets of other sizes.
constexpr VkDeviceSize kMaxCacheBytes = VkDeviceSize{256} << 20;
constexpr size_t kMostKeptSizes = 8;

bool any_soft(const std::vector<scene::PlacedLight>& lights) {
  return std::any_of(lights.begin(), lights.end(),
                     [](const scene::PlacedLight& placed) { return is_soft(placed.light); });
}

}  // namespace

scene::Levels levels_for(LevelsOfDetail wanted) {
  if (wanted == LevelsOfDetail::off) return scene::Levels::none;
  return wanted == LevelsOfDetail::automatic ? scene::Levels::automatic_levels : scene::Levels::all;
}

SceneRenderer::SceneRenderer(gpu::Device& device, const DrawSettings& settings)
    : device_(device),
      settings_(settings),
      environment_of_(settings.environment),
      own_studio_(!settings.environment),
      path_(choose_path(device, settings.raster)),
      samples_(choose_samples(device, path_, settings.samples)),
      scene_set_layout_(gpu::BindlessTextures::create_layout(device, settings.most_textures)),
      layout_(gpu::create_pipeline_layout(device, std::array{scene_set_layout_.get()})),
      edit_follower_(device),
      transforms_(device, layout_.get()),
      deform_(device, layout_.get()),
      forward_(device, layout_.get(), samples_),
      shadow_way_(choose_shadow_way(device, settings.shadows, path_ == RasterPath::visibility)),
      // The forward path takes ray origins from a visibility buffer, where its fragment shader cannot trace
      // rays.
      visibility_(path_ == RasterPath::visibility || shadow_way_.back_end == RayBackEnd::pipeline
                      ? std::optional<VisibilityPass>(std::in_place, device, layout_.get(),
                                                      scene_set_layout_.get(),
                                                      samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1)
                      : std::optional<VisibilityPass>()),
      outputs_(path_ == RasterPath::visibility
                   ? std::optional<OutputsPass>(std::in_place, device, layout_.get(),
                                                samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1)
                   : std::optional<OutputsPass>()),
      shadows_(device, layout_.get(), samples_ == VK_SAMPLE_COUNT_4_BIT ? 4 : 1, shadow_way_),
      post_(device, samples_),
      held_mark_(device),
      environment_(device, settings.environment ? *settings.environment : scene::studio_environment(),
                   settings.kept_environments.get()) {
  settings_.environment.reset();  // the GPU copy is complete
}

void SceneRenderer::apply(const DrawSettings& settings) {
  settings_.cull = settings.cull;
  settings_.levels_of_detail = settings.levels_of_detail;
  settings_.environment_intensity = settings.environment_intensity;
  settings_.environment_rotation_rad = settings.environment_rotation_rad;
  settings_.background = settings.background;
  shadows_on_ = settings.shadows.method != ShadowMethod::off;
  settings_.post = settings.post;
}

bool SceneRenderer::needs_new_renderer(const DrawSettings& settings) const {
  const RasterPath path = choose_path(device_, settings.raster);
  const bool compute = path == RasterPath::visibility;
  const bool other_shadows = settings.shadows.method != ShadowMethod::off &&
                             choose_shadow_way(device_, settings.shadows, compute) != shadow_way_;
  const bool other_surroundings =
      settings.environment ? own_studio_ || environment_of_.lock() != settings.environment : !own_studio_;
  return path != path_ || other_shadows || other_surroundings ||
         choose_samples(device_, path, settings.samples) != samples_ ||
         settings.anisotropy != settings_.anisotropy || settings.most_textures > settings_.most_textures;
}

void SceneRenderer::set_scene(const scene::Scene& scene, const scene::Derived& derived) {
  expect_shading(scene);
  if (any_masked(scene)) {
    if (visibility_) visibility_->expect_masks();
    shadows_.expect_masks();
  }
  SceneUses uses;
  uses.anisotropy = settings_.anisotropy;
  uses.rays = expected_rays(scene);
  uses.rays_to_boxes = gpu::traces_to_boxes(device_) && shadow_way_.back_end != RayBackEnd::pipeline;
  uses.drawn_forward = path_ != RasterPath::visibility;
  auto gpu_scene = std::make_unique<GpuScene>(device_, scene, derived, scene_set_layout_.get(),
                                              environment_.textures(), uses, gpu_scene_.get());
  shadows_.set_scene(scene, *gpu_scene);
  // No call below fails.
  gpu_scene_ = std::move(gpu_scene);
  scene_ = &scene;
  may_have_on_top_ = any_on_top(scene);
  edit_follower_.forget();
  transforms_.forget();
  deform_.forget();
  forward_.forget();
  if (outputs_) outputs_->set_scene();
  // the new scene has other ids
  for (const std::unique_ptr<Targets>& targets : kept_targets_) targets->visibility.forget();
}

// Maps save most rays, except those to soft lights.
gpu::Rays SceneRenderer::expected_rays(const scene::Scene& scene) const {
  return shadow_way_.hybrid && !any_soft(scene::lights_of(scene, nullptr)) ? gpu::Rays::few : gpu::Rays::many;
}

// Starts compilation of the shading pipelines that record() will probably use, during the scene upload.
void SceneRenderer::expect_shading(const scene::Scene& scene) {
  if (path_ != RasterPath::visibility) return;
  VisibilityPass::Shading shading;
  shading.core_materials = !any_extended(scene.materials);
  shading.textures = any_textured(scene.materials);
  shading.second_uv = any_second_uv(scene.materials);
  shading.leaves_samples = any_on_top(scene);
  if (shading.leaves_samples && !visibility_->can_leave_samples()) return;
  // The pipeline expected last is compiled first. Shadows may be switched off at any time, but a CPU takes
  // too long to precompile that variant.
  if (!gpu::takes_cpu_variants(device_)) visibility_->expect(shading);
  shading.shadows = number_of_shadows(shadow_way_.method == ShadowMethod::ray);
  const std::vector<scene::PlacedLight> lights = scene::lights_of(scene, nullptr);
  shading.finds_shadows = shadows_on_ && shadow_way_.hybrid && !lights.empty() && !any_soft(lights);
  visibility_->expect(shading);
}

void SceneRenderer::set_size(VkExtent2D extent, uint32_t views) {
  const bool as_it_is = targets_ && targets_->extent.width == extent.width &&
                        targets_->extent.height == extent.height && targets_->views == views;
  if (as_it_is) return;
  targets_ = nullptr;  // after an allocation failure only some passes have the new targets, so set_size()
                       // must be called again
  Targets& targets = targets_of(extent, views);
  try {
    if (visibility_) visibility_->set_targets(targets);
    shadows_.set_targets(targets);
  } catch (const gpu::VulkanFailure&) {
    // Drop partially set targets.
    if (visibility_) visibility_->forget_targets();
    shadows_.forget_targets();
    kept_targets_.erase(kept_targets_.begin());
    throw;
  }
  targets_ = &targets;
  drop_old_targets();
}

Targets& SceneRenderer::targets_of(VkExtent2D extent, uint32_t views) {
  auto& kept = kept_targets_;
  const auto known = std::find_if(kept.begin(), kept.end(), [&](const std::unique_ptr<Targets>& targets) {
    return targets->extent.width == extent.width && targets->extent.height == extent.height &&
           targets->views == views;
  });
  if (known != kept.end()) {
    std::rotate(kept.begin(), known, known + 1);
  } else {
    auto made = std::make_unique<Targets>(device_, extent, views, samples_);
    if (views == 1) post_.bind(*made);
    kept.insert(kept.begin(), std::move(made));
  }
  return *kept.front();
}

void SceneRenderer::begin_frame() {
  if (outputs_) outputs_->places_are_new();
}

void SceneRenderer::make_room(const ImageOutputs& outputs) {
  if (outputs_) outputs_->begin(outputs, *gpu_scene_, targets_->extent, targets_->views);
  if (visibility_) visibility_->make_room(*gpu_scene_, settings_.cull, shows_levels());
}

bool SceneRenderer::can_keep_places() const {
  return !outputs_ || outputs_->can_keep_places(*gpu_scene_);
}

void SceneRenderer::drop_old_targets() {
  VkDeviceSize bytes = 0;
  for (size_t i = 1; i < kept_targets_.size(); ++i) {
    bytes += bytes_of(*kept_targets_[i]);
    if (i < kMostKeptSizes && bytes <= kMaxCacheBytes) continue;
    kept_targets_.resize(i);
    return;
  }
}

Result<void> SceneRenderer::can_take(const ImageOutputs& outputs, uint32_t views) const {
  if (views > 1) {
    // Edits may show hidden nodes in the recorded frame.
    const bool alone = path_ != RasterPath::visibility || may_have_on_top_;
    if (alone || outputs.has(wire::kColorLinearF16))
      return Error{
          "several cameras at once need the visibility path, a scene without blended surfaces, lines and "
          "points, and no linear colours: take one after the other"};
  }
  if (!outputs.any_plane()) return {};
  if (path_ != RasterPath::visibility) {
    return Error{settings_.raster == RasterPath::forward
                     ? "outputs beside color come from the visibility buffer: leave --raster forward out"
                     : "outputs beside color come from the visibility buffer, for which " +
                           device_.report().name +
                           " lacks 64-bit atomics: choose another device with --device"};
  }
  if (outputs.has(wire::kColorLinearF16) && !visibility_->can_leave_samples())
    return Error{"linear colours of several samples need what " + device_.report().name +
                 " lacks (shaderStorageImageMultisample): take one sample with --samples 1"};
  return {};
}

void SceneRenderer::record_what_moves(gpu::Recorder& recorder, gpu::StagingRing& belt,
                                      const state::PoseState& poses) {
  acceleration_frame_ = false;
  begin_frame();
  // Scene edits.
  if (edits_ && edit_follower_.follow(recorder, belt, *gpu_scene_, *scene_, *edits_, shadows_))
    deform_.vertices_written();
  // Node transforms.
  transforms_.record(recorder, belt, *gpu_scene_, poses);
  // Winding of the draws.
  gpu_scene_->follow_senses(recorder, belt, *scene_, poses);
  // Deformed vertices.
  deform_.record(recorder, belt, *gpu_scene_, poses);
}

void SceneRenderer::record(gpu::Recorder& recorder, gpu::StagingRing& belt, const state::PoseState& poses,
                           std::span<const View> views, const ImageOutputs& outputs,
                           std::span<CameraHistory> histories, OfFrame of_frame, const Inspection& wanted) {
  FIRE3DV_ASSERT(views.size() == targets_->views && can_take(outputs, targets_->views).ok());
  const Inspection inspection = possible_of(wanted, outputs);
  const bool inspects = inspection.any(), replaced = replaces_shading(inspection.debug_view);
  const bool shaded = outputs.shaded() && !replaced, surfaces = outputs.any_surface_plane();
  const bool lit = shaded && shadows_on_;
  if (of_frame == OfFrame::first) record_what_moves(recorder, belt, poses);
  shadows_.upload_choices(recorder, belt);
  if (lit) shadows_.empty_lists(recorder);  // early, where it delays no other pass
  // Acceleration structures, on the async compute queue where available.
  if (lit && shadows_.traces() && !std::exchange(acceleration_frame_, true))
    recorder.aside("tlas wait", [&] { build_acceleration_structures(recorder); });
  // Visibility of the camera and shadow maps.
  const bool compute =
      path_ == RasterPath::visibility && (!gpu_scene_->has_forward_only || visibility_->can_leave_samples());
  const bool masked = lit && shadow_way_.method == ShadowMethod::ray &&
                      (compute || shadow_way_.back_end == RayBackEnd::pipeline);
  // The forward path draws LOD 0 only, and its mask must match that.
  const Sees sees{(compute && shaded) || masked || surfaces || inspects, compute && shows_levels(), lit};
  if (sees.camera) visibility_->begin();
  if (sees.lights && shadows_.needs_maps()) shadows_.begin_maps();
  std::vector<VkDeviceAddress> globals;
  for (const View& view : views) globals.push_back(upload_globals(belt, view, masked));
  if (outputs_) outputs_->begin(outputs, *gpu_scene_, targets_->extent, targets_->views);
  find_visible(recorder, belt, views, globals, sees);
  // Output planes.
  if (surfaces)
    outputs_->record(recorder, belt, {*scene_, *gpu_scene_, visibility_->buffer(), views, globals},
                     histories);
  if (inspects) inspect(recorder, belt, views[0], globals[0], inspection);
  if (shaded) {
    Shading how{compute, masked, {nullptr, 0}};
    if (outputs.has(wire::kColorLinearF16))
      how.linear = {&outputs_->planes(), outputs_->address_of(wire::kColorLinearF16)};
    if (sees.camera) visibility_->merge_surfaces(recorder, *gpu_scene_, globals, masked);
    shade(recorder, belt, poses, views, globals, how);
  }
  if (inspects) mark(recorder, belt, views[0], globals[0], inspection, masked);
}

void SceneRenderer::shade(gpu::Recorder& recorder, gpu::StagingRing& belt, const state::PoseState& poses,
                          std::span<const View> views, std::span<const VkDeviceAddress> globals,
                          const Shading& how) {
  const bool on_top = gpu_scene_->has_forward_only, leave_samples = on_top || how.linear.buffer;
  const VkRect2D whole{{0, 0}, targets_->extent};
  const VkRect2D on_top_area =
      how.compute && on_top ? forward_bounds(*gpu_scene_, *scene_, poses, views[0], targets_->extent) : whole;
  const VkRect2D left = how.linear.buffer || views.size() > 1 ? whole : on_top_area;
  // Shadows and colour: linear HDR for forward-only draws, otherwise the display image.
  if (how.compute) {
    shade_from_visibility(recorder, views, globals, how.masked, leave_samples ? &left : nullptr);
  } else if (how.masked) {
    shadows_.record(recorder, *gpu_scene_, {visibility_->buffer(), visibility_->address_of(0)}, globals[0]);
  }
  if (views.size() > 1) return;
  PostSettings post = settings_.post;
  post.exposure = exposure_of(views[0], post);
  if ((!how.compute || on_top) && on_top_area.extent.width != 0) {
    forward_.record(recorder, belt,
                    {*gpu_scene_, *scene_, poses, *targets_, views[0], globals[0], settings_.background,
                     &shadows_, how.compute ? &targets_->visibility : nullptr, on_top_area});
  }
  if (!how.compute || leave_samples) {
    post_.record(recorder, *targets_, post, how.linear,
                 how.compute && visibility_->shows_the_rest(*gpu_scene_) ? left : whole);
  } else {
    if (post.fxaa) recorder.copy_beside_next();
    post_.smooth(recorder, *targets_, post);
  }
}

void SceneRenderer::shade_from_visibility(gpu::Recorder& recorder, std::span<const View> views,
                                          std::span<const VkDeviceAddress> globals, bool masked,
                                          const VkRect2D* left) {
  const PostSettings& post = settings_.post;
  if (!masked) {
    visibility_->shade(recorder, *gpu_scene_, shadows_, *targets_,
                       {0, views, globals, number_of_shadows(masked)}, post, left);
    return;
  }
  // In sequence, since all views share one ray list and one mask.
  for (uint32_t view = 0; view < views.size(); ++view) {
    if (view > 0) shadows_.empty_lists(recorder);
    const VisibilityPass::Shaded shaded{view, views.subspan(view, 1), globals.subspan(view, 1),
                                        number_of_shadows(masked)};
    if (shadows_.found_while_shading()) {
      visibility_->shade_and_trace(recorder, *gpu_scene_, shadows_, *targets_, shaded, post, left);
      continue;
    }
    shadows_.record(recorder, *gpu_scene_, {visibility_->buffer(), visibility_->address_of(view)},
                    globals[view]);
    visibility_->shade(recorder, *gpu_scene_, shadows_, *targets_, shaded, post, left);
  }
}

uint32_t SceneRenderer::number_of_shadows(bool masked) const {
  return shadows_on_ ? shadows_.number_of_way(masked) : FIRE3DV_SHADOWS_OFF;
}

bool SceneRenderer::shows_levels() const {
  return settings_.levels_of_detail != LevelsOfDetail::off &&
         gpu_scene_->cluster_instance_count > gpu_scene_->lod0_cluster_instance_count;
}

bool SceneRenderer::levels_in_maps() const {
  return settings_.levels_of_detail == LevelsOfDetail::everywhere;
}

void SceneRenderer::find_visible(gpu::Recorder& recorder, gpu::StagingRing& belt, std::span<const View> views,
                                 std::span<const VkDeviceAddress> globals, const Sees& sees) {
  std::vector<ClusterRaster*> sets;
  if (sees.camera) {
    sets.push_back(
        &visibility_->prepare(belt, *gpu_scene_, views, globals[0], settings_.cull, sees.levels_of_detail));
  }
  const bool asks_maps = sees.lights && shadows_.needs_maps(),
             coarse = sees.levels_of_detail && levels_in_maps();
  if (asks_maps) {
    ClusterRaster* maps = shadows_.prepare_maps(belt, *gpu_scene_, globals[0], settings_.cull, coarse);
    if (maps) sets.push_back(maps);
  }
  ClusterRaster::Emptying emptying = ClusterRaster::emptying(sets);
  if (asks_maps) {
    shadows_.place_maps(recorder, belt, *gpu_scene_, globals, coarse, std::move(emptying));
  } else if (!sets.empty()) {
    recorder.pass("clear", emptying.uses, emptying.commands);
  }
  if (!sets.empty()) ClusterRaster::record(recorder, sets);
}

void SceneRenderer::build_acceleration_structures(gpu::Recorder& recorder) {
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

VkDeviceAddress SceneRenderer::upload_globals(gpu::StagingRing& belt, const View& view, bool masked) {
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
  globals.light_places = scene.light_places();
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
  globals.background_lod =
      settings_.background.surroundings ? environment_.picture_level(view, targets_->extent.height) : -1;
  globals.world_from_ndc_x = view.world_from_ndc_x;
  globals.world_from_ndc_y = view.world_from_ndc_y;
  globals.world_from_ndc_origin = view.world_from_ndc_origin;
  globals.half_pixel_depth = half_pixel_depth(view, targets_->extent.height);
  globals.part_count = scene.part_count;
  shadows_.describe_to(globals);
  globals.shadows = number_of_shadows(masked);
  globals.visibility_generation = targets_->visibility.generation();
  globals.width = targets_->extent.width;
  globals.height = targets_->extent.height;
  return belt.write(std::span<const gpu_types::Globals>(&globals, 1)).address;
}

}  // namespace fire3dv::passes
