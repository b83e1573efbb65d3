// Renderer of a scene in the current pose state, from one or several views. It owns the passes and records
// them in frame order.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "renderer/passes/frame_request.h"
#include "renderer/passes/outputs/camera_history.h"
#include "renderer/passes/path/path_hooks.h"
#include "renderer/passes/renderer_settings.h"
#include "renderer/passes/view/view.h"

namespace fire3dv::gpu {
class FrameRing;
class Recorder;
class StagingRing;
struct Image;
}  // namespace fire3dv::gpu
namespace fire3dv::scene {
struct Derived;
struct EditRevisions;
class SceneEdits;
enum class Levels : uint8_t;
}  // namespace fire3dv::scene
namespace fire3dv::state {
class PoseState;
enum class Condition : uint8_t;
struct ShownMarker;
}  // namespace fire3dv::state

namespace fire3dv::passes {

struct FrameFacts;
struct GpuScene;
struct ImagePasses;
class PathPass;
struct PlaneRange;
struct SharedPasses;

// Worlds are rows of a dispatch: the guaranteed minimum of all devices.
constexpr uint32_t kMaxWorlds = 65'535;

// LODs that a scene needs for this setting.
scene::Levels levels_for(settings::LevelsOfDetail wanted);

// Counts of a finished frame.
struct RenderCounts {
  uint32_t clusters = 0;       // drawn for the first view; 0 on the forward path
  uint32_t late_clusters = 0;  // of these, drawn in the second round
  uint64_t shadow_rays = 0;
  uint32_t lights_without_shadow = 0;  // for lack of memory; see ShadowPass
  size_t markers = 0;                  // drawn by the last image with markers
  uint64_t uploaded_marker_bytes = 0;
  bool markers_lack_memory = false;
};

// More than 60 members: the one entrance to scene, settings, recording and results.
class SceneRenderer {
 public:
  SceneRenderer(gpu::Device& device, const settings::DrawSettings& settings);
  ~SceneRenderer();

  // The scene must respect max_textures and outlive its use here. Repeated calls are allowed: the old
  // scene's resources retire. Throws VulkanFailure when memory is short; the earlier scene then stays in use.
  // worlds: 1 to kMaxWorlds copies of the scene that differ in their poses alone and share its geometry; each
  // view shows one.
  void set_scene(const scene::Scene& scene, uint32_t worlds = 1);
  void set_scene(const scene::Scene& scene, const scene::Derived& derived, uint32_t worlds = 1);
  // Edits of the current scene, read in each frame. Call it once, before the first frame.
  void set_edits(const scene::SceneEdits& edits) { edits_ = &edits; }
  // Markers of later images that request them. They are read by prepare() and record().
  void set_markers(const std::vector<state::ShownMarker>& markers) { markers_ = &markers; }
  // Selects targets of the requested size and allocates most of the memory that record() needs: targets,
  // planes, motion snapshots, cluster lists. Targets of a few small sizes are cached. The error names what is
  // short; then no image can be recorded before another prepare(). Needs a scene.
  Result<PreparedFrame> prepare(const FrameRequest& request, Shortage* shortage = nullptr);

  // Returns an error for outputs that are unavailable, or unavailable for several views.
  Result<void> can_take(const ImageOutputs& outputs, uint32_t views = 1) const {
    return settings_.can_take(outputs, views, limits());
  }
  // Returns an error if this debug view, or outlines and picks, are unavailable.
  Result<void> can_show(settings::DebugView view) const { return settings_.can_show(view); }
  Result<void> can_inspect() const { return settings_.can_inspect(); }
  // Returns an error if images of cameras with a lens would be those of pinholes.
  Result<void> can_blur() const { return settings_.can_blur(); }

  // Records the passes. Requested colours are in image(), planes in planes(), ready to be read. views: as
  // many as requested. histories: one per view, for motion, or none. poses: of each world.
  void record(const PreparedFrame& frame, gpu::Recorder& recorder, gpu::StagingRing& staging,
              std::span<const state::PoseState* const> poses, std::span<const View> views,
              std::span<CameraHistory> histories = {});
  // The same for a scene with one world.
  void record(const PreparedFrame& frame, gpu::Recorder& recorder, gpu::StagingRing& staging,
              const state::PoseState& poses, std::span<const View> views,
              std::span<CameraHistory> histories = {}) {
    const state::PoseState* const world = &poses;
    record(frame, recorder, staging, std::span(&world, 1), views, histories);
  }
  // The same for one view.
  void record(const PreparedFrame& frame, gpu::Recorder& recorder, gpu::StagingRing& staging,
              const state::PoseState& poses, const View& view, CameraHistory* history = nullptr) {
    record(frame, recorder, staging, poses, std::span(&view, 1), std::span(history, history ? 1 : 0));
  }
  // Traces the paths of an image of a scene with one world, in submissions of its own. With
  // DrawSettings::path, record() of the same frame and view follows and resolves them. Returns false if
  // should_stop ended it; then nothing may be recorded. A frame that refines adds samples to the last such
  // image. If scene, view or settings have changed, the image starts again, but not before its first sample
  // is whole; until then record() shows the image before it.
  bool trace_paths(const PreparedFrame& frame, const state::PoseState& poses, const View& view,
                   const PathHooks& hooks = {});
  // prepare(), trace_paths() if the settings trace the requested colours, and FrameRing::begin(). record()
  // follows. nullopt: should_stop ended the tracing.
  struct BegunFrame {
    PreparedFrame prepared;
    gpu::Recorder& recorder;
  };
  Result<std::optional<BegunFrame>> begin_next(gpu::FrameRing& frames, const FrameRequest& request,
                                               const state::PoseState& poses, const View& view,
                                               const PathHooks& hooks = {});

  // Reports the submission of the last recorded frame; its picks arrive after that timeline value.
  void submitted(uint64_t timeline_value);
  // Returns new picking results; see Inspection::pick.
  std::vector<Picked> take_picked();

  // Draws the stale overlay after record(), unless the condition is live.
  void draw_stale_overlay(gpu::Recorder& recorder, state::Condition condition);

  gpu::Image& image();
  // Light of the last image with FrameRequest::distorts, before the sensor: eight bytes a pixel, see
  // gpu_types::SensorRecord. Null: the settings have no optics, and image() has its colours.
  gpu::Buffer* undeveloped_light();
  // Optics and sensor for that light after its distortion, of any size. The image is valid until the next
  // call. view: of the image that had the light.
  gpu::Image& develop(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Buffer& light,
                      VkExtent2D extent, const View& view, const state::PoseState& poses);
  gpu::Buffer& planes();
  const std::vector<PlaneRange>& plane_ranges() const;
  gpu::Buffer& flow();        // of the last image with FrameRequest::flow_from, see FlowPass::result()
  VkExtent2D extent() const;  // 0: nothing is prepared
  const GpuScene& gpu_scene() const { return *gpu_scene_; }
  RenderCounts counts() const;
  gpu::Device& device() const { return device_; }
  bool traces_shadow_rays() const;  // in the current scene
  bool traces_ray_effects() const { return settings_.traces_ray_effects(limits().refracts); }
  settings::RayBackEnd ray_effect_back_end() const;
  bool traces_paths() const { return settings_.traces_paths(); }
  // Null: raster. Select and forget images before prepare().
  PathPass* path_tracer() const;

  const RendererSettings& settings() const { return settings_; }
  // Applies to later frames: exposure, bloom, tone mapping, FXAA (which changes image()), culling, LOD,
  // shadows on and off, ray effects (but the first one), environment intensity and rotation, background,
  // numbers of the path tracer. All other settings stay.
  void apply(const settings::DrawSettings& settings);
  // True if images of requests with in_motion have fewer samples, or shadows by maps alone: on a CPU, with
  // settings that allow it. See settings_in_motion().
  bool reduces_motion() const;
  // True if the settings need a new renderer: paths instead of raster or the reverse, another raster path,
  // shadow technique, sample count, environment or texture filter.
  bool needs_new_renderer(const settings::DrawSettings& settings) const {
    return settings_.needs_new_renderer(settings);
  }

 private:
  FrameFacts facts(const FrameRequest& request) const;
  SceneLimits limits() const;
  bool shows_markers(const FrameRequest& request) const;
  ImagePasses& passes_for(const FrameRequest& request);
  void create_motion_passes();
  void set_motion_scene();
  void drop_motion_passes();
  void forget_scene(ImagePasses& images);
  Inspection available(Inspection inspection, const ImageOutputs& outputs) const;
  // view: of the first image.
  void update_scene(gpu::Recorder& recorder, gpu::StagingRing& staging,
                    std::span<const state::PoseState* const> poses, const View& view, bool draws_forward);
  // Of the lamps beside the lens.
  void light_lamps(gpu::Recorder& recorder, gpu::StagingRing& staging,
                   std::span<const state::PoseState* const> poses, std::span<const View> views);
  void build_acceleration_structures(gpu::Recorder& recorder);
  void record_acceleration_structures(gpu::Recorder& recorder);
  scene::EditRevisions edit_revisions() const;

  gpu::Device& device_;
  RendererSettings settings_;
  std::optional<RendererSettings> motion_settings_;  // of moving_
  std::unique_ptr<SharedPasses> shared_;
  std::unique_ptr<ImagePasses> still_, moving_;  // moving_: null until an image in motion needs it
  ImagePasses* drawn_;                           // those of the last prepare()
  bool lacks_motion_memory_ = false;             // for moving_
  bool has_acceleration_structures_ = false;     // those of the current frame are recorded
  const scene::Scene* scene_ = nullptr;
  SceneLimits limits_;  // but refracts
  const scene::SceneEdits* edits_ = nullptr;
  const std::vector<state::ShownMarker>* markers_ = nullptr;
  std::unique_ptr<GpuScene> gpu_scene_;
  uint64_t prepared_ = 0;  // count of prepare() calls
};

}  // namespace fire3dv::passes
