#include "renderer/passes/resources/draw_names.h"

namespace fire3dv::passes {

RasterPath raster_path_named(const std::string& name) {
  if (name == "forward") return RasterPath::forward;
  if (name == "visibility") return RasterPath::visibility;
  return RasterPath::automatic;
}

LevelsOfDetail levels_of_detail_named(const std::string& name) {
  if (name == "off") return LevelsOfDetail::off;
  if (name == "on") return LevelsOfDetail::camera;
  return name == "everywhere" ? LevelsOfDetail::everywhere : LevelsOfDetail::automatic;
}

Cull cull_named(const std::string& name) {
  if (name == "off") return Cull::off;
  if (name == "view") return Cull::view;
  return name == "hidden" ? Cull::hidden : Cull::automatic;
}

ShadowSettings shadows_named(const std::string& name) {
  ShadowSettings settings;
  if (name == "off") settings.method = ShadowMethod::off;
  if (name == "map") settings.method = ShadowMethod::map;
  if (name.starts_with("ray")) settings.method = ShadowMethod::ray;
  if (name == "ray-pipeline") settings.back_end = RayBackEnd::pipeline;
  return settings;
}

}  // namespace fire3dv::passes
