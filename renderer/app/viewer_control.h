// From what the user wants (gui::Viewer) to what is shown: once a frame, on the scene and on a camera.
#pragma once

#include <glm/glm.hpp>

#include "renderer/app/camera_rig.h"
#include "renderer/app/live_scene.h"
#include "renderer/app/viewer_input.h"
#include "renderer/gui/viewer.h"
#include "renderer/passes/inspection.h"

namespace fire3dv::app {

// Nodes that have the same paths in the other scene stay what they are; the others are forgotten. So it is
// with lights where the file has one of the same kind, with materials of the same place and name, and with
// those of the same place without a name that the same node wears.
void keep_by_path(gui::Viewer& viewer, const scene::Scene& before, const scene::Scene& after);

// Nothing of one scene holds for another that has nothing to do with it.
void forget_scene(gui::Viewer& viewer);

// What of it changes the scene.
UserEdits edits_of(const gui::Viewer& viewer);

// What an image shows of it, and whether somebody has clicked there. scene_number: comes back with what was
// found, whose numbers are those of that scene.
passes::Inspection inspection_of(const gui::Viewer& viewer, std::optional<glm::vec2>& clicked_px,
                                 glm::uvec2 image_px, uint64_t scene_number);

// Moves the camera as the user does, and does the commands that are for cameras. seconds: since the last
// call.
void move_camera(CameraRig& camera, const CameraMoves& moves, gui::Viewer& viewer,
                 const state::PoseState& poses, glm::uvec2 image_px, float seconds);

// Of two images of that size side by side the one below the cursor is moved; both go with what is followed.
// right: null where there is one image.
void move_cameras(CameraRig& left, CameraRig* right, CameraMoves moves, gui::Viewer& viewer,
                  const state::PoseState& poses, glm::uvec2 image_px, float seconds);

}  // namespace fire3dv::app
