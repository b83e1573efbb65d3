// Choices of the default look that depend on the scene: where the camera starts, the shadow catcher,
// exposure, and a warning for an empty image.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/options/options.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// True if a scene without lights gets a key light.
bool wants_key_light(const Options& options);

// Start of a view with this camera. animations: those that play.
CameraStart camera_start(const Options& options, const scene::Scene& scene, const std::string& camera,
                         std::vector<uint32_t> animations);

// Applies the exposure of the options, or the estimate for the scene. Returns a log line if the estimate
// differs from 1, else an empty string.
std::string set_exposure(const Options& options, const scene::Scene& scene, passes::DrawSettings& settings);

// Likely reason why the image shows nothing of the scene; nullopt if something should be visible.
std::optional<std::string> reason_for_empty_image(const scene::Scene& scene, const scene::SceneEdits* edits,
                                                  const state::PoseState& poses, const passes::View& view,
                                                  uint32_t image_height);

}  // namespace fire3dv::app
