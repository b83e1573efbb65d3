#include "adapters/ros2/images/optical_frames.h"

#include "adapters/ros2/images/camera_model.h"
#include "adapters/ros2/images/messages.h"

namespace fire3dv::ros2 {

Result<OpticalFrames> OpticalFrames::open(const Participant& participant, const Names& names) {
  const MessageType& type = kMessageType<TfMessage>;
  const UniqueQos qos = writer_qos(Profile::tf_static, type);
  // Frames that this program reads again would be nodes of its own stream.
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  Result<Entity> writer = create_writer(participant, names.resolve("/tf_static"), type, qos.get());
  if (!writer) return writer.error();
  return OpticalFrames(std::move(*writer));
}

Result<void> OpticalFrames::publish(const std::vector<CameraSpec>& cameras) {
  std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms;
  for (const CameraSpec& camera : cameras) {
    if (!camera.publishes_frame) continue;
    const RigidTransform transform = rigid_transform(parent_from_optical(camera));
    const auto& [x, y, z] = transform.translation;
    const auto& [qx, qy, qz, qw] = transform.rotation;
    transforms.push_back(
        {header_of(0, camera.parent_frame), text_of(camera.optical_frame), {{x, y, z}, {qx, qy, qz, qw}}});
  }
  if (transforms.empty()) return {};
  TfMessage message{};
  message.transforms._maximum = message.transforms._length = static_cast<uint32_t>(transforms.size());
  message.transforms._buffer = transforms.data();
  const dds_return_t code = dds_write(writer_.get(), &message);
  if (code < 0) return Error{"/tf_static cannot be written (" + dds_text(code) + ")"};
  return {};
}

}  // namespace fire3dv::ros2
