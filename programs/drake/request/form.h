// Render request of Drake's glTF render client: the fields of its HTML form, checked.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"

namespace fire3dv::drake {

enum class ImageType : uint8_t { color, depth, label };

struct RenderRequest {
  ImageType type = ImageType::color;
  uint32_t width = 0, height = 0;  // pixels
  double near_m = 0, far_m = 0;    // clipping planes
  double focal_x_px = 0, focal_y_px = 0;
  double center_x_px = 0, center_y_px = 0;  // from the image's upper left corner
  double min_depth_m = 0, max_depth_m = 0;  // range of the depth sensor; depth only
  std::string_view scene;                   // the glTF file, in the body
};

struct FormLimits {
  uint32_t max_side_px = 8192;
  uint64_t max_pixels = uint64_t{1} << 24;
};

// body: of a multipart/form-data request; it must outlive the result. Checks the scene against its digest.
Result<RenderRequest> read_form(std::string_view body, std::string_view content_type,
                                const FormLimits& limits = {});

}  // namespace fire3dv::drake
