#include "adapters/gazebo/stream/camera_messages.h"

#include <cstring>

#include "gazebo.pb.h"

namespace fire3dv::gazebo {
namespace {

enum PixelFormatType { kRgbInt8 = 3, kRFloat32 = 13 };

template <typename T>
std::vector<std::byte> bytes_of(const T& message) {
  std::vector<std::byte> bytes(message.ByteSizeLong());
  (void)message.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

void write_header(int64_t sim_time_ns, const std::string& frame_id, pb::Header& header) {
  int64_t s = sim_time_ns / 1'000'000'000, ns = sim_time_ns % 1'000'000'000;
  if (ns < 0) {
    ns += 1'000'000'000;
    --s;
  }
  header.mutable_stamp()->set_sec(s);
  header.mutable_stamp()->set_nsec(static_cast<int32_t>(ns));
  pb::Header::Map& entry = *header.add_data();
  entry.set_key("frame_id");
  entry.add_value(frame_id);
}

}  // namespace

std::vector<std::byte> image_message(const fire3dv_image& image, uint32_t output,
                                     const std::string& frame_id) {
  const fire3dv_image_plane* plane = plane_of(image, output);
  if (!plane) return {};
  const bool is_depth = output == FIRE3DV_IMAGE_DEPTH_F32;
  const uint32_t pixel_bytes = is_depth ? 4 : 3;
  pb::Image message;
  write_header(image.sim_time_ns, frame_id, *message.mutable_header());
  message.set_width(plane->width);
  message.set_height(plane->height);
  message.set_step(pixel_bytes * plane->width);
  message.set_pixel_format_type(is_depth ? kRFloat32 : kRgbInt8);
  std::string& data = *message.mutable_data();
  data.resize(size_t{pixel_bytes} * plane->width * plane->height);
  char* to = data.data();
  for (uint32_t y = 0; y < plane->height; ++y) {
    const char* from = static_cast<const char*>(plane->data) + size_t{plane->row_stride} * y;
    if (is_depth) {
      std::memcpy(to, from, size_t{4} * plane->width);
      to += size_t{4} * plane->width;
      continue;
    }
    for (uint32_t x = 0; x < plane->width; ++x, from += 4, to += 3) std::memcpy(to, from, 3);
  }
  return bytes_of(message);
}

std::vector<std::byte> camera_info_message(const fire3dv_image& image, const std::string& frame_id) {
  pb::CameraInfo info;
  write_header(image.sim_time_ns, frame_id, *info.mutable_header());
  info.set_width(image.width);
  info.set_height(image.height);
  for (const float k : image.lens_coefficients) info.mutable_distortion()->add_k(static_cast<double>(k));
  const double fx = image.fx, fy = image.fy, cx = image.cx, cy = image.cy;
  for (const double k : {fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0}) info.mutable_intrinsics()->add_k(k);
  for (const double p : {fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0})
    info.mutable_projection()->add_p(p);
  for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) info.add_rectification_matrix(r);
  return bytes_of(info);
}

}  // namespace fire3dv::gazebo
