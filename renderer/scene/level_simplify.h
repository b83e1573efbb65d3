// A piece of surface with about half as many triangles, by the vertices that it has. Its border stays as it
// is, so that the pieces around it fit whatever becomes of them. The library's own simplification knows no
// attributes, and in single precision it cannot tell the vertices of a finely tessellated smooth surface
// apart.
#pragma once

#include "renderer/scene/level_error.h"

namespace fire3dv::scene {

// place: of each vertex; those with equal bits have the same one. Empty where it cannot be made much simpler.
std::vector<uint32_t> simplify_to_half(const SurfacePiece& piece, std::span<const uint32_t> place,
                                       const LookedAt& looked_at);

}  // namespace fire3dv::scene
