// A camera's last image, as far as motion and occlusion need it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>

namespace fire3dv::gpu {
struct Buffer;
}

namespace fire3dv::passes {

// Memory limit of each kind of history: poses, depths, surfaces. The minimum count applies first.
constexpr uint64_t kMaxHistoryBytes = uint64_t{256} << 20;
constexpr uint64_t kMinHistories = 8;

// Poses at a camera's last image, for motion. The owner has one per camera; histories of one frame share the
// poses.
struct CameraHistory {
  // Node transforms of all worlds, then of each world the positions of the vertices that deform.
  std::shared_ptr<gpu::Buffer> poses;
  std::shared_ptr<gpu::Buffer> depth;     // the image's depth plane, for occlusion; null: none
  std::shared_ptr<gpu::Buffer> surfaces;  // SurfaceReference[pixel], for flow to a later image; null: none
  glm::uvec2 depth_size{0};               // pixels; that of surfaces, too
  bool orthographic = false;
  glm::mat4 clip_from_world{1};
  glm::vec3 eye_world{0}, look_world{0};
  glm::vec3 world_from_ndc_x{0}, world_from_ndc_y{0}, world_from_ndc_origin{0};  // as in View
  uint64_t scene = 0;  // SceneRenderer's count of scenes; 0: no image yet
};

// Memory that only certain histories reference, and that their next images replace.
struct ReplacedMemory {
  uint32_t depths = 0;
  bool poses = false;
};

// True if the camera's next image, of this size, may write its depth over that of the history: no other
// history references it.
bool can_replace_depth(const CameraHistory& history, glm::uvec2 image_px);
// What the next images of these cameras replace if they are recorded together. image_px: size of each.
ReplacedMemory replaced_by(std::span<const CameraHistory* const> histories, glm::uvec2 image_px);

}  // namespace fire3dv::passes
