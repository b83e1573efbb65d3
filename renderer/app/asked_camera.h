// The camera of an image that a simulator asked for: from its words to a projection and a place.
#pragma once

#include <string>
#include <variant>

#include "protocol/error.h"
#include "protocol/wire/image.h"
#include "renderer/app/live_scene.h"
#include "renderer/passes/lens.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

struct AskedCamera {
  passes::Intrinsics intrinsics;
  passes::Lens lens;
  passes::Intrinsics pinhole;      // that is drawn: the same, or what stands behind the lens
  glm::mat4 world_from_camera{1};  // a rotation and a place
  float exposure = 0;              // 0: as the settings say
};

struct AskedCameraRefused {
  wire::ImageRefusal reason;
  std::string why;
};

// world_from_stream: of the stream that asks.
std::variant<AskedCamera, AskedCameraRefused> asked_camera(const wire::ImageRequest& request,
                                                           const wire::Affine3x4d& world_from_stream,
                                                           const state::PoseState& poses,
                                                           const LiveScene& scene);

wire::Affine3x4 affine_of(const glm::mat4& matrix);

}  // namespace fire3dv::app
