// Requested image, assembled from GPU read-backs of one or several camera views.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "protocol/wire/image.h"
#include "renderer/capture/capture.h"
#include "renderer/passes/outputs/planes_and_boxes.h"

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

}  // namespace fire3dv::app
