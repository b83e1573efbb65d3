// Collector of the data that the window's panels display, once per image.
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/app/frame_stats.h"
#include "renderer/app/loading/live_scene.h"
#include "renderer/app/streams/stream_receiver.h"
#include "renderer/gui/facts.h"
#include "renderer/passes/scene_renderer.h"

namespace fire3dv::app {

class ViewerFacts {
 public:
  explicit ViewerFacts(std::chrono::steady_clock::time_point begun) : begun_(begun) {}

  // Call as events occur.
  void note(const std::string& sentence);
  void drawn(const FrameCost& cost);
  void add(const gpu::FrameTimes& times);

  // scene: the renderer's scene, with a unique scene_number. camera_node: kNone for a free camera.
  const gui::Facts& begin_assembly(const scene::Scene& scene, uint64_t scene_number,
                                   const StreamReceiver& receiver, const state::PoseState& poses,
                                   const passes::SceneRenderer& renderer, const gpu::Device& device,
                                   uint32_t camera_node, bool recording_video);

 private:
  struct Rate {
    uint64_t sequence = 0;
    std::chrono::steady_clock::time_point since;
    double hz = 0;
    bool is_known = false;
  };
  void set_scene(const scene::Scene& scene, uint64_t scene_number, const passes::SceneRenderer& renderer);
  gui::StreamFact stream_fact(const StreamReceiver::Report& report, const StreamReceiver& receiver,
                              const state::PoseState& poses);
  double rate_of(uint64_t epoch, uint64_t sequence);

  const std::chrono::steady_clock::time_point begun_;
  gui::Facts facts_;
  std::map<uint64_t, Rate> rates_;  // by epoch
  std::chrono::steady_clock::time_point memory_read_at_{};
  std::vector<uint32_t> cameras_;  // camera nodes of scene cameras_of_
  std::optional<uint64_t> cameras_of_;
  std::optional<std::pair<uint64_t, uint64_t>> counted_;  // scene and draw list of the counted triangles
};

}  // namespace fire3dv::app
