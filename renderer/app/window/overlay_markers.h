// Markers that the window adds to its images: the measured points and their distance. They are drawn as
// markers of streams are. Requested images and files of --out do not have them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <vector>

#include "protocol/wire/marker.h"
#include "renderer/gui/panel_data.h"
#include "renderer/state/marker_registry.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

class OverlayMarkers {
 public:
  // Markers of the next image; valid until the next call. display_scale: factor on widths and texts.
  const std::vector<state::ShownMarker>& update(const gui::Viewer& viewer, const state::PoseState& poses,
                                                float display_scale);

 private:
  // Markers are compared with those of the last image, so that only changed ones are uploaded.
  void add(uint64_t key, wire::Marker marker, const glm::mat4& world_from_marker = glm::mat4(1));
  void add_measurement(const gui::Viewer& viewer, const state::PoseState& poses, float display_scale);

  struct Known {
    uint64_t id = 0;
    std::shared_ptr<const wire::Marker> marker;
  };
  std::map<uint64_t, Known> known_, last_;  // by key: of this image and of the last one
  uint64_t last_id_ = uint64_t{1} << 63;    // ids of markers of streams begin at 1
  std::vector<state::ShownMarker> shown_;
};

}  // namespace fire3dv::app
