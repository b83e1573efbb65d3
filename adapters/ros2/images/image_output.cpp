#include "adapters/ros2/images/image_output.h"

#include <utility>

#include "base/log.h"
#include "base/text.h"

namespace fire3dv::ros2 {

ImageOutput::ImageOutput(ImageOptions options, std::string frame_prefix, CameraImages::Log log,
                         std::unique_ptr<CameraImages> images)
    : options_(std::move(options)),
      frame_prefix_(std::move(frame_prefix)),
      log_(std::move(log)),
      images_(std::move(images)) {}

Result<std::unique_ptr<ImageOutput>> ImageOutput::open(const Participant& participant, const Names& names,
                                                       ImageOptions options, std::string frame_prefix,
                                                       CameraImages::Log log) {
  auto images = CameraImages::open(participant, names, log);
  if (!images) return images.error();
  for (const CameraSpec& camera : options.cameras)
    if (Result<void> added = (*images)->add(camera); !added) return added.error();
  return std::unique_ptr<ImageOutput>(
      new ImageOutput(std::move(options), std::move(frame_prefix), std::move(log), std::move(*images)));
}

void ImageOutput::set_description(std::string_view urdf) {
  const RobotCameras cameras = robot_cameras(options_, urdf, frame_prefix_);
  for (const std::string& text : cameras.warnings) log_(warning(text));
  for (const CameraSpec& camera : cameras.cameras) {
    if (images_->has(camera.name)) continue;
    if (const Result<void> added = images_->add(camera); !added)
      log_(warning(added.error().message));
    else
      log_("camera " + quote(camera.name) + " of " + quote(camera.parent_frame) + " on topic " +
           camera.topic);
  }
}

void ImageOutput::poll(fire3dv_stream* stream, const FrameBuffer& buffer, const StreamedFrames& streamed) {
  const auto find_mount = [&](const std::string& frame) {
    return find_camera_mount(buffer, streamed, frame);
  };
  images_->poll(stream, find_mount, CameraImages::Clock::now());
}

}  // namespace fire3dv::ros2
