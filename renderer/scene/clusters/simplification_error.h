// Appearance error of a simplified surface, as a length in node space. Each sample of the original is
// compared with its most similar point of the simplification; the worst sample counts. The error of a sample
// combines
//
// - the distance of both points, and the distance by which a texture slides along the surface;
// - for normal and colour, s * sqrt(d / kSeen). A relative difference d over an area of side s changes a
//   pixel of side p by d * (s / p)^2. That is at most kSeen if p is not smaller than this length.
//
// Images whose pixels are larger than the error show at most that difference.
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

// simplified: indices into the vertices of `original`.
LevelError measure_error(const SurfacePatch& original, std::span<const uint32_t> simplified,
                         const UsedAttributes& used);

}  // namespace fire3dv::scene
