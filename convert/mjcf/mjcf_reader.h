// Reader of MJCF files to a posed scene, without MuJoCo.
#pragma once

#include <filesystem>
#include <vector>

#include "base/error.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Poses the model in its first keyframe, if any. folders: folders that the model may read besides its own.
// What is not supported becomes a warning.
Result<MjcfScene> read_mjcf_scene(const std::filesystem::path& file,
                                  const std::vector<std::filesystem::path>& folders, Sources& sources,
                                  std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
