#include "adapters/ros2/images/camera_topics.h"

#include <fire3dv/client.hpp>
#include <utility>

#include "adapters/ros2/images/camera_model.h"
#include "adapters/ros2/images/image_bytes.h"
#include "adapters/ros2/images/messages.h"
#include "base/text.h"

namespace fire3dv::ros2 {

template <typename Message>
Result<void> CameraTopics::open_topic(OptionalTopic<Message>& topic, const Participant& participant,
                                      const Names& names, const CameraSpec& camera, const char* end,
                                      Profile profile) {
  const std::string name = names.resolve(camera.topic + end);
  Result<Writer<Message>> writer = Writer<Message>::open(participant, name, profile);
  if (!writer) return Error{"camera " + quote(camera.name) + ": " + writer.error().message};
  topic.emplace(Topic<Message>{name, std::move(*writer)});
  return {};
}

Result<CameraTopics> CameraTopics::open(const Participant& participant, const Names& names,
                                        const CameraSpec& camera) {
  CameraTopics topics(camera);
  Result<void> opened;
  const auto add = [&](bool wanted, auto& topic, const char* end, Profile profile) {
    if (wanted && opened) opened = open_topic(topic, participant, names, camera, end, profile);
  };
  add(true, topics.color_, "/image_raw", Profile::image);
  add(true, topics.info_, "/camera_info", Profile::camera_info);
  add(camera.compressed, topics.compressed_, "/image_raw/compressed", Profile::image);
  add(camera.depth, topics.depth_, "/depth/image_raw", Profile::image);
  add(camera.depth, topics.depth_info_, "/depth/camera_info", Profile::camera_info);
  add(camera.labels != LabelSource::none, topics.labels_, "/labels", Profile::image);
  if (!opened) return opened.error();
  return topics;
}

uint32_t CameraTopics::label_output() const {
  return camera_.labels == LabelSource::semantic ? FIRE3DV_IMAGE_SEMANTIC_U32 : FIRE3DV_IMAGE_INSTANCE_U32;
}

uint32_t CameraTopics::wanted_outputs() const {
  const auto is_read = [](const auto& topic) { return topic && topic->is_read(); };
  uint32_t outputs = 0;
  if (is_read(color_) || is_read(compressed_)) outputs |= FIRE3DV_IMAGE_COLOR_SRGB8;
  if (is_read(depth_)) outputs |= FIRE3DV_IMAGE_DEPTH_F32;
  if (is_read(labels_)) outputs |= label_output();
  if (outputs == 0 && (is_read(info_) || is_read(depth_info_))) outputs = FIRE3DV_IMAGE_DEPTH_F32;
  return outputs;
}

template <typename Message>
void CameraTopics::write(Topic<Message>& topic, const Message& message) {
  if (const Result<void> written = topic.writer.write(message); !written)
    failure_ = topic.name + " cannot be written (" + written.error().message + ")";
}

void CameraTopics::write_raw(Topic<ImageMessage>& topic, const fire3dv_image& image,
                             const fire3dv_image_plane& plane, const char* encoding, uint32_t pixel_bytes) {
  ImageMessage message{};
  message.header = header_of(image.sim_time_ns, camera_.optical_frame);
  message.height = plane.height;
  message.width = plane.width;
  message.encoding = text_of(encoding);
  message.step = pixel_bytes * plane.width;
  message.data = sequence_of(bytes_);
  write(topic, message);
}

void CameraTopics::write_compressed(const fire3dv_image& image, const fire3dv_image_plane& plane) {
  const auto jpeg =
      jpeg_.encode(plane.data, plane.width, plane.height, plane.row_stride, camera_.jpeg_quality);
  if (!jpeg) {
    failure_ = compressed_->name + ": " + jpeg.error().message;
    return;
  }
  CompressedImageMessage message{};
  message.header = header_of(image.sim_time_ns, camera_.optical_frame);
  message.format = text_of("rgb8; jpeg compressed bgr8");  // image_transport: pixels before; file
  message.data = sequence_of(*jpeg);
  write(*compressed_, message);
}

void CameraTopics::write_info(Topic<CameraInfoMessage>& topic, const fire3dv_image& image) {
  std::array<double, 5> lens{};
  std::copy(std::begin(image.lens_coefficients), std::end(image.lens_coefficients), lens.begin());
  CalibrationNumbers numbers = calibration({image.fx, image.fy, image.cx, image.cy}, camera_.lens, lens);
  CameraInfoMessage message{};
  message.header = header_of(image.sim_time_ns, camera_.optical_frame);
  message.height = image.height;
  message.width = image.width;
  message.distortion_model = text_of(numbers.distortion_model);
  message.d._maximum = message.d._length = static_cast<uint32_t>(numbers.d.size());
  message.d._buffer = numbers.d.data();
  std::copy(numbers.k.begin(), numbers.k.end(), message.k);
  std::copy(numbers.r.begin(), numbers.r.end(), message.r);
  std::copy(numbers.p.begin(), numbers.p.end(), message.p);
  write(topic, message);
}

Result<void> CameraTopics::publish(const fire3dv_image& image) {
  failure_.clear();
  // camera_info goes first: readers that pair it with the image find it there.
  if (info_->is_read()) write_info(*info_, image);
  if (depth_info_ && depth_info_->is_read()) write_info(*depth_info_, image);
  if (const auto* const plane = plane_of(image, FIRE3DV_IMAGE_COLOR_SRGB8)) {
    if (color_->is_read()) {
      pack_rgb8(*plane, bytes_);
      write_raw(*color_, image, *plane, "rgb8", 3);
    }
    if (compressed_ && compressed_->is_read()) write_compressed(image, *plane);
  }
  const auto* const depth = plane_of(image, FIRE3DV_IMAGE_DEPTH_F32);
  if (depth && depth_ && depth_->is_read()) {
    pack_32bit(*depth, bytes_);
    write_raw(*depth_, image, *depth, "32FC1", 4);
  }
  const auto* const labels = labels_ ? plane_of(image, label_output()) : nullptr;
  if (labels && labels_->is_read()) {
    pack_32bit(*labels, bytes_);
    write_raw(*labels_, image, *labels, "32SC1", 4);
  }
  if (!failure_.empty()) return Error{failure_};
  return {};
}

}  // namespace fire3dv::ros2
