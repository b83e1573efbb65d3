// Which pixels a scene at rest covers, computed on the CPU from the standard's formulas: skins and morph
// targets vertex by vertex, then each pixel's middle against each triangle. No code of the passes takes part.
#pragma once

#include <optional>

#include "renderer/passes/view.h"
#include "renderer/scene/scene.h"

namespace fire3dv::test {

// Nothing where that is no matter of triangles alone: lines, points, and surfaces with holes in their alpha.
std::optional<uint32_t> computed_coverage(const scene::Scene& scene, const passes::View& view, uint32_t side);

}  // namespace fire3dv::test
