// Passes of a renderer, and the steps of one image while it is recorded. Internal to SceneRenderer.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/debug/inspector.h"
#include "renderer/passes/environment/environment.h"
#include "renderer/passes/forward/forward_pass.h"
#include "renderer/passes/frame_plan.h"
#include "renderer/passes/frame_request.h"
#include "renderer/passes/layers/layer_pass.h"
#include "renderer/passes/markers/marker_pass.h"
#include "renderer/passes/outputs/outputs_pass.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/path/traced_scene.h"
#include "renderer/passes/post/bloom_pass.h"
#include "renderer/passes/post/depth_of_field_pass.h"
#include "renderer/passes/post/light_meter_pass.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/post/sensor_pass.h"
#include "renderer/passes/ray_effects/ray_effects_pass.h"
#include "renderer/passes/renderer_settings.h"
#include "renderer/passes/resources/edit_uploader.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/pose_passes.h"
#include "renderer/passes/resources/target_cache.h"
#include "renderer/passes/view/view.h"
#include "renderer/passes/visibility/visibility_pass.h"

namespace fire3dv::passes {

// Passes that update the scene on the device, and resources that images of all settings share.
struct SharedPasses {
  SharedPasses(gpu::Device& device, const settings::DrawSettings& wanted);
  // Waits for the GPU: call it after the pipelines of the images were requested, whose compilation overlaps.
  void prepare_environment(const settings::DrawSettings& wanted);

  gpu::Device& device;
  gpu::SetLayout scene_set_layout;
  gpu::PipelineLayout layout;
  EditUploader edit_uploader;
  TransformsPass transforms;
  DeformPass deform;
  TracedScene traced_scene;                // of the path-traced image that refines
  std::optional<Environment> environment;  // set by prepare_environment()
  // The environment's light that is drawn as a lamp; paths keep it in the image. Set before the environment.
  std::optional<scene::EnvironmentSun> sun;
};

// Passes of images with these settings.
struct ScenePasses {
  // Borrows shared.
  ScenePasses(SharedPasses& shared, const settings::DrawSettings& wanted, const RendererSettings& settings);

  // Starts compilation of the pipelines that images of the scene will probably use, during its upload.
  void expect_scene(const RendererSettings& settings, const scene::Scene& scene);
  SceneUses uses_of(const RendererSettings& settings, const scene::Scene& scene) const;
  // Hands the targets to the passes that keep them. On a VulkanFailure none has any.
  void use(Targets& targets);
  struct AllocatedScene {
    GpuScene& gpu_scene;
    const scene::Scene& scene;
    const scene::SceneEdits* edits;  // null: none
  };
  // Allocates the memory of an image, for targets in use. Edits of the frame may still change the plan;
  // recording then allocates the rest.
  void allocate(const RendererSettings& settings, const FrameRequest& request, const FramePlan& plan,
                Targets& targets, const AllocatedScene& scene);
  // Constants of an image, without those of its views. shadow_mask: shading reads it.
  gpu_types::Globals globals_of_all_views(const RendererSettings& settings, const GpuScene& gpu_scene,
                                          const Targets& targets, bool shadow_mask) const;
  // Adds those of a view. map_set: see ShadowPass.
  void write_view_globals(gpu_types::Globals& globals, const RendererSettings& settings,
                          const GpuScene& gpu_scene, const View& view, uint32_t map_set) const;
  // Memory for the layers of an image, where the device can sort fragments.
  void allocate_layers(const RendererSettings& settings, VkExtent2D extent);
  uint32_t shadow_mode(const RendererSettings& settings, bool masked) const;  // FIRE3DV_SHADOWS_*
  void expect_shading(const RendererSettings& settings, const scene::Scene& scene);
  void expect_common(const RendererSettings& settings, const FramePlan& plan, const GpuScene& gpu_scene);

  SharedPasses& shared;
  gpu::Device& device;
  ForwardPass forward;
  MarkerPass markers;
  std::optional<VisibilityPass> visibility;
  std::optional<OutputsPass> outputs;
  ShadowPass shadows;
  PostPass post;
  StaleOverlayPass stale_overlay;
  std::unique_ptr<LayerPass> layers;            // null: no blended draws so far, or not supported
  std::unique_ptr<LightMeterPass> light_meter;  // created on first use, like bloom
  std::unique_ptr<BloomPass> bloom;
  std::unique_ptr<DepthOfFieldPass> depth_of_field;
  std::unique_ptr<SensorPass> sensor;
  std::unique_ptr<MaskPlanesPass> mask_planes;
  std::unique_ptr<PathPass> path_tracer;        // null: raster
  std::unique_ptr<RayEffectsPass> ray_effects;  // null: not in the settings, or not supported
  std::unique_ptr<Inspector> inspector;         // created on first use
};

// Settings of images, with their passes and targets.
struct ImagePasses {
  // Borrows shared and settings.
  ImagePasses(SharedPasses& shared, const settings::DrawSettings& wanted, const RendererSettings& settings);

  const RendererSettings& settings;
  ScenePasses passes;
  TargetCache targets;
};

// True if views may be drawn in one dispatch each pass: those of several worlds, and several of one where
// that pays. Their pipelines are compiled on first need, before the recording.
bool may_have_common_dispatches(const FrameRequest& request, const GpuScene& scene);
OutputsPass::Images images_of(const FrameRequest& request, const GpuScene& scene);

// Resources and values of the image.
struct FrameSource {
  ScenePasses& passes;
  const RendererSettings& settings;
  Targets& targets;
  GpuScene& gpu_scene;
  const scene::Scene& scene;
  gpu::Image& image;  // the finished one
  const FrameRequest& request;
  gpu::Recorder& recorder;
  gpu::StagingRing& staging;
  PosesOfWorlds poses;
  std::span<const View> views;
  const scene::SceneEdits* edits;  // null: none

  const state::PoseState& poses_of(const View& view) const { return *poses[view.world]; }
};

class Frame {
 public:
  // Begins the targets' generations and uploads the constants of each view.
  Frame(const FrameSource& source, const FramePlan& plan);

  // Steps in their order; see SceneRenderer::record.
  void rasterise();
  void write_planes(std::span<CameraHistory> histories);
  void mask_planes();
  void draw_debug_view();
  void merge_coverage();
  void trace_ray_effects();
  void shade();
  void draw_forward();
  void blur();
  void draw_markers();
  void post_process();
  void draw_overlays();

 private:
  VkRect2D whole_area() const { return {{0, 0}, source_.request.extent}; }
  InspectedView inspected_view() const;
  MarkerPass::Frame marker_frame() const;
  // Markers are layers among blended surfaces; after a lens, which does not blur them, among themselves.
  bool sorts_markers() const { return plan_.markers && !plan_.depth_of_field; }
  // Allocates the passes' layers if there are blended draws. False: draws are sorted as wholes.
  bool layers_for(bool is_blended);

  const FrameSource& source_;
  const FramePlan& plan_;
  ScenePasses& passes_;
  gpu::Recorder& recorder_;
  void find_map_sets();
  void upload_globals();

  std::vector<VkDeviceAddress> globals_;  // per view
  ShadowPass::MapSets map_sets_;          // of the shown worlds
  std::vector<uint32_t> map_set_of_;      // by view
  bool has_common_dispatches() const;
  gpu::StagingRing* common() const { return has_common_dispatches() ? &source_.staging : nullptr; }
  VkRect2D forward_area_{};          // bounds of the forward draws
  bool has_sorted_markers_ = false;  // draw_forward() has drawn all but the overlaid ones
  VkRect2D hdr_area_{};              // pixels that the tone-map pass resolves
};

}  // namespace fire3dv::passes
