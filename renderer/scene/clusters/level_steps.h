// Steps of a level of detail: grouping of clusters, simplification of a group's surface patch, and its error.
// Each has its own source file; cluster_levels.cpp combines them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Vertex attributes that a material uses.
struct UsedAttributes {
  bool normals = true, tangents = true, uv0 = true, uv1 = true, colors = true;
};
UsedAttributes used_attributes(const Scene& scene, const Primitive& primitive);

// Surface patch with vertices numbered from 0.
struct SurfacePatch {
  std::vector<glm::vec3> positions;
  std::vector<VertexAttributes> attributes;
  std::vector<uint32_t> indices;
};

struct LevelError {
  float appearance = 0;  // total appearance error, node space
  float surface = 0;     // geometric error: maximum distance to a surface of the same facing
};

// Appearance error of a simplified surface, as a length in node space. Each sample of the original is
// compared with its most similar point of the simplification; the worst sample counts. The error of a sample
// combines
//
// - the distance of both points, and the distance by which a texture slides along the surface;
// - for normal and colour, s * sqrt(d / kSeen). A relative difference d over an area of side s changes a
//   pixel of side p by d * (s / p)^2. That is at most kSeen if p is not smaller than this length.
//
// Images whose pixels are larger than the error show at most that difference.
//
// simplified: indices into the vertices of `original`.
LevelError measure_error(const SurfacePatch& original, std::span<const uint32_t> simplified,
                         const UsedAttributes& used);

// Simplification of a surface patch to about half of its triangles, using existing vertices. The border is
// locked, so that adjacent patches fit at any level. meshoptimizer is not used: it ignores attributes, and in
// single precision it cannot separate vertices of finely tessellated smooth surfaces.
//
// welded: welded position of each vertex; bit-equal positions have the same one. Empty if it saves too
// little.
std::vector<uint32_t> simplify_to_half(const SurfacePatch& piece, std::span<const uint32_t> welded,
                                       const UsedAttributes& used);

// Edge of exactly one triangle of the cluster, between two welded positions.
using OpenEdge = uint64_t;
// place_of_corner: welded position of each corner, three per triangle.
std::vector<OpenEdge> open_edges(std::span<const uint32_t> place_of_corner);

struct ClusterGroups {
  std::vector<uint32_t> members;
  std::vector<uint32_t> first{0};  // group g has members first[g] to first[g + 1]
  size_t count() const { return first.size() - 1; }
  std::span<const uint32_t> group(size_t g) const {
    return {members.data() + first[g], first[g + 1] - first[g]};
  }
};

// Groups adjacent clusters with short borders for simplification (greedy). The result is deterministic.
// edges_of: open edges of each cluster. Clusters without shared edges are grouped in their order.
ClusterGroups group_neighbours(std::span<const std::vector<OpenEdge>* const> edges_of);

}  // namespace fire3dv::scene
