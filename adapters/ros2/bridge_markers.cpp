// Markers of the bridge: placed in the fixed frame of its poses.
#include <utility>

#include "adapters/ros2/bridge.h"

namespace fire3dv::ros2 {

Result<void> Bridge::open_markers() {
  if (options_.markers.is_empty()) return {};
  auto markers = MarkerInput::open(*participant_, options_.names, options_.markers);
  if (!markers) return markers.error();
  markers_ = std::move(*markers);
  watch(markers_->topics());
  return {};
}

// Messages wait until there is a fixed frame.
void Bridge::take_markers() {
  const FrameId fixed = sampler_.fixed_frame();
  if (!markers_ || fixed == kNoFrame || !renderers_.is_described()) return;
  marker_tree_.begin(buffer_, fixed, std::nullopt);
  MarkerContext context;
  context.fixed_frame = buffer_.frames()[fixed].name;
  context.find_transform = [&](const std::string& frame) {
    const FrameId id = buffer_.find(frame);
    return id == kNoFrame ? nullptr : marker_tree_.find(id);
  };
  context.show = [&](const std::string& name, const fire3dv_marker* marker) {
    return renderers_.show_marker(name, marker);
  };
  context.warn = [&](const std::string& kind, const std::string& text) { log_.warn(kind, text); };
  context.now_ns = now_ns_;
  context.sim_time_ns = renderers_.published_time_ns();
  markers_->take(context);
}

}  // namespace fire3dv::ros2
