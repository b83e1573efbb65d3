// Points of a scene over the motion of a recording, for a camera that frames all of it.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "base/error.h"
#include "renderer/offline/recorded_streams.h"
#include "renderer/offline/timeline.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::offline {

// framing_points() at up to 24 frames of all shards, evenly spread. What streams add to the scene is left
// out. Reads the recording once.
Result<std::vector<glm::vec3>> points_over_motion(const scene::Scene& scene,
                                                  const RecordedStreams::Open& open_recording,
                                                  const Timeline& timeline, const FrameTimes& times,
                                                  const std::function<bool()>& should_stop);

}  // namespace fire3dv::offline
