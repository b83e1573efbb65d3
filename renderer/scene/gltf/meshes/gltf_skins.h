// glTF skin loader: joints, inverse bind matrices and vertex influences.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/gltf/meshes/gltf_accessors.h"

namespace fire3dv::scene {

// Accessors JOINTS_n and WEIGHTS_n of a primitive; -1: none.
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

}  // namespace fire3dv::scene
