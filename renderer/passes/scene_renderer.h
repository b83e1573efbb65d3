// Renderer of a scene in the current pose state, from one or several views. It owns the passes and records
// them in frame order.
#pragma once

#include <memory>
#include <optional>

#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/debug/inspector.h"
#include "renderer/passes/environment/environment.h"
#include "renderer/passes/forward/forward_pass.h"
#include "renderer/passes/outputs/plane_layout.h"
#include "renderer/passes/outputs/outputs_pass.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/post/stale_overlay_pass.h"
#include "renderer/passes/resources/deform_pass.h"
#include "renderer/passes/resources/edit_follower.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/resources/transforms_pass.h"
#include "renderer/passes/view.h"
#include "renderer/passes/visibility/visibility_pass.h"

namespace fire3dv::passes {

enum class RasterPath : uint8_t {
  automatic,   // visibility where the device supports it, otherwise forward
  forward,     // the raster pipeline: the reference
  visibility,  // compute, from a visibility buffer
};

// Use of coarser LODs on the visibility path.
enum class LevelsOfDetail : uint8_t {
  off,
  camera,
  everywhere,  // also in shadow maps: a quarter of a texel around a shadow's edge may then be lit
  automatic,   // the camera's, in scenes where they pay
};
// LODs that a scene needs for this setting.
scene::Levels levels_for(LevelsOfDetail wanted);

// Position in a frame. Further images of a frame reuse its transforms and deformation.
enum class OfFrame : uint8_t { first, further };

struct DrawSettings {
  RasterPath raster = RasterPath::automatic;
  Cull cull = Cull::automatic;
  LevelsOfDetail levels_of_detail = LevelsOfDetail::automatic;
  float anisotropy = 1;  // off, so that images are identical on all devices
  uint32_t samples = 4;
  ShadowSettings shadows;
  std::shared_ptr<const scene::EnvironmentImage> environment;  // null: the studio environment
  std::shared_ptr<EnvironmentStore> kept_environments;         // cache; null: maps are prepared at each start
  float environment_intensity = 1;
  float environment_rotation_rad = 0;  // about +Y, counter-clockwise seen from above
  Background background;
  PostSettings post;
  uint32_t most_textures = 1 << 16;  // texture capacity of a scene; larger values slow down every start
};

class SceneRenderer {
 public:
  SceneRenderer(gpu::Device& device, const DrawSettings& settings);

  // The scene must respect most_textures and outlive its use here. Repeated calls are allowed: the old
  // scene's resources retire. Throws VulkanFailure when memory is short; the earlier scene then stays in use.
  void set_scene(const scene::Scene& scene) {
    set_scene(scene, scene::derive(scene, levels_for(settings_.levels_of_detail)));
  }
  void set_scene(const scene::Scene& scene, const scene::Derived& derived);
  // Edits of the current scene, read in each frame. Call it once, before the first frame.
  void set_edits(const scene::SceneEdits& edits) { edits_ = &edits; }
  // views: images of this size that are taken together. Targets of a few small sizes are cached, so switching
  // is cheap. Throws VulkanFailure when memory is short; a size must be set again then.
  void set_size(VkExtent2D extent, uint32_t views = 1);
  // Marks a new frame with new transforms. record() calls it; call it earlier only for make_room() and
  // can_keep_places().
  void begin_frame();
  // Allocates most of the memory that record() needs for these outputs at this size: planes, snapshots,
  // cluster lists.
  void make_room(const ImageOutputs& outputs);
  // False when camera histories hold too many snapshots for this frame's.
  bool can_keep_places() const;

  // Returns an error for outputs that are unavailable, or unavailable for several views.
  Result<void> can_take(const ImageOutputs& outputs, uint32_t views = 1) const;

  // Returns an error if this debug view, or outlines and picks, are unavailable.
  Result<void> can_show(DebugView view) const;
  Result<void> can_inspect() const;

  // Records the passes. Requested colours are in image(), planes in planes(), ready to be read. history: of
  // the camera, for motion.
  void record(gpu::Recorder& recorder, gpu::StagingRing& belt, const state::PoseState& poses,
              const View& view, const ImageOutputs& outputs = {}, CameraHistory* history = nullptr,
              const Inspection& inspection = {}) {
    record(recorder, belt, poses, std::span<const View>(&view, 1), outputs,
           std::span<CameraHistory>(history, history ? 1 : 0), OfFrame::first, inspection);
  }
  // The same for the number of views of set_size(); common work is recorded once. Image and planes stack the
  // views vertically, in order. Several views have no FXAA and share one set of shadow maps. histories: one
  // per view, or none. inspection: for a single view with colours; unavailable parts are ignored.
  void record(gpu::Recorder& recorder, gpu::StagingRing& belt, const state::PoseState& poses,
              std::span<const View> views, const ImageOutputs& outputs, std::span<CameraHistory> histories,
              OfFrame of_frame = OfFrame::first, const Inspection& inspection = {});
  // Reports the submission of the last recorded frame; its picks arrive after that timeline value.
  void submitted(uint64_t timeline_value);
  // Returns new picking results; see Inspection::pick.
  std::vector<Picked> take_picked();

  // Draws the stale overlay after record(), unless the condition is live.
  void mark_held(gpu::Recorder& recorder, state::Condition condition) {
    held_mark_.record(recorder, *targets_, image(), condition);
  }

  gpu::Image& image() {
    return targets_->views > 1 ? targets_->display : PostPass::result(*targets_, settings_.post);
  }
  gpu::Buffer& planes() { return outputs_->planes(); }
  const std::vector<PlanePlace>& plane_places() const { return outputs_->places(); }
  VkExtent2D extent() const { return targets_ ? targets_->extent : VkExtent2D{}; }  // 0: not set
  uint32_t views() const { return targets_ ? targets_->views : 1; }
  const GpuScene& gpu_scene() const { return *gpu_scene_; }
  VkSampleCountFlagBits samples() const { return samples_; }
  const ShadowTechnique& shadow_technique() const { return shadow_way_; }
  uint64_t shadow_rays() const { return shadows_.rays_traced(); }  // of a finished frame
  // Counts of a finished frame; zero on the forward path.
  ClusterRaster::Drawn clusters_drawn() const {
    return visibility_ ? visibility_->drawn() : ClusterRaster::Drawn{};
  }
  // For the current scene; see ShadowPass.
  uint32_t lights_without_shadow() const { return shadows_.lights_without_shadow(); }
  gpu::Device& device() const { return device_; }
  uint32_t most_textures() const { return settings_.most_textures; }
  bool traces() const { return shadows_.traces(); }
  RasterPath raster_path() const { return path_; }
  PostSettings& post_settings() { return settings_.post; }
  // Applies to later frames; for measurements with and without culling.
  void set_cull(Cull cull) { settings_.cull = cull; }
  // Applies to later frames. Has no effect if the scene was set without LODs.
  void set_levels_of_detail(LevelsOfDetail levels) { settings_.levels_of_detail = levels; }
  void set_shadows(bool on) { shadows_on_ = on; }

  // Applies to later frames: exposure, tone mapping, FXAA (which changes image()), culling, LOD, shadows on
  // and off, environment intensity and rotation, background. All other settings stay.
  void apply(const DrawSettings& settings);
  // True if the settings need a new renderer: another raster path, shadow technique, sample count,
  // environment or texture filter.
  bool needs_new_renderer(const DrawSettings& settings) const;

 private:
  Targets& targets_of(VkExtent2D extent, uint32_t views);
  void drop_old_targets();
  void record_what_moves(gpu::Recorder& recorder, gpu::StagingRing& belt, const state::PoseState& poses);
  // Consumers of this frame's visibility buffer and shadow maps.
  struct Sees {
    bool camera;  // false: only shadow maps are needed
    bool levels_of_detail;
    bool lights;
  };
  void find_visible(gpu::Recorder& recorder, gpu::StagingRing& belt, std::span<const View> views,
                    std::span<const VkDeviceAddress> globals, const Sees& sees);
  // Technique of shading in this frame.
  struct Shading {
    bool compute, masked;
    PostPass::Linear linear;
  };
  void shade(gpu::Recorder& recorder, gpu::StagingRing& belt, const state::PoseState& poses,
             std::span<const View> views, std::span<const VkDeviceAddress> globals, const Shading& how);
  void shade_from_visibility(gpu::Recorder& recorder, std::span<const View> views,
                             std::span<const VkDeviceAddress> globals, bool masked, const VkRect2D* left);
  uint32_t number_of_shadows(bool masked) const;  // FIRE3DV_SHADOWS_*
  Inspection possible_of(Inspection wanted, const ImageOutputs& outputs) const;
  void inspect(gpu::Recorder& recorder, gpu::StagingRing& belt, const View& view, VkDeviceAddress globals,
               const Inspection& inspection);
  void mark(gpu::Recorder& recorder, gpu::StagingRing& belt, const View& view, VkDeviceAddress globals,
            const Inspection& inspection, bool masked);
  VkDeviceAddress upload_globals(gpu::StagingRing& belt, const View& view, bool masked);
  void expect_shading(const scene::Scene& scene);
  gpu::Rays expected_rays(const scene::Scene& scene) const;
  bool shows_levels() const;
  bool levels_in_maps() const;
  void build_acceleration_structures(gpu::Recorder& recorder);

  gpu::Device& device_;
  DrawSettings settings_;
  std::weak_ptr<const scene::EnvironmentImage> environment_of_;  // source of environment_; empty: the studio
  bool own_studio_ = true;
  RasterPath path_;  // never automatic
  VkSampleCountFlagBits samples_;
  gpu::SetLayout scene_set_layout_;
  gpu::PipelineLayout layout_;
  EditFollower edit_follower_;
  TransformsPass transforms_;
  DeformPass deform_;
  ForwardPass forward_;
  ShadowTechnique shadow_way_;
  bool shadows_on_ = true;
  bool acceleration_frame_ = false;  // acceleration structures of the current frame are recorded
  std::optional<VisibilityPass> visibility_;
  std::optional<OutputsPass> outputs_;  // created with visibility_
  ShadowPass shadows_;
  PostPass post_;
  HeldMark held_mark_;
  std::unique_ptr<Inspector> inspector_;  // created on first use
  Environment environment_;               // last: its wait for the GPU overlaps with pipeline compilation
  const scene::Scene* scene_ = nullptr;
  bool may_have_on_top_ = false;  // has forward-only draws, hidden or not
  const scene::SceneEdits* edits_ = nullptr;
  std::unique_ptr<GpuScene> gpu_scene_;
  std::vector<std::unique_ptr<Targets>> kept_targets_;  // cached by size, newest first
  Targets* targets_ = nullptr;                          // the first of them
};

}  // namespace fire3dv::passes
