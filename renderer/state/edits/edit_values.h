// Values of scene edits as the wire has them, converted to those of the scene.
#pragma once

#include <cstdint>

#include "protocol/wire/scene_edit.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::state {

// Converts a light edit of a node. Properties that the wire format lacks (name, source size) come from the
// file.
scene::Light to_scene_light(const wire::Light& from, const scene::Scene& scene, uint32_t node);

// Converts a camera edit of a node. The name comes from the file.
scene::Camera to_scene_camera(const wire::Camera& from, const scene::Scene& scene, uint32_t node);

// True for edits that hide the node and its descendants.
bool hides_subtree(const wire::EditValue& value);

}  // namespace fire3dv::state
