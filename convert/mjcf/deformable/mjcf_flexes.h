// Flexes of MJCF: deformable objects whose vertices are, or follow, bodies.
#pragma once

#include "convert/mjcf/assets/mjcf_source.h"
#include "convert/mjcf/bodies/mjcf_kinematics.h"
#include "convert/mjcf/bodies/mjcf_tree.h"
#include "convert/mjcf/deformable/flex_shape.h"
#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Adds the skins of the tree, and those of flex elements of the model and of its copies, to the scene as
// skins. A flex that cannot be read is a warning.
void add_flexes(const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene);

// Group, colour and material of a flex or flexcomp element.
MjcfSkin flex_appearance(MjcfSource& source, const MjcfAttributes& from, MjcfScene& scene);

// Numbers of an attribute; an empty list where there is none. The error says that it holds something else.
Result<std::vector<double>> flex_numbers(const MjcfAttributes& from, const char* attribute);

// Fills points, elements and texture coordinates from attributes. The error is a sentence end about the
// object.
Result<void> read_flex_shape(const MjcfAttributes& from, const char* points, FlexShape& shape);

// Surface of the shape for a skin whose vertices follow the influences of their points.
void set_flex_surface(const FlexShape& shape, const std::vector<Influences>& influences, double radius,
                      bool is_flat, MjcfSkin& skin);

}  // namespace fire3dv::convert
