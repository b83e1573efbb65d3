#include "adapters/mujoco/image_files.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "base/files.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/sinks/output_text.h"

namespace fire3dv::mujoco {
namespace {

// Copies rows without padding.
std::vector<uint8_t> packed(const fire3dv_image_plane& plane, size_t element_bytes) {
  const size_t row_bytes = element_bytes * plane.width;
  std::vector<uint8_t> bytes(row_bytes * plane.height);
  const auto* from = static_cast<const uint8_t*>(plane.data);
  for (size_t row = 0; row < plane.height && row_bytes > 0; ++row)
    std::memcpy(&bytes[row * row_bytes], from + row * plane.row_stride, row_bytes);
  return bytes;
}

template <typename Record>
std::vector<Record> records(const fire3dv_image_plane& plane) {
  std::vector<Record> found(plane.width);
  if (plane.width > 0) std::memcpy(found.data(), plane.data, plane.width * sizeof(Record));
  return found;
}

void add_plane(const fire3dv_image_plane& plane, sinks::FrameImage& frame) {
  if (plane.output == FIRE3DV_IMAGE_COLOR_SRGB8) {
    frame.rgba8 = packed(plane, 4);
  } else if (plane.output == FIRE3DV_IMAGE_BOXES2D) {
    frame.boxes2d = records<wire::BoxRecord2d>(plane);
  } else if (plane.output == FIRE3DV_IMAGE_BOXES3D) {
    frame.boxes3d = records<wire::BoxRecord3d>(plane);
  } else if ((plane.output & wire::kRequestableOutputs) != 0) {
    const auto output = static_cast<wire::ImageOutput>(plane.output);
    frame.planes.push_back({output, packed(plane, wire::info_of(output).element_bytes)});
  }
}

std::string number(float value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", static_cast<double>(value));
  return text;
}

std::string camera_line(const std::string& camera, const fire3dv_image& image) {
  std::string pose;
  for (const float value : image.world_from_camera) pose += (pose.empty() ? "" : ",") + number(value);
  return "{\"camera\":" + sinks::json_string(camera) + ",\"sequence\":" + std::to_string(image.sequence) +
         ",\"sim_time_ns\":" + std::to_string(image.sim_time_ns) + ",\"lost\":" + std::to_string(image.lost) +
         ",\"width\":" + std::to_string(image.width) + ",\"height\":" + std::to_string(image.height) +
         ",\"fx\":" + number(image.fx) + ",\"fy\":" + number(image.fy) + ",\"cx\":" + number(image.cx) +
         ",\"cy\":" + number(image.cy) + ",\"near_m\":" + number(image.near_m) +
         ",\"far_m\":" + number(image.far_m) + ",\"world_from_camera\":[" + pose + "]}\n";
}

}  // namespace

Result<ImageFiles> ImageFiles::open(const std::filesystem::path& folder) {
  auto sink = sinks::FileSink::open({.folder = folder, .folder_per_camera = true});
  if (!sink) return sink.error();
  const std::filesystem::path list = folder / "cameras.jsonl";
  errno = 0;
  std::ofstream lines(list, std::ios::trunc);
  if (!lines) return Error{"cannot write " + list.string() + ": " + system_reason(errno)};
  return ImageFiles(std::move(*sink), list, std::move(lines));
}

Result<void> ImageFiles::write(const std::string& camera, const std::string& stream,
                               const fire3dv_image& image) {
  sinks::FrameImage frame;
  frame.width = image.width;
  frame.height = image.height;
  frame.frame_index = image.sequence;
  frame.camera = camera;
  state::FrameTag tag;
  tag.stream = stream;
  tag.epoch = image.epoch;
  tag.sequence = image.sequence;
  tag.sim_time_ns = image.sim_time_ns;
  frame.shown.push_back(std::move(tag));
  for (size_t i = 0; i < image.plane_count; ++i) add_plane(image.planes[i], frame);
  if (Result<void> consumed = sink_->consume(std::move(frame)); !consumed) return consumed;
  errno = 0;
  lines_ << camera_line(camera, image) << std::flush;  // flushed, so that a killed run keeps its list
  if (!lines_) return Error{"cannot write " + list_.string() + ": " + system_reason(errno)};
  return {};
}

Result<void> ImageFiles::finish() {
  return sink_->finish();
}

}  // namespace fire3dv::mujoco
