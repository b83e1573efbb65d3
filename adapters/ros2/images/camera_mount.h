// Mount of a camera: the scene node, or the frame of the stream, to which its tf frame is fixed.
#pragma once

#include <fire3dv/client.hpp>
#include <functional>
#include <optional>
#include <string>

#include "adapters/ros2/images/camera_model.h"
#include "adapters/ros2/tf/frames.h"

namespace fire3dv::ros2 {

struct CameraMount {
  std::string node;  // empty: the frame of the stream itself
  Matrix34 node_from_frame{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  bool node_may_be_missing = false;  // the node is a frame of which the scene may know nothing

  bool operator==(const CameraMount&) const = default;
};

// What the stream has described.
struct StreamedFrames {
  FrameId fixed = kNoFrame;
  std::string frame_prefix;                                       // frame = prefix + node
  std::function<bool(const std::string& node)> has_node;          // poses move it
  std::function<const Pose*(const std::string& node)> offset_of;  // body_from_node; nullptr: identity
  std::function<std::string(const std::string& node)> name_of;    // by which the renderer finds it
  bool nodes_are_all_frames = false;                              // no robot says which nodes the scene has
};

// Climbs static transforms from the frame to the first node or to the fixed frame. Empty: tf does not have
// the frame, or it hangs on something that moves and is no node.
std::optional<CameraMount> find_camera_mount(const FrameBuffer& buffer, const StreamedFrames& streamed,
                                             const std::string& frame);

}  // namespace fire3dv::ros2
