// Choices of the default look that depend on the scene: where the camera starts, the shadow catcher,
// exposure, and a warning for an empty image.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/camera/camera_rig.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/settings/draw_settings.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// Shadow catcher below the scene. automatic: at its lowest point, with the gradient as background.
enum class GroundMode : uint8_t { automatic, off, height };
// Key light of scenes that bring no light. automatic: without an environment image or lamps beside the lens.
enum class KeyLight : uint8_t { automatic, on, off };

// True if a scene without lights gets a key light.
bool wants_key_light(KeyLight wanted, bool has_chosen_light);

// Choices of the user for the start of all views.
struct ViewDefaults {
  bool frame_all = false;  // moves the camera so that it shows the whole scene
  GroundMode ground = GroundMode::automatic;
  float ground_height_m = 0;  // GroundMode::height: world y
  settings::Background background = settings::Background::automatic();
};

// Start of a view with this camera. animations: those that play.
CameraStart camera_start(const ViewDefaults& defaults, const scene::Scene& scene, const std::string& camera,
                         std::vector<uint32_t> animations);

// Applies the wanted exposure, or the estimate for the scene, to settings that have their environment.
// Returns a log line if the estimate differs from 1, else an empty string.
std::string set_exposure(const settings::PostSettings& wanted, const scene::Scene& scene,
                         settings::DrawSettings& settings);

// Likely reason why the image shows nothing of the scene; nullopt if something should be visible.
std::optional<std::string> reason_for_empty_image(const scene::Scene& scene, const scene::SceneEdits* edits,
                                                  const state::PoseState& poses, const passes::View& view,
                                                  uint32_t image_height);

}  // namespace fire3dv::app
