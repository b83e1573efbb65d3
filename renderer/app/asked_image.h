// From what the GPU made of one or several cameras to the images that go back to who asked for them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "protocol/wire/image.h"
#include "renderer/passes/boxes.h"
#include "renderer/passes/image_outputs.h"

namespace fire3dv::app {

// ImageOutput bits, and what the passes are told. with_sources() of that is still the caller's.
passes::ImageOutputs outputs_of(uint32_t bits);
uint32_t bits_of(const passes::ImageOutputs& outputs);

// What came back of `views` cameras with images of one size: colours, if there are any, and then the planes
// as they were placed, of one view below the other.
struct TakenViews {
  uint32_t width = 0, height = 0, views = 1;
  bool color_srgb8 = false;
  std::vector<passes::PlanePlace> places;
  std::shared_ptr<const std::vector<passes::Box3d>> boxes;  // of all instances; null where none are wanted
};

// The pixels of one image: views of what came back, and boxes found in it.
class AskedImage {
 public:
  // bits: what was asked for. bytes outlive this.
  AskedImage(const TakenViews& taken, uint32_t view, uint32_t bits, std::span<const uint8_t> bytes);
  AskedImage(const AskedImage&) = delete;  // it views itself
  AskedImage& operator=(const AskedImage&) = delete;

  // Says in the frame where they are.
  void describe_to(wire::ImageFrame& frame) const;
  // pixels: frame.pixel_bytes.
  void copy_to(std::span<std::byte> pixels) const;

 private:
  void add(uint32_t bit, uint32_t width, uint32_t height, std::span<const uint8_t> bytes);
  void add_boxes(const TakenViews& taken, uint32_t bits, std::span<const uint8_t> instances);

  struct Piece {
    wire::ImagePlane plane;
    std::span<const uint8_t> bytes;
  };
  std::vector<Piece> pieces_;
  uint64_t end_ = 0;
  std::vector<wire::BoxRecord2d> boxes2d_;
  std::vector<wire::BoxRecord3d> boxes3d_;
};

}  // namespace fire3dv::app
