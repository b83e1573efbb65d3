// Motion history of a camera.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>

namespace fire3dv::gpu {
struct Buffer;
}

namespace fire3dv::passes {

// Node transforms at a camera's last image, for motion. The owner has one per camera; histories of one frame
// share the transforms.
struct CameraHistory {
  std::shared_ptr<gpu::Buffer> world_from_node;
  glm::mat4 clip_from_world{1};
  uint64_t scene = 0;  // SceneRenderer's count of scenes; 0: no image yet
};

}  // namespace fire3dv::passes
