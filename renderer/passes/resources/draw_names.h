// Option names of draw settings, shared by all programs.
#pragma once

#include <string>
#include <vector>

#include "renderer/passes/scene_renderer.h"

namespace fire3dv::passes {

inline const std::vector<std::string> kRasterPathNames{"auto", "forward", "visibility"};
inline const std::vector<std::string> kCullNames{"on", "off", "view", "hidden"};
inline const std::vector<std::string> kLevelsOfDetailNames{"auto", "on", "everywhere", "off"};
inline const std::vector<std::string> kShadowNames{"auto", "ray", "ray-query", "ray-pipeline", "map", "off"};

// name: one of those above; any other string selects the first.
RasterPath raster_path_named(const std::string& name);
Cull cull_named(const std::string& name);
LevelsOfDetail levels_of_detail_named(const std::string& name);
ShadowSettings shadows_named(const std::string& name);

}  // namespace fire3dv::passes
