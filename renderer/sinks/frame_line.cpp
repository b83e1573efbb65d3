#include "renderer/sinks/frame_line.h"

#include "renderer/sinks/png.h"
#include "renderer/sinks/text.h"

namespace fire3dv::sinks {

std::string frame_line(const std::string& file, const FrameImage& image) {
  std::string line = "{\"file\":" + json_string(file) + ",\"frame\":" + std::to_string(image.frame_index) +
                     ",\"camera\":" + json_string(image.camera) +
                     ",\"width\":" + std::to_string(image.width) +
                     ",\"height\":" + std::to_string(image.height) + ",\"streams\":[";
  for (const state::FrameTag& tag : image.shown) {
    if (&tag != image.shown.data()) line += ',';
    line += "{\"stream\":" + json_string(tag.stream) + ",\"epoch\":\"" + hex64(tag.epoch) +
            "\",\"sequence\":" + std::to_string(tag.sequence) +
            ",\"sim_time_ns\":" + std::to_string(tag.sim_time_ns) +
            ",\"publish_time_ns\":" + std::to_string(tag.publish_time_ns) + ",\"state\":\"" +
            state::condition_name(tag.condition) + "\"}";
  }
  return line + "]}\n";
}

}  // namespace fire3dv::sinks
