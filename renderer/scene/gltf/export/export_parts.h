// Steps of export_glb.cpp: the JSON of a glTF file, whose buffers and images become parts of one .glb, and
// the edits of its nodes, lights and materials (export_edits.cpp), added nodes (export_additions.cpp) and
// those of other files (export_assets.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/files.h"
#include "renderer/scene/gltf/export/export_glb.h"
#include "renderer/scene/gltf/gltf_container.h"

namespace fire3dv::scene {

constexpr uint64_t kMaxGlbBytes = 0xffff'ff00;  // lengths of a .glb have 32 bits

class GlbExport {
 public:
  using Json = nlohmann::json;
  GlbExport(Json root, const GltfContainer& container, AssetFolder folder, const LoadLimits& limits)
      : root_(std::move(root)), container_(container), folder_(std::move(folder)), limits_(limits) {}

  Result<void> embed_buffers();
  Result<void> embed_images();
  Result<void> apply(const ExportedEdits& edits);
  Result<ExportedGlb> finish();

 private:
  Result<uint64_t> append(std::span<const std::byte> bytes);
  void map_nodes();
  void mark_instance(size_t node);
  std::vector<uint32_t> roots_of(const std::vector<uint32_t>& parents) const;
  using NodeNumbers = std::map<std::string, size_t>;
  NodeNumbers node_names(const std::vector<ExportedNode>& added) const;
  size_t add_nodes(const std::vector<ExportedNode>& nodes);
  std::optional<uint32_t> add_node(const ExportedNode& node);
  // File of added nodes whose data are written.
  struct AddedFile {
    std::vector<uint32_t> nodes;  // of the file, by displayed node; kNone: an instance
    std::vector<uint32_t> roots;
    Json own;  // arrays of objects that each addition has of its own, by name
  };
  Result<const AddedFile*> add_file(const ExportedAsset& asset);
  Result<void> add_asset(const ExportedNode& node, const NodeNumbers& names);
  Result<void> add_displayed_asset(const ExportedNode& node, const NodeNumbers& names);
  void name_roots();
  void take_skins(const std::map<uint32_t, uint32_t>& copies);
  void set_camera(uint32_t node, const Camera& camera);
  void place(Json& node, const ExportedTransform& transform, bool is_animated);
  std::set<uint32_t> animated_nodes() const;
  void hide(const std::set<uint32_t>& sources);
  bool is_lit_below(uint32_t node);
  void hide_around_lights(uint32_t node);
  void hide_node(uint32_t node);
  bool has_light(uint32_t node) const;
  void set_light(uint32_t node, const Light& light);
  void set_variant(size_t variant);
  void set_material(uint32_t number, const MaterialFactors& factors);
  void set_factors(Json& material, const MaterialFactors& factors);
  void set_default_material(size_t first_mesh, size_t mesh_count, const MaterialFactors& factors);
  void use_extension(const char* name, const char* list = "extensionsUsed");
  static const Json* extension(const Json& object, const char* name) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end()) return nullptr;
    const auto found = extensions->find(name);
    return found == extensions->end() ? nullptr : &*found;
  }

  Json root_;
  const GltfContainer& container_;
  const AssetFolder folder_;
  const LoadLimits& limits_;
  std::vector<std::byte> binary_;
  // Materials of the scene that are of one file.
  struct MaterialRange {
    uint32_t first = 0, count = 0;  // in the scene; the first one is glTF's default material
    size_t first_in_file = 0, first_mesh = 0, mesh_count = 0;
  };
  std::vector<MaterialRange> material_ranges_;
  std::map<std::filesystem::path, AddedFile> added_files_;
  std::vector<uint32_t> roots_;        // displayed nodes of the file
  std::vector<uint32_t> added_roots_;  // of a file without scenes
  // Of the scene's nodes: number in the file. kNone: an instance, or a node that is not in the file.
  std::vector<uint32_t> source_of_node_;
  std::vector<bool> is_instance_;               // of the scene's nodes; those behind the last one are none
  std::vector<std::optional<bool>> lit_below_;  // a light is at or below the node of the file
  std::vector<std::string> warnings_;
};

}  // namespace fire3dv::scene
