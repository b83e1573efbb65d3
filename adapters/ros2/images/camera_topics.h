// Topics of one camera: image_raw, camera_info, image_raw/compressed, depth and labels. Nothing is converted,
// encoded or written for a topic that nobody reads.
#pragma once

#include <fire3dv/image.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "adapters/ros2/dds/names.h"
#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/images/camera_spec.h"
#include "base/error.h"
#include "base/image/jpeg_encoder.h"

namespace fire3dv::ros2 {

class CameraTopics {
 public:
  // Topics of the camera's base, resolved by `names`: BASE/image_raw, BASE/camera_info, and by option
  // BASE/image_raw/compressed, BASE/depth/image_raw with BASE/depth/camera_info, BASE/labels.
  static Result<CameraTopics> open(const Participant& participant, const Names& names,
                                   const CameraSpec& camera);

  // FIRE3DV_IMAGE_* bits that somebody reads; 0: nobody. Who reads camera_info only costs a depth image. Any
  // thread.
  uint32_t wanted_outputs() const;

  // Publishes the planes of an image and its camera_info where somebody reads; header.stamp is the image's
  // simulated time. One thread at a time. The error names the topic; other topics have been written.
  Result<void> publish(const fire3dv_image& image);

 private:
  template <typename Message>
  struct Topic {
    std::string name;
    Writer<Message> writer;

    bool is_read() const { return writer.reader_count() > 0; }
  };
  template <typename Message>
  using OptionalTopic = std::optional<Topic<Message>>;

  explicit CameraTopics(const CameraSpec& camera) : camera_(camera) {}
  template <typename Message>
  static Result<void> open_topic(OptionalTopic<Message>& topic, const Participant& participant,
                                 const Names& names, const CameraSpec& camera, const char* end,
                                 Profile profile);
  template <typename Message>
  void write(Topic<Message>& topic, const Message& message);
  void write_raw(Topic<ImageMessage>& topic, const fire3dv_image& image, const fire3dv_image_plane& plane,
                 const char* encoding, uint32_t pixel_bytes);
  void write_compressed(const fire3dv_image& image, const fire3dv_image_plane& plane);
  void write_info(Topic<CameraInfoMessage>& topic, const fire3dv_image& image);
  uint32_t label_output() const;

  CameraSpec camera_;
  OptionalTopic<ImageMessage> color_, depth_, labels_;
  OptionalTopic<CompressedImageMessage> compressed_;
  OptionalTopic<CameraInfoMessage> info_, depth_info_;
  std::vector<uint8_t> bytes_;
  JpegEncoder jpeg_;
  std::string failure_;
};

}  // namespace fire3dv::ros2
