// Validation of image messages. Values that a later minor version may add (outputs, lenses, times) pass: the
// renderer replies that it does not support them.
#include <cmath>
#include <cstdio>

#include "protocol/wire/check.h"

namespace fire3dv::wire {
namespace {

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

Error wrong(const char* message, const char* field, double value, const std::string& rule) {
  return Error{std::string(message) + "." + field + " is " + text_of(value) + "; " + rule};
}

Result<void> check_finite(const char* message, const char* field, double value, double most) {
  if (std::fabs(value) <= most) return {};
  return wrong(message, field, value, "finite numbers of magnitude up to " + text_of(most) + " are allowed");
}

Result<void> check_size(const char* message, const Intrinsics& camera) {
  const std::string rule = "images have 1 to " + std::to_string(kMaxRequestedImageSide) + " pixels a side";
  if (camera.width == 0 || camera.width > kMaxRequestedImageSide)
    return wrong(message, "width", camera.width, rule);
  if (camera.height == 0 || camera.height > kMaxRequestedImageSide)
    return wrong(message, "height", camera.height, rule);
  return {};
}

// NaN fails every comparison.
Result<void> check_projection(const char* message, const Intrinsics& camera, double most) {
  const std::string positive = "it must be above 0, and finite";
  if (!(camera.fx > 0 && camera.fx <= most)) return wrong(message, "fx", camera.fx, positive);
  if (!(camera.fy > 0 && camera.fy <= most)) return wrong(message, "fy", camera.fy, positive);
  if (auto good = check_finite(message, "cx", camera.cx, most); !good) return good;
  if (auto good = check_finite(message, "cy", camera.cy, most); !good) return good;
  if (!(camera.near_m > 0 && camera.near_m <= most)) return wrong(message, "near_m", camera.near_m, positive);
  if (!(camera.far_m == 0 || (camera.far_m > camera.near_m && camera.far_m <= most)))
    return wrong(message, "far_m", camera.far_m, "it must be 0 (infinite) or more than near_m");
  for (const float coefficient : camera.lens.coefficients)
    if (auto good = check_finite(message, "lens_coefficients", coefficient, most); !good) return good;
  return {};
}

Result<void> check_plane(const ImageFrame& frame, size_t index) {
  const ImagePlane& plane = frame.planes[index];
  const std::string field = "ImageFrame.planes[" + std::to_string(index) + "]";
  if (plane.output_bit >= kImageOutputCount) return Error{field + ".output is of no known output"};
  if (index > 0 && plane.output_bit <= frame.planes[index - 1].output_bit)
    return Error{field + ".output is " + std::to_string(plane.output_bit) + " after " +
                 std::to_string(frame.planes[index - 1].output_bit) + "; outputs must rise"};
  const ImageOutputInfo& info = info_at(plane.output_bit);
  if (plane.format != info.format)
    return Error{field + ".format is " + std::to_string(static_cast<int>(plane.format)) + "; " +
                 std::string(info.api_name) + " comes in another"};
  const bool fits = info.is_boxes
                        ? plane.height == 1
                        : plane.width == frame.intrinsics.width && plane.height == frame.intrinsics.height;
  if (!fits) return Error{field + " is not of the image's size"};
  const uint64_t row_bytes = uint64_t{plane.width} * info.element_bytes;
  if (plane.row_stride < row_bytes || plane.row_stride % 4 != 0 ||
      plane.bytes != uint64_t{plane.row_stride} * plane.height)
    return Error{field + " has " + std::to_string(plane.bytes) + " bytes in rows of " +
                 std::to_string(plane.row_stride) + ", which is not " + std::to_string(plane.height) +
                 " rows of at least " + std::to_string(row_bytes) + ", a multiple of 4"};
  if (plane.offset % 64 != 0 || plane.offset > frame.pixel_bytes ||
      plane.bytes > frame.pixel_bytes - plane.offset)
    return Error{field + ".offset is " + std::to_string(plane.offset) + ", from where " +
                 std::to_string(plane.bytes) + " bytes do not lie in the image's " +
                 std::to_string(frame.pixel_bytes)};
  return {};
}

}  // namespace

Result<void> check(const ImageRequest& request, const DecodeLimits& limits) {
  constexpr const char* kName = "ImageRequest";
  if (request.epoch == 0) return Error{"ImageRequest.epoch is 0; an epoch is a random number that is not 0"};
  if (request.id == 0) return Error{"ImageRequest.id is 0; choose another number"};
  if (request.place >= kMaxImageRequests)
    return wrong(kName, "place", request.place,
                 "there are places 0 to " + std::to_string(kMaxImageRequests - 1));
  if (auto good = check_text("ImageRequest.node", request.node, limits.max_name_bytes); !good) return good;
  if (request.when == ImageWhen::never) return {};
  if (auto good = check_poses("ImageRequest.parent_from_camera", {&request.parent_from_camera, 1},
                              limits.max_abs_value);
      !good)
    return good;
  const Intrinsics& camera = request.intrinsics;
  if (auto good = check_size(kName, camera); !good) return good;
  const bool is_own = camera.fx == 0 && camera.fy == 0;
  if (is_own && request.node.empty())
    return Error{
        "ImageRequest.fx is 0, and ImageRequest.node names no camera whose projection could be taken"};
  if (is_own && camera.lens != Lens{})
    return Error{"ImageRequest.lens is given without fx and fy; a lens belongs to a camera's own numbers"};
  if (!is_own)
    if (auto good = check_projection(kName, camera, double{limits.max_abs_value}); !good) return good;
  if (request.outputs == 0) return Error{"ImageRequest.outputs is empty; request at least one"};
  if (request.when == ImageWhen::every_nth && request.every == 0)
    return Error{"ImageRequest.every is 0; it must be 1 or more"};
  constexpr double kMaxRateHz = 1e6;
  if (request.when == ImageWhen::rate && !(request.rate_hz > 0 && request.rate_hz <= kMaxRateHz))
    return wrong(kName, "rate_hz", request.rate_hz, "it must be above 0, and at most 1e+06");
  if (request.when == ImageWhen::exactly && request.sequence == 0)
    return Error{"ImageRequest.sequence is 0; sequences start at 1"};
  return {};
}

Result<void> check(const ImageFrame& frame, const DecodeLimits& limits) {
  constexpr const char* kName = "ImageFrame";
  if (frame.epoch == 0) return Error{"ImageFrame.epoch is 0; an epoch is a random number that is not 0"};
  if (frame.request == 0) return Error{"ImageFrame.request is 0; requests have numbers that are not 0"};
  if (frame.number == 0) return Error{"ImageFrame.number is 0; images count from 1"};
  if (auto good =
          check_poses("ImageFrame.world_from_camera", {&frame.world_from_camera, 1}, limits.max_abs_value);
      !good)
    return good;
  if (auto good = check_size(kName, frame.intrinsics); !good) return good;
  if (auto good = check_projection(kName, frame.intrinsics, double{limits.max_abs_value}); !good) return good;
  if (frame.pixel_bytes > kMaxPixelBytes)
    return Error{"ImageFrame.pixel_bytes is " + std::to_string(frame.pixel_bytes) + "; at most " +
                 std::to_string(kMaxPixelBytes) + " are allowed"};
  for (size_t i = 0; i < frame.planes.size(); ++i)
    if (auto good = check_plane(frame, i); !good) return good;
  return {};
}

Result<void> check(const ImageRefused& refused, const DecodeLimits& limits) {
  if (refused.request == 0) return Error{"ImageRefused.request is 0; requests have numbers that are not 0"};
  return check_text("ImageRefused.message", refused.message, limits.max_text_bytes);
}

}  // namespace fire3dv::wire
