#include "renderer/scene/gltf/gltf_parts.h"

namespace fire3dv::scene {
namespace {

// Collects the first invalid index; -1 is a missing optional reference.
class References {
 public:
  void check(int index, size_t size, const std::string& from, const char* array) {
    if (fault_.message.empty() && index != -1 && !in_range(index, size))
      fault_ = out_of_range(from, array, index, size);
  }
  void check_all(const std::vector<int>& indices, size_t size, const std::string& from, const char* array) {
    for (const int index : indices) check(index, size, from, array);
  }
  Result<void> result() const { return fault_.message.empty() ? Result<void>() : Result<void>(fault_); }

 private:
  Error fault_;  // the first one
};

void check_data(const GltfDocument& document, References& references) {
  const tinygltf::Model& model = document.model;
  for (size_t i = 0; i < model.bufferViews.size(); ++i) {
    references.check(model.bufferViews[i].buffer, document.buffers.size(), element("bufferViews", i),
                     "buffers");
  }
  for (size_t i = 0; i < model.accessors.size(); ++i) {
    references.check(model.accessors[i].bufferView, model.bufferViews.size(), element("accessors", i),
                     "bufferViews");
  }
  for (size_t i = 0; i < document.images.size(); ++i) {
    references.check(document.images[i].buffer_view, model.bufferViews.size(), element("images", i),
                     "bufferViews");
  }
  for (size_t i = 0; i < model.textures.size(); ++i) {
    references.check(model.textures[i].source, document.images.size(), element("textures", i), "images");
    references.check(model.textures[i].sampler, model.samplers.size(), element("textures", i), "samplers");
  }
}

void check_meshes(const tinygltf::Model& model, References& references) {
  for (size_t m = 0; m < model.meshes.size(); ++m) {
    for (size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
      const std::string where = element("meshes", m) + "." + element("primitives", p);
      references.check(primitive.material, model.materials.size(), where, "materials");
      for (const auto& [name, accessor] : primitive.attributes) {
        references.check(accessor, model.accessors.size(), where + "." + name, "accessors");
      }
    }
  }
}

void check_hierarchy(const tinygltf::Model& model, References& references) {
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    const std::string where = element("nodes", i);
    references.check(model.nodes[i].mesh, model.meshes.size(), where, "meshes");
    references.check(model.nodes[i].camera, model.cameras.size(), where, "cameras");
    references.check_all(model.nodes[i].children, model.nodes.size(), where + ".children", "nodes");
  }
  for (size_t i = 0; i < model.scenes.size(); ++i) {
    references.check_all(model.scenes[i].nodes, model.nodes.size(), element("scenes", i), "nodes");
  }
  references.check(model.defaultScene, model.scenes.size(), "scene", "scenes");
}

}  // namespace

Result<void> check_references(const GltfDocument& document) {
  References references;
  check_data(document, references);
  check_meshes(document.model, references);
  check_hierarchy(document.model, references);
  return references.result();
}

}  // namespace fire3dv::scene
