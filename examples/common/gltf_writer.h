// Writer of glTF 2.0 scenes as GLB files. Each add_ function returns the glTF index of the new element.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/glb.h"
#include "examples/common/mesh.h"

namespace examples {

struct GltfMaterial {
  std::string name;
  std::array<float, 3> base_color{1, 1, 1};  // linear
  float metallic = 0;
  float roughness = 0.5f;
  std::array<float, 3> emissive{0, 0, 0};  // linear
  std::optional<size_t> base_color_texture, metallic_roughness_texture, normal_texture;
  std::optional<float> specular = std::nullopt, ior = std::nullopt;  // KHR_materials_specular, _ior
  float transmission = 0;                                            // KHR_materials_transmission
  float thickness_m = 0;  // KHR_materials_volume without absorption; 0: none
};

struct GltfLight {
  std::string name;
  std::string type;  // "directional", "point" or "spot"
  std::array<float, 3> color{1, 1, 1};
  float intensity = 1;  // candela, or lux for directional lights
  float inner_cone_rad = 0;
  float outer_cone_rad = 0.7853982f;
};

// parent_from_node, 3x4, row-major.
using GltfMatrix = std::array<float, 12>;

class GltfWriter {
 public:
  size_t add_texture(const std::string& name, std::span<const uint8_t> png);
  size_t add_material(const GltfMaterial& material);
  struct Primitive {
    const Mesh* mesh = nullptr;  // in glTF axes; v grows upwards in the image
    size_t material = 0;
    float uv_scale = 1;
  };
  size_t add_mesh(const std::string& name, std::span<const Primitive> primitives);
  size_t add_camera(const std::string& name, float vertical_fov_rad, float near_m);
  size_t add_light(const GltfLight& light);

  struct Node {
    std::string name;
    GltfMatrix parent_from_node{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    std::optional<size_t> mesh, camera, light;
  };
  // Adds a node to the scene. finish() puts all nodes below one root node.
  void add_node(const Node& node);

  std::vector<std::byte> finish(const std::string& root_name, const std::string& generator) const;

 private:
  size_t add_accessor(size_t view, int component_type, size_t count, const char* type,
                      const std::string& extra);

  fire3dv::base::GlbBuffer buffer_;
  std::vector<std::string> accessors_, images_, textures_, materials_, meshes_, cameras_, lights_, nodes_;
  std::set<std::string> extensions_used_;
};

}  // namespace examples
