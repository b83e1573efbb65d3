// Images with several layers, apart from resources.h, which most files include.
#pragma once

#include <cstdint>

#include "renderer/gpu/device/resources.h"

namespace fire3dv::gpu {

// 2D image with `layers` layers, viewed as an array. info: without `cube`.
Image create_image_array(Device& device, const ImageInfo& info, uint32_t layers);

}  // namespace fire3dv::gpu
