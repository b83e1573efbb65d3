// Camera poses on a circle around a scene; each camera shows the whole scene.
#pragma once

#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::bench {

// aspect: width / height of the images.
std::vector<glm::mat4> circle_of_cameras(const scene::Scene& scene, uint32_t count, float aspect);

}  // namespace fire3dv::bench
