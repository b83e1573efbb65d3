// Incremental update of the GPU scene after scene edits. It writes only the changes since the last frame; a
// frame without edits costs one comparison and no GPU work.
#pragma once

#include <map>

#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/model/scene_edits.h"

namespace fire3dv::passes {

class EditUploader {
 public:
  explicit EditUploader(gpu::Device& device) : device_(device) {}

  // Changes that other passes have to follow.
  struct Changed {
    bool visibility = false;  // hidden nodes
    bool lights = false;
    bool vertices = false;  // written
  };
  // Call it before all other work of the frame.
  Changed upload(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& gpu_scene,
                 const scene::Scene& scene, const scene::SceneEdits& edits);
  // Resets the state for a new scene, to which all edits are new.
  void reset() {
    revisions_ = {};
    materials_.clear();
    textures_.clear();
    colors_.clear();
    vertices_.clear();
  }

 private:
  struct Change {
    GpuScene& gpu_scene;
    const scene::Scene& scene;
    const scene::SceneEdits& edits;
    gpu::Patches patches;
    bool draws = false;  // the draws or their primitives changed
    Changed changed = {};
  };
  struct Color {
    glm::vec4 base_color{1};
    uint32_t first_material = 0;  // first appended material copy of the node
  };
  static void upload_visibility(Change& change);
  void upload_materials(Change& change);
  void upload_textures(Change& change);
  // recreate: creates new material copies for all nodes with colour edits.
  void upload_colors(Change& change, bool recreate);
  void reserve_colors(Change& change);
  void assign_edited_materials(Change& change);
  // Of each world.
  template <typename T>
  static void write_primitives(Change& change, VkDeviceSize offset, const T& value) {
    for (VertexBuffers& vertices : change.gpu_scene.vertices)
      change.patches.write(vertices.primitives, offset, value);
  }
  static void restore_materials(Change& change, uint32_t node);
  static void set_part_material(Change& change, uint32_t node, uint32_t i, uint32_t material);
  static void set_first_primitive(Change& change, uint32_t node, uint32_t first_primitive);
  void upload_lights(Change& change);
  void upload_vertices(Change& change);

  gpu::Device& device_;
  scene::EditRevisions revisions_;
  scene::MaterialEdits materials_;
  scene::MaterialTextureEdits textures_;
  std::map<uint32_t, Color> colors_;  // by node
  std::map<uint32_t, std::shared_ptr<const scene::ReplacedVertices>> vertices_;
};

}  // namespace fire3dv::passes
