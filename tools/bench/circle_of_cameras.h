// Cameras on a circle around a scene, each of which sees all of it.
#pragma once

#include <vector>

#include "renderer/scene/scene.h"

namespace fire3dv::bench {

// aspect: width by height of their images.
std::vector<glm::mat4> circle_of_cameras(const scene::Scene& scene, uint32_t count, float aspect);

}  // namespace fire3dv::bench
