// Renderer of a scene in the current pose state, from one or several views. It owns the passes and records
// them in frame order.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/debug/inspector.h"
#include "renderer/passes/environment/environment.h"
#include "renderer/passes/forward/forward_pass.h"
#include "renderer/passes/frame_plan.h"
#include "renderer/passes/markers/marker_pass.h"
#include "renderer/passes/outputs/outputs_pass.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/path/traced_scene.h"
#include "renderer/passes/post/bloom_pass.h"
#include "renderer/passes/post/depth_of_field_pass.h"
#include "renderer/passes/post/light_meter_pass.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/ray_effects/ray_effects_pass.h"
#include "renderer/passes/resources/edit_uploader.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/pose_passes.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view/view.h"
#include "renderer/passes/visibility/visibility_pass.h"

namespace fire3dv::passes {

// LODs that a scene needs for this setting.
scene::Levels levels_for(LevelsOfDetail wanted);

// Scene state of an image. Later images of a frame reuse its edits, transforms and deformation.
enum class SceneUpdate : uint8_t { update, reuse };

struct DrawSettings {
  RasterPath raster = RasterPath::automatic;
  Cull cull = Cull::automatic;
  LevelsOfDetail levels_of_detail = LevelsOfDetail::automatic;
  float anisotropy = 1;  // off, so that images are identical on all devices
  uint32_t samples = 4;
  ShadowSettings shadows;
  std::shared_ptr<const scene::EnvironmentImage> environment;  // null: the studio environment
  std::shared_ptr<EnvironmentStore> cached_environments;       // cache; null: maps are prepared at each start
  float environment_intensity = 1;
  float environment_rotation_rad = 0;  // about +Y, counter-clockwise seen from above
  Background background;
  PostSettings post;
  RayEffectSettings ray_effects;  // of raster images, on devices that trace rays; see can_trace_ray_effects()
  std::optional<PathSettings> path;  // colours by path tracing; the device must support it. nullopt: raster
  uint32_t max_textures = 1 << 16;   // texture capacity of a scene; larger values slow down every start
};

// Image that a caller wants to record.
struct FrameRequest {
  VkExtent2D extent{};  // of a view
  // Views that are taken together. Image and planes stack them vertically, in order. Several views have no
  // FXAA and share one set of shadow maps.
  uint32_t views = 1;
  ImageOutputs outputs = {};
  Inspection inspection = {};  // for a single view with colours; unavailable parts are ignored
  SceneUpdate scene = SceneUpdate::update;
  bool markers = false;  // shows those of set_markers(); images of several views have none
  // The view has a lens, which may be new since set_scene(). begin_next() sees it by itself; images of
  // several views have none.
  bool lens = false;
  // Paths: trace_paths() goes on with the last such image while it stays the same; see there.
  bool refines = false;
  bool keeps_last = false;  // with refines: the image before it is shown until the first sample is whole
};

// Resource that prepare() could not provide.
enum class Shortage : uint8_t {
  none,
  unsupported_outputs,
  motion_snapshots,  // camera histories reference too many transform snapshots
  device_memory,
};

// Request with its resources. Valid for one record(), before the next prepare() or set_scene().
class PreparedFrame {
 public:
  const FrameRequest& request() const { return request_; }

 private:
  friend class SceneRenderer;
  PreparedFrame(FrameRequest request, uint64_t number) : request_(std::move(request)), number_(number) {}
  FrameRequest request_;
  uint64_t number_;
};

class SceneRenderer {
 public:
  SceneRenderer(gpu::Device& device, const DrawSettings& settings);

  // The scene must respect max_textures and outlive its use here. Repeated calls are allowed: the old
  // scene's resources retire. Throws VulkanFailure when memory is short; the earlier scene then stays in use.
  void set_scene(const scene::Scene& scene) {
    set_scene(scene, scene::derive(scene, levels_for(settings_.levels_of_detail)));
  }
  void set_scene(const scene::Scene& scene, const scene::Derived& derived);
  // Edits of the current scene, read in each frame. Call it once, before the first frame.
  void set_edits(const scene::SceneEdits& edits) { edits_ = &edits; }
  // Markers of later images that request them. They are read by prepare() and record().
  void set_markers(const std::vector<state::ShownMarker>& markers) { markers_ = &markers; }
  // Selects targets of the requested size and allocates most of the memory that record() needs: targets,
  // planes, motion snapshots, cluster lists. Targets of a few small sizes are cached. The error names what is
  // short; then no image can be recorded before another prepare(). Needs a scene.
  Result<PreparedFrame> prepare(const FrameRequest& request, Shortage* shortage = nullptr);

  // Returns an error for outputs that are unavailable, or unavailable for several views.
  Result<void> can_take(const ImageOutputs& outputs, uint32_t views = 1) const;

  // Returns an error if this debug view, or outlines and picks, are unavailable.
  Result<void> can_show(DebugView view) const;
  Result<void> can_inspect() const;
  // Lens of the settings, of the raster or of paths; a pinhole: none.
  const scene::ThinLens& lens_of_settings() const;
  // Returns an error if images of cameras with a lens would be those of pinholes.
  Result<void> can_blur() const;

  // Records the passes. Requested colours are in image(), planes in planes(), ready to be read. views: as
  // many as requested. histories: one per view, for motion, or none.
  void record(const PreparedFrame& frame, gpu::Recorder& recorder, gpu::StagingRing& staging,
              const state::PoseState& poses, std::span<const View> views,
              std::span<CameraHistory> histories = {});
  // The same for one view.
  void record(const PreparedFrame& frame, gpu::Recorder& recorder, gpu::StagingRing& staging,
              const state::PoseState& poses, const View& view, CameraHistory* history = nullptr) {
    record(frame, recorder, staging, poses, std::span(&view, 1), std::span(history, history ? 1 : 0));
  }
  // Traces the paths of an image, in submissions of its own. With DrawSettings::path, record() of the same
  // frame and view follows and resolves them. Returns false if should_stop ended it; then nothing may be
  // recorded. A frame that refines adds samples to the last such image. If scene, view or settings have
  // changed, the image starts again, but not before its first sample is whole; until then record() shows the
  // image before it.
  bool trace_paths(const PreparedFrame& frame, const state::PoseState& poses, const View& view,
                   const PathPass::Hooks& hooks = {});
  bool traces_paths() const { return path_tracer_ != nullptr; }
  // Null: raster.
  const PathPass* path_tracer() const { return path_tracer_.get(); }
  // prepare(), trace_paths() if the settings trace the requested colours, and FrameRing::begin(). record()
  // follows. nullopt: should_stop ended the tracing.
  struct BegunFrame {
    PreparedFrame prepared;
    gpu::Recorder& recorder;
  };
  Result<std::optional<BegunFrame>> begin_next(gpu::FrameRing& frames, const FrameRequest& request,
                                               const state::PoseState& poses, const View& view,
                                               const PathPass::Hooks& hooks = {});

  // Reports the submission of the last recorded frame; its picks arrive after that timeline value.
  void submitted(uint64_t timeline_value);
  // Returns new picking results; see Inspection::pick.
  std::vector<Picked> take_picked();

  // Draws the stale overlay after record(), unless the condition is live.
  void draw_stale_overlay(gpu::Recorder& recorder, state::Condition condition) {
    stale_overlay_.record(recorder, *targets_, image(), condition);
  }

  gpu::Image& image() {
    return targets_->views > 1 ? targets_->display : PostPass::result(*targets_, settings_.post);
  }
  gpu::Buffer& planes() { return outputs_->planes(); }
  const std::vector<PlaneRange>& plane_ranges() const { return outputs_->places(); }
  VkExtent2D extent() const { return targets_ ? targets_->extent : VkExtent2D{}; }  // 0: nothing is prepared
  uint32_t views() const { return targets_ ? targets_->views : 1; }
  const GpuScene& gpu_scene() const { return *gpu_scene_; }
  VkSampleCountFlagBits samples() const { return samples_; }
  const ShadowTechnique& shadow_technique() const { return shadow_technique_; }
  // Number of markers that the last image with markers drew.
  size_t drawn_marker_count() const { return marker_pass_.selected_count(); }
  bool markers_lack_memory() const { return marker_pass_.lacks_memory(); }
  uint64_t uploaded_marker_bytes() const { return marker_pass_.uploaded_bytes(); }
  uint64_t shadow_rays() const { return shadows_.rays_traced(); }  // of a finished frame
  // Counts of a finished frame; zero on the forward path.
  ClusterRaster::Drawn clusters_drawn() const {
    return visibility_ ? visibility_->drawn() : ClusterRaster::Drawn{};
  }
  // For the current scene; see ShadowPass.
  uint32_t lights_without_shadow() const { return shadows_.lights_without_shadow(); }
  gpu::Device& device() const { return device_; }
  uint32_t max_textures() const { return settings_.max_textures; }
  bool traces() const { return shadows_.traces(); }
  RasterPath raster_path() const { return path_; }
  PostSettings& post_settings() { return settings_.post; }
  // Applies to later frames; for measurements with and without culling.
  void set_cull(Cull cull) { settings_.cull = cull; }
  // Applies to later frames. Has no effect if the scene was set without LODs.
  void set_levels_of_detail(LevelsOfDetail levels) { settings_.levels_of_detail = levels; }
  void set_shadows(bool on) { shadows_on_ = on; }
  // Applies to later frames, refraction excepted. Has no effect if the renderer was created without ray
  // effects.
  void set_ray_effects(const RayEffects& on) { settings_.ray_effects.on = on; }
  bool traces_ray_effects() const {
    const RayEffects& on = settings_.ray_effects.on;
    return ray_effects_ &&
           (on.reflections || on.ambient_occlusion || on.bounce || (gpu_scene_ && gpu_scene_->refracts));
  }
  // Ends the selected path-traced image that refines; the next one begins anew.
  void drop_paths() {
    if (path_tracer_) path_tracer_->drop_selected();
  }
  // See PathPass::select() and forget(). Call before prepare().
  void select_paths(uint64_t image) {
    if (path_tracer_) path_tracer_->select(image);
  }
  void forget_paths(uint64_t image) {
    if (path_tracer_) path_tracer_->forget(image);
  }
  RayBackEnd ray_effect_back_end() const {
    return ray_effects_ ? ray_effects_->back_end() : RayBackEnd::none;
  }

  // Applies to later frames: exposure, bloom, tone mapping, FXAA (which changes image()), culling, LOD,
  // shadows on and off, ray effects (but the first one), environment intensity and rotation, background,
  // numbers of the path tracer. All other settings stay.
  void apply(const DrawSettings& settings);
  // True if the settings need a new renderer: paths instead of raster or the reverse, another raster path,
  // shadow technique, sample count, environment or texture filter.
  bool needs_new_renderer(const DrawSettings& settings) const;

 private:
  // One image while it is recorded.
  struct Frame {
    const FrameRequest& request;
    const FramePlan plan;
    gpu::Recorder& recorder;
    gpu::StagingRing& staging;
    const state::PoseState& poses;
    std::span<const View> views;
    std::vector<VkDeviceAddress> globals;  // per view
    VkRect2D forward_area{};               // bounds of the forward draws
    VkRect2D hdr_area{};                   // pixels that the tone-map pass resolves
    VkRect2D whole_area() const { return {{0, 0}, request.extent}; }
  };

  // Preparation.
  void set_targets(VkExtent2D extent, uint32_t views);
  Targets& find_or_create_targets(VkExtent2D extent, uint32_t views);
  void drop_old_targets();
  void allocate(const FrameRequest& request);
  FrameFacts facts(const FrameRequest& request) const;
  bool shows_markers(const FrameRequest& request) const;
  bool has_depth_of_field(bool view_has_lens = false) const;
  Inspection available(Inspection inspection, const ImageOutputs& outputs) const;

  // Passes, in frame order.
  void update_scene(gpu::Recorder& recorder, gpu::StagingRing& staging, const state::PoseState& poses,
                    bool draws_forward);
  void build_acceleration_structures(gpu::Recorder& recorder);
  void record_acceleration_structures(gpu::Recorder& recorder);
  scene::EditRevisions edit_revisions() const {
    return edits_ ? edits_->revisions() : scene::EditRevisions();
  }
  void begin_targets(Frame& frame);
  void rasterise(const Frame& frame);
  void write_planes(const Frame& frame, std::span<CameraHistory> histories);
  void draw_debug_view(const Frame& frame);
  void merge_coverage(const Frame& frame);
  void trace_ray_effects(const Frame& frame);
  void shade(const Frame& frame);
  void draw_forward(const Frame& frame);
  void blur(const Frame& frame);
  void draw_markers(const Frame& frame);
  void post_process(const Frame& frame);
  void draw_overlays(const Frame& frame);

  bool can_refract(const DrawSettings& settings) const;
  uint32_t shadow_mode(bool masked) const;  // FIRE3DV_SHADOWS_*
  gpu_types::Globals make_globals(const View& view, bool shadow_mask) const;
  VkDeviceAddress upload_globals(const Frame& frame, const View& view) const;
  void expect_shading(const scene::Scene& scene);
  gpu::Rays expected_rays(const scene::Scene& scene) const;

  gpu::Device& device_;
  DrawSettings settings_;
  std::weak_ptr<const scene::EnvironmentImage>
      environment_source_;  // source of environment_; empty: the studio
  bool uses_studio_ = true;
  RasterPath path_;  // never automatic
  VkSampleCountFlagBits samples_;
  gpu::SetLayout scene_set_layout_;
  gpu::PipelineLayout layout_;
  EditUploader edit_uploader_;
  TransformsPass transforms_;
  DeformPass deform_;
  ForwardPass forward_;
  MarkerPass marker_pass_;
  ShadowTechnique shadow_technique_;
  bool shadows_on_ = true;
  bool has_acceleration_structures_ = false;  // those of the current frame are recorded
  std::optional<VisibilityPass> visibility_;
  std::optional<OutputsPass> outputs_;  // created with visibility_
  ShadowPass shadows_;
  PostPass post_;
  StaleOverlayPass stale_overlay_;
  std::unique_ptr<LightMeterPass> light_meter_;  // created on first use, like bloom_
  std::unique_ptr<BloomPass> bloom_;
  std::unique_ptr<DepthOfFieldPass> depth_of_field_;
  std::unique_ptr<PathPass> path_tracer_;        // null: raster
  TracedScene traced_scene_;                     // of the image that refines
  std::unique_ptr<RayEffectsPass> ray_effects_;  // null: not in the settings, or not supported
  bool refracts_ = false;                        // transmissive surfaces, by ray effects
  std::unique_ptr<Inspector> inspector_;         // created on first use
  Environment environment_;  // last: its wait for the GPU overlaps with pipeline compilation
  const scene::Scene* scene_ = nullptr;
  bool may_have_forward_only_ = false;  // has forward-only draws, hidden or not
  bool cameras_have_lenses_ = false;
  const scene::SceneEdits* edits_ = nullptr;
  const std::vector<state::ShownMarker>* markers_ = nullptr;
  std::unique_ptr<GpuScene> gpu_scene_;
  std::vector<std::unique_ptr<Targets>> target_cache_;  // by size, newest first
  Targets* targets_ = nullptr;                          // the first of them; null: nothing is prepared
  uint64_t prepared_ = 0;                               // count of prepare() calls
};

}  // namespace fire3dv::passes
