// Spatial tendons of MJCF: their paths over sites and around geoms, in one pose.
#pragma once

#include "convert/mjcf/assets/mjcf_source.h"
#include "convert/mjcf/bodies/mjcf_kinematics.h"
#include "convert/mjcf/bodies/mjcf_tree.h"
#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Adds all tendons of the model and of its copies to the scene; those that are not drawn have no points.
void add_tendons(const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene);

}  // namespace fire3dv::convert
