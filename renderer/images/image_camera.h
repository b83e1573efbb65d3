// Camera of an image request: projection, pose, and the appearance that goes with it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <variant>

#include "protocol/wire/image.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/passes/post/lens_pass.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/ground.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// Camera of a scene node.
struct NodeCamera {
  scene::Camera camera;
  glm::mat4 world_from_camera{1};  // may have scale, but no shear
};

struct ImageCamera {
  passes::Intrinsics intrinsics;
  passes::Lens lens;
  passes::Intrinsics pinhole;  // rendered projection: the same, or the pinhole image before lens distortion
  glm::mat4 world_from_camera{1};  // rigid transform
  // With the intrinsics of a node's camera: that camera, drawn as in the window and with the same rounding.
  std::optional<NodeCamera> node_camera;
  float exposure = 0;         // 0: from the draw settings
  scene::ThinLens thin_lens;  // of the request, else of the node's camera
  std::optional<scene::Ground> ground;
  bool markers = false;
  // Paths: the image has more than so many samples, and is sent early. nullopt: it is sent when it is whole.
  std::optional<uint32_t> shown_samples;
  bool keeps_samples = false;  // paths: the image goes on after those of others
  bool in_motion = false;      // see passes::FrameRequest
};

struct CameraRefused {
  wire::ImageRefusal reason;
  std::string why;
};

// Resolves a request. world_from_stream: of the requesting stream.
std::variant<ImageCamera, CameraRefused> resolve_camera(const wire::ImageRequest& request,
                                                        const wire::Affine3x4d& world_from_stream,
                                                        const state::PoseState& poses,
                                                        const LiveScene& scene);

// View of the rendered projection, without ground and lens.
passes::View pinhole_view(const ImageCamera& camera);

wire::Affine3x4 affine_of(const glm::mat4& matrix);

}  // namespace fire3dv::app
