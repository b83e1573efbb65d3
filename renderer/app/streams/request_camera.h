// Camera of an image request: resolves the request to a projection and a camera pose.
#pragma once

#include <string>
#include <variant>

#include "protocol/base/error.h"
#include "protocol/wire/image.h"
#include "renderer/app/loading/live_scene.h"
#include "renderer/passes/post/lens.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

struct RequestCamera {
  passes::Intrinsics intrinsics;
  passes::Lens lens;
  passes::Intrinsics pinhole;  // rendered projection: the same, or the pinhole image before lens distortion
  glm::mat4 world_from_camera{1};  // rigid transform
  float exposure = 0;              // 0: from the draw settings
};

struct CameraRefused {
  wire::ImageRefusal reason;
  std::string why;
};

// world_from_stream: of the requesting stream.
std::variant<RequestCamera, CameraRefused> resolve_camera(const wire::ImageRequest& request,
                                                          const wire::Affine3x4d& world_from_stream,
                                                          const state::PoseState& poses,
                                                          const LiveScene& scene);

wire::Affine3x4 affine_of(const glm::mat4& matrix);

}  // namespace fire3dv::app
