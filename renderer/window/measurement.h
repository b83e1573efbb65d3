// Picked points of the window and its measuring tool.
#pragma once

#include <optional>
#include <string>

#include "renderer/editing/view_state.h"
#include "renderer/passes/debug/inspection.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// The picked point, fixed to its node. A node that is flattened to a plane, so that its transform has no
// inverse, gives a point at rest in the world.
SurfacePoint surface_point(const passes::Picked& picked);

// Applies a click on the image: it selects the node, or with the measuring tool chooses the next of two
// points; a third one starts again. Returns the log message of a complete measurement.
std::optional<std::string> take_pick(ViewState& view_state, const passes::Picked& picked,
                                     const state::PoseState& poses);

// "1.2346 m"
std::string metres_text(float metres);

}  // namespace fire3dv::app
