// Draws a scene as the pose state has it, from one view. The passes of a frame, in the order in which they
// run.
#pragma once

#include <memory>
#include <optional>

#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/deform_pass.h"
#include "renderer/passes/edit_follower.h"
#include "renderer/passes/environment.h"
#include "renderer/passes/forward_pass.h"
#include "renderer/passes/gpu_scene.h"
#include "renderer/passes/held_mark.h"
#include "renderer/passes/image_outputs.h"
#include "renderer/passes/inspector.h"
#include "renderer/passes/outputs_pass.h"
#include "renderer/passes/post_pass.h"
#include "renderer/passes/targets.h"
#include "renderer/passes/transforms_pass.h"
#include "renderer/passes/view.h"
#include "renderer/passes/visibility_pass.h"

namespace fire3dv::passes {

enum class RasterPath : uint8_t {
  automatic,   // visibility where the device can, else forward
  forward,     // the raster pipeline: the reference
  visibility,  // compute, from a visibility buffer
};

// Where coarser triangles are drawn, on the visibility path.
enum class LevelsOfDetail : uint8_t {
  off,
  camera,
  everywhere,  // in lights' maps, too: within a quarter of a texel of a shadow's edge these may then say lit
  automatic,   // the camera's, in scenes where they pay
};
// Which a scene has to have for that.
scene::Levels levels_for(LevelsOfDetail wanted);

// Images of other sizes or with other outputs may follow in one frame: what moves has been moved by then.
enum class OfFrame : uint8_t { first, further };

struct DrawSettings {
  RasterPath raster = RasterPath::automatic;
  Cull cull = Cull::automatic;
  LevelsOfDetail levels_of_detail = LevelsOfDetail::automatic;
  float anisotropy = 1;  // off: images are then the same on all devices
  uint32_t samples = 4;
  ShadowSettings shadows;
  std::shared_ptr<const scene::EnvironmentImage> environment;  // null: the studio
  std::shared_ptr<EnvironmentStore> kept_environments;         // null: it is prepared each time
  float environment_intensity = 1;
  float environment_rotation_rad = 0;  // about +Y, counter-clockwise seen from above
  Background background;
  PostSettings post;
  uint32_t most_textures = 1 << 16;  // that a scene may have; more is possible, and makes every start slower
};

class SceneRenderer {
 public:
  SceneRenderer(gpu::Device& device, const DrawSettings& settings);

  // The scene has no more textures than the settings say. It must outlive its use here. May be called again:
  // what the old one held retires. Throws VulkanFailure where memory does not suffice: then the scene that
  // was set before stays, and is drawn as before.
  void set_scene(const scene::Scene& scene) {
    set_scene(scene, scene::derive(scene, levels_for(settings_.levels_of_detail)));
  }
  void set_scene(const scene::Scene& scene, const scene::Derived& derived);
  // What is changed of the scene that is shown, looked at in each frame; it speaks of the scene that is set
  // then. Once, before the first frame.
  void set_edits(const scene::SceneEdits& edits) { edits_ = &edits; }
  // views: images of this size that are taken at once. Going back and forth between a few sizes is cheap, as
  // long as these are not large.
  // Throws VulkanFailure where memory does not suffice: a size has to be set again then.
  void set_size(VkExtent2D extent, uint32_t views = 1);
  // Everything has moved: the next record() is a frame's first. It says so itself; before that, make_room()
  // and can_keep_places() have to be told.
  void begin_frame();
  // Takes most of the memory that a record() of these needs at this size, which takes it else: planes,
  // places, lists of clusters.
  void make_room(const ImageOutputs& outputs);
  // False: so many histories hold the places of so many frames that there is no room for this one's.
  bool can_keep_places() const;

  // One sentence when these cannot be had here, from so many cameras at once.
  Result<void> can_take(const ImageOutputs& outputs, uint32_t views = 1) const;

  // One sentence when this view, or outlines and picks, cannot be had here.
  Result<void> can_show(DebugView view) const;
  Result<void> can_inspect() const;

  // Records the passes; colours are in image() and planes in planes(), as far as they are wanted, ready to be
  // read. history: of the camera, where motion is wanted.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, const state::PoseState& poses, const View& view,
              const ImageOutputs& outputs = {}, CameraHistory* history = nullptr,
              const Inspection& inspection = {}) {
    record(recorder, belt, poses, std::span<const View>(&view, 1), outputs,
           std::span<CameraHistory>(history, history ? 1 : 0), OfFrame::first, inspection);
  }
  // The same of as many views as set_size() says, with all that they share done once. The image, and each
  // plane, has them one below the other, in their order. Several are not smoothed (FXAA), and are drawn with
  // one set of shadow maps. histories: of each camera, or none. inspection: of one view, where there are
  // colours; what can_show() and can_inspect() deny is left out.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, const state::PoseState& poses,
              std::span<const View> views, const ImageOutputs& outputs, std::span<CameraHistory> histories,
              OfFrame of_frame = OfFrame::first, const Inspection& inspection = {});
  // The frame that was recorded last is on its way: what was picked in it comes when it is done.
  void submitted(uint64_t timeline_value);
  // What was found since; see Inspection::pick.
  std::vector<Picked> take_picked();

  // After record(): marks the image as held, where the condition is not live.
  void mark_held(gpu::Recorder& recorder, state::Condition condition) {
    held_mark_.record(recorder, *targets_, image(), condition);
  }

  gpu::Image& image() {
    return targets_->views > 1 ? targets_->display : PostPass::result(*targets_, settings_.post);
  }
  gpu::Buffer& planes() { return outputs_->planes(); }
  const std::vector<PlanePlace>& plane_places() const { return outputs_->places(); }
  VkExtent2D extent() const { return targets_ ? targets_->extent : VkExtent2D{}; }  // 0: none is set
  uint32_t views() const { return targets_ ? targets_->views : 1; }
  const GpuScene& gpu_scene() const { return *gpu_scene_; }
  VkSampleCountFlagBits samples() const { return samples_; }
  const ShadowWay& shadow_way() const { return shadow_way_; }
  uint64_t shadow_rays() const { return shadows_.rays_traced(); }  // of a frame that is finished
  // Of a frame that is finished; none on the forward path.
  ClusterRaster::Drawn clusters_drawn() const {
    return visibility_ ? visibility_->drawn() : ClusterRaster::Drawn{};
  }
  // Of the scene that is set; see ShadowPass.
  uint32_t lights_without_shadow() const { return shadows_.lights_without_shadow(); }
  gpu::Device& device() const { return device_; }
  uint32_t most_textures() const { return settings_.most_textures; }
  bool traces() const { return shadows_.traces(); }
  RasterPath raster_path() const { return path_; }
  PostSettings& post_settings() { return settings_.post; }
  // Of the frames to come, for measurements of one scene with and without.
  void set_cull(Cull cull) { settings_.cull = cull; }
  // None are drawn of a scene that was set when they were off.
  void set_levels_of_detail(LevelsOfDetail levels) { settings_.levels_of_detail = levels; }
  void set_shadows(bool on) { shadows_on_ = on; }

  // Of the frames to come: exposure, tone mapping, FXAA (image() is another one then), culling, levels of
  // detail, shadows on and off, what the surroundings give, the background. All else stays as the renderer
  // was made.
  void apply(const DrawSettings& settings);
  // Whether these want what only a renderer that is made with them has: another path or way to find shadows,
  // other samples, surroundings, texture filters.
  bool needs_new_renderer(const DrawSettings& settings) const;

 private:
  Targets& targets_of(VkExtent2D extent, uint32_t views);
  void drop_old_targets();
  void record_what_moves(gpu::Recorder& recorder, gpu::UploadBelt& belt, const state::PoseState& poses);
  // What a frame finds out with ids and depths.
  struct Sees {
    bool camera;  // not for the lights alone
    bool levels_of_detail;
    bool lights;
  };
  void find_visible(gpu::Recorder& recorder, gpu::UploadBelt& belt, std::span<const View> views,
                    std::span<const VkDeviceAddress> globals, const Sees& sees);
  // How, on which path.
  struct Shading {
    bool compute, masked;
    PostPass::Linear linear;
  };
  void shade(gpu::Recorder& recorder, gpu::UploadBelt& belt, const state::PoseState& poses,
             std::span<const View> views, std::span<const VkDeviceAddress> globals, const Shading& how);
  void shade_from_visibility(gpu::Recorder& recorder, std::span<const View> views,
                             std::span<const VkDeviceAddress> globals, bool masked, const VkRect2D* left);
  uint32_t number_of_shadows(bool masked) const;  // FIRE3DV_SHADOWS_*
  Inspection possible_of(Inspection wanted, const ImageOutputs& outputs) const;
  void inspect(gpu::Recorder& recorder, gpu::UploadBelt& belt, const View& view, VkDeviceAddress globals,
               const Inspection& inspection);
  void mark(gpu::Recorder& recorder, gpu::UploadBelt& belt, const View& view, VkDeviceAddress globals,
            const Inspection& inspection, bool masked);
  VkDeviceAddress upload_globals(gpu::UploadBelt& belt, const View& view, bool masked);
  void expect_shading(const scene::Scene& scene);
  gpu::Rays expected_rays(const scene::Scene& scene) const;
  bool shows_levels() const;
  bool levels_in_maps() const;
  void record_what_rays_meet(gpu::Recorder& recorder);

  gpu::Device& device_;
  DrawSettings settings_;
  std::weak_ptr<const scene::EnvironmentImage>
      environment_of_;  // what environment_ was made of; none: the studio
  bool own_studio_ = true;
  RasterPath path_;  // never automatic
  VkSampleCountFlagBits samples_;
  gpu::SetLayout scene_set_layout_;
  gpu::PipelineLayout layout_;
  EditFollower edit_follower_;
  TransformsPass transforms_;
  DeformPass deform_;
  ForwardPass forward_;
  ShadowWay shadow_way_;
  bool shadows_on_ = true;
  bool rays_meet_frame_ = false;  // what they meet has been built for the frame that is recorded
  std::optional<VisibilityPass> visibility_;
  std::optional<OutputsPass> outputs_;  // beside visibility_
  ShadowPass shadows_;
  PostPass post_;
  HeldMark held_mark_;
  std::unique_ptr<Inspector> inspector_;  // made when something is first inspected
  Environment environment_;  // last: it waits for the GPU, and meanwhile the pipelines above are made
  const scene::Scene* scene_ = nullptr;
  bool may_have_on_top_ = false;  // something of it, hidden or not, only the forward pass draws
  const scene::SceneEdits* edits_ = nullptr;
  std::unique_ptr<GpuScene> gpu_scene_;
  std::vector<std::unique_ptr<Targets>> kept_targets_;  // of the last sizes, the newest first
  Targets* targets_ = nullptr;                          // the first of them
};

}  // namespace fire3dv::passes
