// Loaders of the parts of a glTF document, in the order in which load_gltf() calls them, then those that they
// call for skins and morph targets (meshes/gltf_deformation.cpp).
#pragma once

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/gltf/gltf_accessors.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/specular_glossiness.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Validates all indices of the file, including those of unused objects.
Result<void> check_references(const GltfDocument& document);

// used_images: images of the file, which Texture::image indexes; unused images are not decoded.
struct MaterialSources {
  std::vector<uint32_t> used_images;
  std::vector<SpecularGlossinessMaterial> specular_glossiness;  // to be converted when images are decoded
};

// Appends materials (after glTF's default material) and textures.
Result<MaterialSources> add_materials(const GltfDocument& document, Scene& scene);

// Extensions of textures that name an image in another format, the preferred one first.
inline constexpr std::array<const char*, 2> kImageExtensions{"KHR_texture_basisu", "EXT_texture_webp"};

// Image of a texture, -1: none. An extension's image precedes the texture's own, which is the fallback for
// readers without the extension.
int image_of(const tinygltf::Texture& texture);

// Requires materials and textures. Decodes the used images of the file; one that cannot be read becomes a
// placeholder, with a warning.
Result<void> add_images(const GltfDocument& document, std::span<const uint32_t> used,
                        const LoadLimits& limits, const LoadProgress& progress, Scene& scene);

// KHR_materials_variants: names of the file.
Result<void> add_variants(const GltfDocument& document, Scene& scene);

// Scene materials of a primitive: the default one, then that of each variant. Empty: it has no variants.
// Requires add_variants() and a valid material of the primitive.
Result<std::vector<uint32_t>> variant_materials_of(const GltfDocument& document,
                                                   const tinygltf::Primitive& primitive,
                                                   const std::string& where, const Scene& scene);

// Requires the scene's materials and variants.
Result<void> add_meshes(const GltfDocument& document, const LoadLimits& limits, const LoadProgress& progress,
                        Scene& scene);

// Requires meshes. Nodes outside the default scene are omitted. Returns the scene node of each file node, or
// kNone.
Result<std::vector<uint32_t>> add_nodes(const GltfDocument& document, const LoadLimits& limits, Scene& scene);

// KHR_lights_punctual lights and glTF cameras, in file order.
Result<void> add_lights(const GltfDocument& document, Scene& scene);
Result<void> add_cameras(const GltfDocument& document, Scene& scene);

// Requires nodes and morph weights. node_of_source: scene node of each file node, or kNone.
Result<void> add_animations(const GltfDocument& document, const LoadLimits& limits,
                            std::span<const uint32_t> node_of_source, Scene& scene);

// Skins: joints, inverse bind matrices and vertex influences. Accessors JOINTS_n and WEIGHTS_n of a
// primitive; -1: none.
struct InfluenceAccessors {
  std::array<int, 2> joints{-1, -1}, weights{-1, -1};
  auto operator<=>(const InfluenceAccessors&) const = default;
};
Result<InfluenceAccessors> influence_accessors(const tinygltf::Primitive& primitive, const std::string& where,
                                               std::vector<std::string>& warnings);

struct InfluenceRange {
  uint32_t first = kNone, sets = 0, joint_limit = 0;
};
// source: accessor element of each vertex; empty: identity.
Result<InfluenceRange> add_influences(const AccessorReader& reader, const InfluenceAccessors& accessors,
                                      size_t count, std::span<const uint32_t> source,
                                      const std::string& where, Scene& scene);

// Also assigns skins to nodes. node_of_source: scene node of each file node, or kNone.
Result<void> add_skins(const GltfDocument& document, const LoadLimits& limits,
                       std::span<const uint32_t> node_of_source, Scene& scene);

// Morph targets: vertex deltas and rest weights. Accessors of one target; -1: none.
struct MorphAccessors {
  int position = -1, normal = -1, tangent = -1;
  auto operator<=>(const MorphAccessors&) const = default;
};
std::vector<MorphAccessors> morph_accessors(const tinygltf::Primitive& primitive, const std::string& where,
                                            std::vector<std::string>& warnings);

// Fails unless all primitives of the mesh have the same number of targets.
Result<uint32_t> morph_target_count(const tinygltf::Mesh& mesh, const std::string& where);

// Base vertices of a primitive, in the scene's layout.
struct MorphBase {
  size_t source_count = 0;           // elements per accessor
  std::span<const uint32_t> source;  // accessor element of each vertex; empty: identity
  std::span<const glm::vec3> positions;
  std::span<const VertexAttributes> attributes;
  // Triangles with generated flat normals; empty if the file has normals.
  std::span<const uint32_t> flat;
};
struct MorphRange {
  uint32_t first = kNone, count = 0;
};
Result<MorphRange> add_morphs(const AccessorReader& reader, std::span<const MorphAccessors> targets,
                              const MorphBase& base, const std::string& where, Scene& scene);

// Weights of the node, else of its mesh, else 0.
Result<void> add_morph_weights(const GltfDocument& document, const tinygltf::Node& source,
                               const std::string& where, Node& node, Scene& scene);

// Typed access to tinygltf::Value members of extensions and extras.
inline double number_or(const tinygltf::Value& object, const char* member, double otherwise) {
  return object.Has(member) && object.Get(member).IsNumber() ? object.Get(member).GetNumberAsDouble()
                                                             : otherwise;
}

inline int index_or(const tinygltf::Value& object, const char* member, int otherwise) {
  return object.Has(member) ? object.Get(member).GetNumberAsInt() : otherwise;
}

// Clamps a factor to its range, with a warning.
inline float in_range_or_warn(double number, double low, double high, const std::string& name,
                              std::vector<std::string>& warnings) {
  const double taken = std::clamp(number, low, high);
  if (taken != number) {
    char limit[32];
    std::snprintf(limit, sizeof limit, "%g", taken);
    warnings.push_back(name + (number < low ? " is less than " : " is more than ") + limit +
                       ", which is taken in its place");
  }
  return to_float(taken);
}

}  // namespace fire3dv::scene
