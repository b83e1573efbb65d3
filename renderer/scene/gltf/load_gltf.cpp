#include "renderer/scene/gltf/load_gltf.h"

#include <exception>
#include <new>

#include "base/json/json_fault.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/gltf_parts.h"
#include "renderer/scene/model/bounds.h"

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
    for (const auto& [name, extension] : model.textures[i].extensions) {
      references.check(index_or(extension, "source", -1), document.images.size(),
                       element("textures", i) + ".extensions." + name, "images");
    }
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

namespace {

Result<Scene> load(Result<GltfDocument> document, const std::filesystem::path& source,
                   const LoadLimits& limits, const LoadProgress& progress) {
  if (!document) return document.error();
  Scene scene;
  scene.source = source;
  scene.warnings = std::move(document->warnings);
  auto materials = add_materials(*document, scene);
  if (!materials) return materials.error();
  if (auto done = add_variants(*document, scene); !done) return done.error();
  if (auto done = add_meshes(*document, limits, progress, scene); !done) return done.error();
  if (auto done = add_lights(*document, scene); !done) return done.error();
  if (auto done = add_cameras(*document, scene); !done) return done.error();
  auto node_of_source = add_nodes(*document, limits, scene);
  if (!node_of_source) return node_of_source.error();
  if (auto done = add_skins(*document, limits, *node_of_source, scene); !done) return done.error();
  if (auto done = add_animations(*document, limits, *node_of_source, scene); !done) return done.error();
  if (auto done = check_deformed_copies(scene); !done) return done.error();
  if (auto done = add_images(*document, materials->used_images, limits, progress, scene); !done)
    return done.error();
  if (auto done = convert_specular_glossiness(materials->specular_glossiness, limits, scene); !done)
    return done.error();
  bound_deformed_primitives(scene);
  find_world_bounds(scene);
  return scene;
}

// Libraries and the allocator (for files that exceed this machine's memory) throw; converts to errors.
template <typename Load>
Result<Scene> guarded(const std::string& file, const Load& load_it) {
  try {
    Result<Scene> scene = load_it();
    if (scene) return scene;
    return Error{file + ": " + scene.error().message};
  } catch (const std::bad_alloc&) {
    return Error{file + ": it does not fit into memory"};
  } catch (const std::exception& error) {
    return Error{file + ": it cannot be read: " + json_fault(error.what())};
  }
}

}  // namespace

Result<Scene> load_glb(std::span<const std::byte> file, const std::string& name, const LoadLimits& limits) {
  return guarded(name, [&] { return load(read_glb(file, limits), name, limits, {}); });
}

Result<Scene> load_gltf(const std::filesystem::path& path, const LoadLimits& limits,
                        const LoadProgress& progress, std::vector<SourceFile>* sources,
                        const StampedDigest* known) {
  return guarded(path.string(),
                 [&] { return load(open_gltf(path, limits, sources, known), path, limits, progress); });
}

}  // namespace fire3dv::scene
