// Skins of MJCF: meshes whose vertices follow bodies.
#pragma once

#include "convert/mjcf/assets/mjcf_source.h"
#include "convert/mjcf/bodies/mjcf_kinematics.h"
#include "convert/mjcf/bodies/mjcf_tree.h"
#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Adds the skins of the model and of its copies to the scene. A skin that cannot be read is a warning.
void add_skins(const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene);

// Moves the vertices of a skin whose vertices follow one body each to that body's pose, and makes it the bind
// pose: normals and inflation are then those of the pose.
void bind_to_pose(const MjcfPosedBodies& posed, double inflation, MjcfSkin& skin);

}  // namespace fire3dv::convert
