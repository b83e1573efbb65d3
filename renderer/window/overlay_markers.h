// Markers that the window adds to its images: the ground grid, camera frusta, and the measured points with
// their distance. They are drawn as markers of streams are. Requested images and files of --out do not have
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <vector>

#include "protocol/wire/marker.h"
#include "renderer/editing/view_state.h"
#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/marker_registry.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

class OverlayMarkers {
 public:
  static constexpr size_t kMaxFrusta = 256;

  // Scene and camera of the next image.
  struct ImageView {
    const scene::Scene& scene;
    const scene::SceneEdits& edits;
    const state::PoseState& poses;
    uint64_t scene_number = 0;            // unique per scene
    uint32_t camera_node = scene::kNone;  // of the image; kNone: a free camera
    float image_aspect = 1;
    float display_scale = 1;  // factor on widths and texts
  };
  // Markers of the next image; valid until the next call.
  const std::vector<state::ShownMarker>& update(const ViewState& view_state, const ImageView& seen);

 private:
  // Markers are compared with those of the last image, so that only changed ones are uploaded.
  void add(uint64_t key, wire::Marker marker, const glm::mat4& world_from_marker = glm::mat4(1));
  void add_frusta(const ViewState& view_state, const ImageView& seen);
  void add_spring(const std::array<glm::vec3, 2>& ends, float display_scale);
  void add_measurement(const ViewState& view_state, const state::PoseState& poses, float display_scale);

  struct SentMarker {
    uint64_t id = 0;
    std::shared_ptr<const wire::Marker> marker;
  };
  std::map<uint64_t, SentMarker> known_, last_;  // by key: of this image and of the last one
  std::vector<uint32_t> cameras_;                // camera nodes of that scene
  uint64_t listed_scene_ = UINT64_MAX;
  uint64_t last_id_ = uint64_t{1} << 63;  // ids of markers of streams begin at 1
  std::vector<state::ShownMarker> shown_;
};

}  // namespace fire3dv::app
