// Steps of export_glb.cpp: the JSON of a glTF file, whose buffers and images become parts of one .glb, and
// the edits of its nodes, lights and materials (export_edits.cpp).
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
  std::vector<uint32_t> roots_of(const std::vector<uint32_t>& parents) const;
  std::map<std::string, size_t> node_names(const std::vector<ExportedNode>& added) const;
  size_t add_nodes(const std::vector<ExportedNode>& nodes);
  std::optional<uint32_t> add_node(const ExportedNode& node);
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
  void use_extension(const char* name);
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
  std::vector<uint32_t> source_of_node_;        // of the scene's nodes; kNone: an instance
  std::vector<std::optional<bool>> lit_below_;  // a light is at or below the node of the file
  std::vector<std::string> warnings_;
};

}  // namespace fire3dv::scene
