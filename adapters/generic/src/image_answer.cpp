#include "image_answer.h"

#include <cstring>
#include <string>

namespace fire3dv::client {
namespace {

std::string size_text(const wire::Intrinsics& camera) {
  return std::to_string(camera.width) + " x " + std::to_string(camera.height) + " pixels";
}

std::string names_of(uint32_t outputs) {
  std::string text;
  for (uint32_t bit = 0; bit < wire::kImageOutputCount; ++bit)
    if ((outputs >> bit & 1) != 0) text += (text.empty() ? "" : ",") + wire::image_output_name(bit);
  return text.empty() ? "no outputs" : text;
}

uint32_t outputs_of(const wire::ImageFrame& frame) {
  uint32_t outputs = 0;
  for (const wire::ImagePlane& plane : frame.planes) outputs |= 1u << plane.output_bit;
  return outputs;
}

// Programs crop images by these boxes.
bool boxes_are_inside(const wire::ImagePlane& plane, std::span<const std::byte> pixels,
                      const wire::Intrinsics& camera) {
  for (uint32_t i = 0; i < plane.width; ++i) {
    wire::BoxRecord2d box;
    std::memcpy(&box, pixels.data() + plane.offset + sizeof box * i, sizeof box);
    if (box.min_x > box.max_x || box.max_x > camera.width || box.min_y > box.max_y ||
        box.max_y > camera.height)
      return false;
  }
  return true;
}

Result<void> check_boxes(const wire::ImageFrame& frame, std::span<const std::byte> pixels) {
  const uint64_t most = uint64_t{frame.intrinsics.width} * frame.intrinsics.height;
  for (const wire::ImagePlane& plane : frame.planes) {
    if (!wire::info_at(plane.output_bit).is_boxes) continue;
    if (plane.width > most)  // each is of an instance that a pixel shows
      return Error{"it has " + std::to_string(plane.width) + " boxes of " + std::to_string(most) + " pixels"};
    if ((1u << plane.output_bit) == wire::kBoxes2d && !boxes_are_inside(plane, pixels, frame.intrinsics))
      return Error{"its boxes are not inside the image"};
  }
  return {};
}

}  // namespace

Result<void> check_answer(const wire::ImageFrame& frame, std::span<const std::byte> pixels,
                          const wire::ImageRequest& request, uint64_t newest_sequence) {
  const wire::Intrinsics &is = frame.intrinsics, &wanted = request.intrinsics;
  if (is.width != wanted.width || is.height != wanted.height)
    return Error{"it has " + size_text(is) + " instead of " + size_text(wanted)};
  if (frame.views != request.views())
    return Error{"it has " + std::to_string(frame.views) + " views instead of " +
                 std::to_string(request.views())};
  if (const uint32_t outputs = outputs_of(frame); outputs != request.outputs)
    return Error{"it has " + names_of(outputs) + " instead of " + names_of(request.outputs)};
  for (const wire::ImagePlane& plane : frame.planes) {
    const uint64_t row_bytes = uint64_t{plane.width} * wire::info_at(plane.output_bit).element_bytes;
    if (request.batch && plane.row_stride != row_bytes)
      return Error{"it has rows of " + std::to_string(plane.row_stride) + " bytes instead of " +
                   std::to_string(row_bytes) + ", as batches have them"};
  }
  if (is.lens != wanted.lens) return Error{"it has another lens than its request"};
  if (frame.sequence > newest_sequence)
    return Error{"it shows frame " + std::to_string(frame.sequence) + ", but " +
                 std::to_string(newest_sequence) + " is the newest that was published"};
  const bool is_early = frame.sequence < request.sequence;
  if (is_early || (request.when == wire::ImageWhen::exactly && frame.sequence != request.sequence))
    return Error{"it shows frame " + std::to_string(frame.sequence) + " instead of " +
                 std::to_string(request.sequence) + (is_early ? " or a later one" : "")};
  return check_boxes(frame, pixels);
}

}  // namespace fire3dv::client
