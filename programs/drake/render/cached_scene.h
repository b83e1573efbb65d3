// A loaded scene on the device, with the renderer that draws it. Later images of the same content only set
// transforms.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "programs/drake/request/gltf_scene.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::drake {

struct LoadedDrakeScene {
  scene::LoadedScene loaded;
  uint64_t bytes = 0;  // in memory
  // glTF node of each scene node; kNone: it has no transform of its own in the request.
  std::vector<uint32_t> source_of_node;
  std::vector<uint32_t> label_source_of_node;  // glTF node whose label it has; kNone: none
};

struct SceneLoading {
  bool has_key_light = false;
  scene::Levels levels = scene::Levels::automatic_levels;
  uint64_t max_bytes = 0;        // of the loaded scene
  uint64_t max_image_bytes = 0;  // of its decoded images
  std::function<bool()> stop_requested;
};

// Loads the scene at the request's transforms. Warnings stay in Scene::warnings.
Result<std::unique_ptr<LoadedDrakeScene>> load_scene(GltfScene& gltf, const SceneLoading& loading);

class CachedScene {
 public:
  // The scene's textures must fit the settings. estimated: exposure follows from the lights of each request.
  CachedScene(gpu::Device& device, const settings::DrawSettings& settings,
              std::unique_ptr<LoadedDrakeScene> scene, std::optional<settings::PostSettings> estimated);

  const scene::Scene& scene() const { return scene_->loaded.scene; }
  passes::SceneRenderer& renderer() { return renderer_; }
  const state::PoseState& poses() const { return poses_; }
  // gltf: a scene of the same content. Nothing of an earlier request stays: neither bounds nor exposure.
  void set_transforms(const GltfScene& gltf);
  // Label of a scene node's pixels.
  Rgb8 label_of(uint32_t node, const GltfScene& gltf) const;

 private:
  std::unique_ptr<LoadedDrakeScene> scene_;
  settings::DrawSettings settings_;
  const std::optional<settings::PostSettings> estimated_;
  state::PoseState poses_;
  state::RestPose rest_;
  passes::SceneRenderer renderer_;
};

}  // namespace fire3dv::drake
