// Reference scenes for deformation: a bar that bends and bulges, as skin and morph target for the GPU, and as
// static meshes computed per vertex on the CPU.
#pragma once

#include "renderer/state/motion/animation.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

struct BarPose {
  glm::mat4 world_from_root{1};
  glm::mat4 root_from_tip{1};
  float bulge = 0;  // weight of the morph target
};

// The bar on a ground, under a sun, before a camera. Its upper half is alpha-masked and has a normal map. The
// same mesh without a skin stands beside it in its bind pose.
scene::Scene skinned_bar(const BarPose& pose);
scene::Scene computed_bar(const BarPose& pose);

// Returns the rest pose of skinned_bar() changed to another bar pose.
state::RestPose moved(const scene::Scene& skinned, const BarPose& pose);

// The bar with its morph target alone, at a node with a mirroring transform.
scene::Scene morphed_bar(float bulge);
scene::Scene computed_morphed_bar(float bulge);

}  // namespace fire3dv::test
