// CPU reference of pixel coverage for a scene at rest, from the formulas of the glTF specification:
// per-vertex skinning and morphing, then each pixel centre against each triangle. It uses no code of the
// passes.
#pragma once

#include <optional>

#include "renderer/passes/view/view.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::test {

// Returns nothing if triangles alone do not determine the coverage: lines, points, alpha-masked surfaces.
std::optional<uint32_t> computed_coverage(const scene::Scene& scene, const passes::View& view, uint32_t side);

}  // namespace fire3dv::test
