// Images of the bridge: cameras see the frames that it streams.
#include <algorithm>
#include <utility>

#include "adapters/ros2/bridge.h"

namespace fire3dv::ros2 {

Result<void> Bridge::open_images() {
  if (options_.images.is_empty()) return {};
  auto images = ImageOutput::open(*participant_, options_.names, options_.images,
                                  options_.frames.frame_prefix, log_line);
  if (!images) return images.error();
  images_ = std::move(*images);
  return {};
}

std::chrono::milliseconds Bridge::wait_time() const {
  constexpr std::chrono::milliseconds kLongest{10};
  return images_ ? std::min(kLongest, images_->poll_interval()) : kLongest;
}

void Bridge::poll_images() {
  if (!images_ || !renderers_.is_described()) return;
  StreamedFrames streamed;
  streamed.fixed = sampler_.fixed_frame();
  streamed.frame_prefix = options_.frames.frame_prefix;
  streamed.has_node = [&](const std::string& node) {
    const std::vector<std::string>& names = sampler_.node_names();
    return std::find(names.begin(), names.end(), node) != names.end();
  };
  streamed.offset_of = [&](const std::string& node) {
    return links_ ? links_->body_from_node(node) : nullptr;
  };
  streamed.name_of = [&](const std::string& node) { return renderers_.first_name_of(node); };
  streamed.nodes_are_all_frames = !links_;
  images_->poll(renderers_.first_stream(), buffer_, streamed);
}

}  // namespace fire3dv::ros2
