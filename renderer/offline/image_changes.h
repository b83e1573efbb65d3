// Interface of changes of a scene from image to image, such as randomisation. Each is a function of the
// number of the frame or image alone, so that parts and continued runs draw the same images.
#pragma once

#include <cstdint>

#include "base/error.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/scene/model/scene.h"
#include "renderer/settings/draw_settings.h"
#include "renderer/state/edits/user_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::offline {

// Methods are called on the main thread, in the order of this list for each frame.
class ImageChanges {
 public:
  virtual ~ImageChanges() = default;

  // The scene that is displayed from now on; must outlive its use. Before the first frame, and after the
  // scene was replaced. settings: unchanged ones.
  virtual Result<void> set_scene(const scene::Scene& scene, const settings::DrawSettings& settings) = 0;
  // Changes the edits and settings of a frame; those given are unchanged ones.
  // An environment image that they get is of a new renderer.
  virtual Result<void> change_frame(uint64_t frame, state::UserEdits& edits,
                                    settings::DrawSettings& settings) = 0;
  // Adds transforms that depend on the poses of the frame, in which change_frame() and the transforms of
  // earlier calls are in effect. Called again until it returns false, for none.
  virtual Result<bool> add_transforms(const state::PoseState& poses, state::NodeTransforms& transforms) = 0;
  // Changes the camera of an image of the frame, by its index.
  virtual void change_camera(uint64_t image, const state::PoseState& poses,
                             app::CameraRig::Placed& camera) = 0;
  // Cameras get lenses. Before the first frame.
  virtual bool has_lens() const = 0;
};

}  // namespace fire3dv::offline
