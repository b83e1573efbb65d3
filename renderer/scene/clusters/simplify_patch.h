// Simplification of a surface patch to about half of its triangles, using existing vertices. The border is
// locked, so that adjacent patches fit at any level. meshoptimizer is not used: it ignores attributes, and in
// single precision it cannot separate vertices of finely tessellated smooth surfaces.
#pragma once

#include "renderer/scene/clusters/simplification_error.h"

namespace fire3dv::scene {

// place: welded position of each vertex; bit-equal positions have the same one. Empty if it saves too little.
std::vector<uint32_t> simplify_to_half(const SurfacePatch& piece, std::span<const uint32_t> place,
                                       const UsedAttributes& used);

}  // namespace fire3dv::scene
