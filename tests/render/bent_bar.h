// A bar that bends and bulges: drawn as skin and morph target by the GPU, and computed here vertex by vertex
// as shapes that stay as they are.
#pragma once

#include "renderer/state/animation.h"
#include "tests/render/scene_builder.h"

namespace fire3dv::test {

struct BarPose {
  glm::mat4 world_from_root{1};
  glm::mat4 root_from_tip{1};
  float bulge = 0;  // the morph target's weight
};

// On a ground, under a sun, seen by a camera. The upper half of the bar is alpha-masked and has a normal map.
// Beside it the same mesh stands without a skin, as it was modelled.
scene::Scene skinned_bar(const BarPose& pose);
scene::Scene computed_bar(const BarPose& pose);

// The rest pose of skinned_bar() moved to another one.
state::RestPose moved(const scene::Scene& skinned, const BarPose& pose);

// The bar with its morph target alone, at a node that mirrors it.
scene::Scene morphed_bar(float bulge);
scene::Scene computed_morphed_bar(float bulge);

}  // namespace fire3dv::test
