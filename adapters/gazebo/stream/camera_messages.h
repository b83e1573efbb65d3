// Images of a renderer as messages of Gazebo: Image and CameraInfo, encoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fire3dv/client.hpp>
#include <string>
#include <vector>

namespace fire3dv::gazebo {

// output: FIRE3DV_IMAGE_COLOR_SRGB8, as tight rows of RGB_INT8, or FIRE3DV_IMAGE_DEPTH_F32, as tight rows of
// R_FLOAT32: metres along the axis of the camera, infinite where nothing is. Empty if the image lacks it.
std::vector<std::byte> image_message(const fire3dv_image& image, uint32_t output,
                                     const std::string& frame_id);
std::vector<std::byte> camera_info_message(const fire3dv_image& image, const std::string& frame_id);

}  // namespace fire3dv::gazebo
