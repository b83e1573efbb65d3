#include "renderer/state/edits/edit_values.h"

#include <variant>

namespace fire3dv::state {

static_assert(wire::kMinFNumber == scene::kMinFNumber && wire::kMaxFNumber == scene::kMaxFNumber &&
              wire::kMinFocusDistanceM == scene::kMinFocusDistanceM &&
              wire::kMaxFocusDistanceM == scene::kMaxFocusDistanceM);

scene::Light to_scene_light(const wire::Light& from, const scene::Scene& scene, uint32_t node) {
  scene::Light light;
  if (scene.nodes[node].light != scene::kNone) light = scene.lights[scene.nodes[node].light];
  light.type = from.kind == wire::LightKind::directional ? scene::LightType::directional
               : from.kind == wire::LightKind::point     ? scene::LightType::point
                                                         : scene::LightType::spot;
  light.color = {from.color_rgb[0], from.color_rgb[1], from.color_rgb[2]};
  light.intensity = from.intensity;
  light.range_m = from.range_m;
  light.inner_cone_rad = from.inner_cone_rad;
  light.outer_cone_rad = from.outer_cone_rad;
  light.casts_shadow = from.casts_shadow;
  return light;
}

scene::Camera to_scene_camera(const wire::Camera& from, const scene::Scene& scene, uint32_t node) {
  scene::Camera camera;
  if (scene.nodes[node].camera != scene::kNone) {
    const scene::Camera& own = scene.cameras[scene.nodes[node].camera];
    camera.name = own.name;
    camera.lens = own.lens;
    camera.pixel_aspect = own.pixel_aspect;
    camera.principal_point = own.principal_point;
  }
  camera.vertical_fov_rad = from.vertical_fov_rad;
  camera.near_m = from.near_m;
  camera.far_m = from.far_m;
  camera.exposure = from.exposure;
  if (from.f_number > 0) camera.lens = {from.f_number, from.focus_distance_m, true};
  return camera;
}

bool hides_subtree(const wire::EditValue& value) {
  const auto* visible = std::get_if<wire::Visible>(&value);
  return std::holds_alternative<wire::NodeRemoved>(value) || (visible && !visible->visible);
}

}  // namespace fire3dv::state
