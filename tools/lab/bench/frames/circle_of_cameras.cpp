#include "tools/lab/bench/frames/circle_of_cameras.h"

#include <cmath>

#include "renderer/passes/view.h"

namespace fire3dv::bench {

std::vector<glm::mat4> circle_of_cameras(const scene::Scene& scene, uint32_t count, float aspect) {
  std::vector<glm::mat4> world_from_camera;
  const glm::vec3 middle = 0.5f * (scene.bounds_min + scene.bounds_max);
  const glm::mat4 first =
      passes::framing_camera_pose(scene::Camera(), aspect, scene.bounds_min, scene.bounds_max);
  const glm::vec3 from = glm::vec3(first[3]) - middle;
  for (uint32_t i = 0; i < count; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(count);
    const float c = std::cos(angle), s = std::sin(angle);
    const glm::vec3 turned(c * from.x + s * from.z, from.y, c * from.z - s * from.x);
    world_from_camera.push_back(passes::look_at_pose(middle + turned, middle));
  }
  return world_from_camera;
}

}  // namespace fire3dv::bench
