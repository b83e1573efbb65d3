// Reader of MJCF files to a posed scene, without MuJoCo.
#pragma once

#include <filesystem>
#include <vector>

#include "base/error.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/model.h"
#include "convert/readers.h"

namespace fire3dv::convert {

// Poses the model in its first keyframe, if any. options: its folders and confinement.
// What is not supported becomes a warning.
Result<MjcfScene> read_mjcf_scene(const std::filesystem::path& file, const ReadOptions& options,
                                  Sources& sources, std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
