// Requested image: its camera, and its assembly from GPU read-backs of one or several camera views.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "protocol/wire/image.h"
#include "renderer/capture/capture.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/post/lens_pass.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// Read-back of `views` cameras with equal image size: optional colours, then the planes at `ranges`. Views
// are stacked vertically.
struct ReadbackViews {
  uint32_t width = 0, height = 0, views = 1;
  bool color_srgb8 = false;
  std::vector<passes::PlaneRange> ranges;
  std::shared_ptr<const std::vector<wire::BoxRecord3d>> boxes;  // of all instances; null if not requested
};

// Pixels of one image: spans into the read-back, and bounding boxes computed from it.
class RequestedImage {
 public:
  // `bytes` must outlive this object.
  RequestedImage(const ReadbackViews& readback, uint32_t view, wire::ImageOutputs outputs,
                 std::span<const uint8_t> bytes);
  RequestedImage(const RequestedImage&) = delete;  // contains spans into itself
  RequestedImage& operator=(const RequestedImage&) = delete;

  // Writes the plane layout into the frame header.
  void describe_to(wire::ImageFrame& frame) const;
  // Copies all planes; `pixels` has frame.pixel_bytes bytes.
  void copy_to(std::span<std::byte> pixels) const;

 private:
  void add(wire::ImageOutput output, uint32_t width, uint32_t height, std::span<const uint8_t> bytes);
  template <typename Record>
  void add_boxes(wire::ImageOutput output, const std::vector<Record>& records);

  struct Piece {
    wire::ImagePlane plane;
    std::span<const uint8_t> bytes;
  };
  std::vector<Piece> pieces_;
  uint64_t end_ = 0;
  capture::VisibleBoxes boxes_;
};

// Camera of an image request: resolves the request to a projection and a camera pose.
struct RequestCamera {
  passes::Intrinsics intrinsics;
  passes::Lens lens;
  passes::Intrinsics pinhole;  // rendered projection: the same, or the pinhole image before lens distortion
  glm::mat4 world_from_camera{1};  // rigid transform
  float exposure = 0;              // 0: from the draw settings
  scene::ThinLens thin_lens;       // of the request, else of the node's camera
  std::optional<scene::Ground> ground;
  bool markers = false;
  // Paths: the image has more than so many samples, and is sent early. nullopt: it is sent when it is whole.
  std::optional<uint32_t> shown_samples;
  bool keeps_samples = false;  // paths: the image goes on after those of others
};

struct CameraRefused {
  wire::ImageRefusal reason;
  std::string why;
};

// world_from_stream: of the requesting stream.
std::variant<RequestCamera, CameraRefused> resolve_camera(const wire::ImageRequest& request,
                                                          const wire::Affine3x4d& world_from_stream,
                                                          const state::PoseState& poses,
                                                          const LiveScene& scene);

wire::Affine3x4 affine_of(const glm::mat4& matrix);

}  // namespace fire3dv::app
