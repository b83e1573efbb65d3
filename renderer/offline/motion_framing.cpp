#include "renderer/offline/motion_framing.h"

#include <algorithm>

#include "renderer/passes/view/framing.h"

namespace fire3dv::offline {

Result<std::vector<glm::vec3>> points_over_motion(const scene::Scene& scene,
                                                  const RecordedStreams::Open& open_recording,
                                                  const Timeline& timeline, const FrameTimes& times,
                                                  const std::function<bool()>& should_stop) {
  constexpr uint64_t kMaxSamples = 24;
  state::PoseState poses(scene);
  auto streams = RecordedStreams::open(open_recording, timeline, poses);
  if (!streams) return streams.error();
  std::vector<glm::vec3> points;
  std::vector<glm::mat4> world_from_node(scene.nodes.size());
  const uint64_t samples = std::min(times.frames, kMaxSamples);
  for (uint64_t i = 0; i < samples && !should_stop(); ++i) {
    const uint64_t frame = samples == 1 ? 0 : i * (times.frames - 1) / (samples - 1);
    streams->advance(times.at_ns(frame));
    for (uint32_t node = 0; node < world_from_node.size(); ++node)
      world_from_node[node] = poses.world_from_node(node);
    const std::vector<glm::vec3> moved = passes::framing_points(scene, world_from_node);
    points.insert(points.end(), moved.begin(), moved.end());
  }
  return points;
}

}  // namespace fire3dv::offline
