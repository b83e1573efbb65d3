// How much a simplified piece of surface differs from what it was made from, as it looks.
//
// Every sample of the original is held against the point of the simplification that resembles it most; the
// worst sample counts. A sample differs by
// - the distance between the two points, and the distance by which a texture has slid along the surface:
// lengths, which
//   show as lengths;
// - its normal and colour. Off by a share d over an area of side s, they change a pixel of side p by d * (s /
// p)^2. That
//   is no more than a share of kSeen of the pixel's light where s * sqrt(d / kSeen) <= p: so that is their
//   length.
// A picture whose pixels are larger than the error shows no more than that difference.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

struct LookedAt {  // what a material shows of vertices
  bool normals = true, tangents = true, uv0 = true, uv1 = true, colors = true;
};
LookedAt looked_at(const Scene& scene, const Primitive& primitive);

// A piece of surface, its vertices numbered from 0.
struct SurfacePiece {
  std::vector<glm::vec3> positions;
  std::vector<VertexAttributes> attributes;
  std::vector<uint32_t> indices;
};

struct LevelError {
  float looks = 0;    // all of the above, node space
  float surface = 0;  // from the farthest sample to what faces its way there, however that looks
};

// simplified: indices into the vertices of `original`.
LevelError measure_error(const SurfacePiece& original, std::span<const uint32_t> simplified,
                         const LookedAt& looked_at);

}  // namespace fire3dv::scene
