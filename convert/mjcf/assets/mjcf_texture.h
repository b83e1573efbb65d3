// Texture assets of MJCF: 2D images from files or patterns; of cubes the mean colour.
#pragma once

#include "base/error.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/mjcf/xml/mjcf_element.h"

namespace fire3dv::convert {

class MjcfSource;

// The error is a sentence end about the asset.
Result<MjcfTexture> read_mjcf_texture(const MjcfSource& source, const MjcfElement& element);

// Reads a skybox as an equirectangular image in the frame of glTF.
Result<Image> read_mjcf_sky(const MjcfSource& source, const MjcfElement& element);

}  // namespace fire3dv::convert
