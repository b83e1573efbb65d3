// Interface of runs that draw more than colours of one camera: cameras, outputs and files of a data set.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/offline/frame_format.h"
#include "renderer/offline/image_changes.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::offline {

// Image k is of frame k / cameras() and camera k % cameras().
class ImageSet {
 public:
  virtual ~ImageSet() = default;

  virtual wire::ImageOutputs outputs() const = 0;
  // Nodes or cameras, or "auto"; empty: the one of the drawing options.
  virtual const std::vector<std::string>& cameras() const = 0;
  // Images have flow to those so many frames later and earlier; 0: none.
  virtual uint32_t flow_frames() const { return 0; }
  // False: flow to the earlier image alone.
  virtual bool has_flow_forward() const { return true; }
  // True: images have the planes of motion and occlusion themselves, in place of the flow.
  virtual bool has_motion_planes() const { return false; }
  // The scene that is drawn in place of the loaded one. Null: that one. Before all other calls.
  virtual Result<std::unique_ptr<const scene::LoadedScene>> prepare_scene(const scene::LoadedScene&) {
    return std::unique_ptr<const scene::LoadedScene>();
  }
  // Adds the settings that determine the bytes of files to those of the manifest. After the scene is loaded
  // and before anything is written.
  using Settings = std::vector<std::pair<std::string, std::string>>;
  // gltf_file: of the scene, or its conversion.
  virtual Result<std::shared_ptr<FrameFormat>> open_format(const scene::Scene& scene,
                                                           const std::filesystem::path& gltf_file,
                                                           Settings& settings) = 0;
  // Checks a camera, by its index, with additions and edits of the overlay file. Before the first image.
  virtual Result<void> check_camera(size_t index, const app::CameraRig::Placed& camera) const = 0;
  // Changes from image to image. Null: there are none.
  virtual ImageChanges* changes() { return nullptr; }
  // The other camera of a stereo pair. nullopt: there is none.
  virtual std::optional<size_t> other_of_pair(size_t) const { return {}; }
  // Poses of an image that is drawn now, before its pixels are ready. other: of the stereo pair, or null. On
  // the main thread.
  virtual void add_poses(uint64_t image, const app::CameraRig::Placed& camera,
                         const app::CameraRig::Placed* other, const state::PoseState& poses) = 0;
};

}  // namespace fire3dv::offline
