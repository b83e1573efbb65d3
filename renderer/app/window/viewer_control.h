// Viewer control: applies the user's requests (gui::Viewer) to scene and cameras, once per frame.
#pragma once

#include <glm/glm.hpp>

#include "renderer/app/loading/live_scene.h"
#include "renderer/app/window/camera_rig.h"
#include "renderer/app/window/viewer_input.h"
#include "renderer/gui/viewer.h"
#include "renderer/passes/debug/inspection.h"

namespace fire3dv::app {

// Transfers selections and edits to another scene by node path; drops nodes that do not exist there. Lights
// need a file light of the same kind. Materials need the same index and name; unnamed ones the same first
// user.
void transfer_by_path(gui::Viewer& viewer, const scene::Scene& before, const scene::Scene& after);

// Clears everything that refers to a scene, for an unrelated scene.
void forget_scene(gui::Viewer& viewer);

// Edits of the scene.
UserEdits edits_of(const gui::Viewer& viewer);

// Inspection settings of an image, including picking at a click. scene_number: returned with the picked node,
// which belongs to that scene.
passes::Inspection inspection_of(const gui::Viewer& viewer, std::optional<glm::vec2>& clicked_px,
                                 glm::uvec2 image_px, uint64_t scene_number);

// Moves the camera and executes camera commands. seconds: since the last call.
void move_camera(CameraRig& camera, const CameraMoves& moves, gui::Viewer& viewer,
                 const state::PoseState& poses, glm::uvec2 image_px, float seconds);

// Two images of this size side by side: moves the camera under the cursor; both follow the followed node.
// right: null for a single image.
void move_cameras(CameraRig& left, CameraRig* right, CameraMoves moves, gui::Viewer& viewer,
                  const state::PoseState& poses, glm::uvec2 image_px, float seconds);

}  // namespace fire3dv::app
