// Brings the GPU's copy of a scene after what is edited of it. Only what has changed since the last frame is
// written; a frame in which nothing was edited costs a comparison here, and nothing on the GPU.
#pragma once

#include <map>

#include "renderer/passes/gpu_scene.h"
#include "renderer/passes/patches.h"
#include "renderer/passes/shadow_pass.h"
#include "renderer/scene/scene_edits.h"

namespace fire3dv::passes {

class EditFollower {
 public:
  explicit EditFollower(gpu::Device& device) : device_(device) {}

  // Before anything else of the frame. Returns true when vertices were written.
  bool follow(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& gpu_scene, const scene::Scene& scene,
              const scene::SceneEdits& edits, ShadowPass& shadows);
  // The scene was replaced: all edits are new to it.
  void forget() {
    seen_ = {};
    materials_.clear();
    colors_.clear();
    vertices_.clear();
  }

 private:
  struct Change {
    GpuScene& gpu_scene;
    const scene::Scene& scene;
    const scene::SceneEdits& edits;
    Patches patches;
    bool draws = false;     // other ones, or of other primitives
    bool vertices = false;  // were written
  };
  struct Color {
    glm::vec4 base_color{1};
    uint32_t first_material = 0;  // of the node's own
  };
  static void follow_visible(Change& change, ShadowPass& shadows);
  void follow_materials(Change& change);
  // anew: copies of materials are made again, whoever has them.
  void follow_colors(Change& change, bool anew);
  void make_room_for_colors(Change& change);
  void give_own_materials(Change& change);
  static void give_back_materials(Change& change, uint32_t node);
  static void set_part_material(Change& change, uint32_t node, uint32_t i, uint32_t material);
  static void set_first_primitive(Change& change, uint32_t node, uint32_t first_primitive);
  void follow_lights(Change& change, ShadowPass& shadows);
  void follow_vertices(Change& change);

  gpu::Device& device_;
  scene::EditRevisions seen_;
  scene::MaterialEdits materials_;
  std::map<uint32_t, Color> colors_;  // of nodes
  std::map<uint32_t, std::shared_ptr<const scene::ReplacedVertices>> vertices_;
};

}  // namespace fire3dv::passes
