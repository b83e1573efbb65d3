// A piece of surface with about half as many triangles, by the vertices that it has. Its border stays as it is, so that
// the pieces around it fit whatever becomes of them.
#pragma once

#include "renderer/scene/level_error.h"

namespace fire3dv::scene {

// place: of each vertex; those with equal bits have the same one. Empty where it cannot be made much simpler.
std::vector<uint32_t> simplify_to_half(const SurfacePiece& piece, std::span<const uint32_t> place);

}  // namespace fire3dv::scene
