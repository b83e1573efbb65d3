#include "renderer/scene/gltf/gltf_parts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fire3dv::scene {
namespace {

// glTF has no size of a light; it is read from the extras, which Blender writes from custom properties.
// "radius" is that of a point or spot light in metres. "angular_radius" is half the angle that a directional
// light subtends, in radians; "angle", Blender's name and that of other programs, is the whole angle.
void set_radius(const tinygltf::Light& source, const std::string& where, Light& light,
                std::vector<std::string>& warnings) {
  constexpr double kLargestAngle = std::numbers::pi / 2;
  if (light.type == LightType::directional) {
    const double radius =
        number_or(source.extras, "angular_radius", number_or(source.extras, "angle", 0) / 2);
    light.angular_radius_rad =
        in_range_or_warn(radius, 0, kLargestAngle, where + ".extras.angular_radius", warnings);
  } else {
    const double radius = number_or(source.extras, "radius", 0);
    light.radius_m =
        in_range_or_warn(radius, 0, std::numeric_limits<float>::max(), where + ".extras.radius", warnings);
  }
  // Of lamps of endoscopes, see Light::spread.
  if (light.type == LightType::point)
    light.spread = in_range_or_warn(number_or(source.extras, "spread", 0), 0, kMaxLightSpread,
                                    where + ".extras.spread", warnings);
}

Result<Light> light_of(const tinygltf::Light& source, const std::string& where,
                       std::vector<std::string>& warnings) {
  Light light;
  light.name = source.name;
  if (source.type == "directional") {
    light.type = LightType::directional;
  } else if (source.type == "spot") {
    light.type = LightType::spot;
  } else if (source.type != "point") {
    // Later versions of the extension may add types: such nodes are kept but emit no light.
    warnings.push_back(where + " has the unknown type " + quote(source.type) + " and emits no light");
    light.intensity = 0;
    return light;
  }
  if (!source.color.empty()) {
    if (source.color.size() != 3) return Error{where + ".color does not hold three numbers"};
    for (int i = 0; i < 3; ++i) light.color[i] = to_float(source.color[static_cast<size_t>(i)]);
  }
  light.intensity = to_float(source.intensity);
  light.range_m = to_float(source.range);
  light.inner_cone_rad = to_float(source.spot.innerConeAngle);
  light.outer_cone_rad = to_float(source.spot.outerConeAngle);
  if (light.intensity < 0 || light.range_m < 0) return Error{where + " has a negative intensity or range"};
  if (light.type == LightType::spot &&
      !(light.inner_cone_rad >= 0 && light.inner_cone_rad < light.outer_cone_rad &&
        source.spot.outerConeAngle <= std::numbers::pi / 2 + 1e-4)) {
    return Error{where + ".spot: the cone angles are not 0 <= inner < outer <= pi/2"};
  }
  set_radius(source, where, light, warnings);
  return light;
}

// glTF has no lens; f-number and focus distance are read from the extras.
ThinLens lens_of(const tinygltf::Camera& source, const std::string& where,
                 std::vector<std::string>& warnings) {
  const tinygltf::Value& extras = source.extras;
  const double f_number = number_or(extras, "fNumber", 0);
  const double focus_distance_m = number_or(extras, "focusDistanceM", 0);
  if (f_number == 0 && focus_distance_m == 0) return {};
  if (f_number == 0 || focus_distance_m == 0) {
    warnings.push_back(where + ".extras has only one of fNumber and focusDistanceM: set both for a lens");
    return {};
  }
  return {in_range_or_warn(f_number, kMinFNumber, kMaxFNumber, where + ".extras.fNumber", warnings),
          in_range_or_warn(focus_distance_m, kMinFocusDistanceM, kMaxFocusDistanceM,
                           where + ".extras.focusDistanceM", warnings)};
}

// glTF's cameras are centred and have square pixels; others are read from the extras.
void set_intrinsics(const tinygltf::Camera& source, const std::string& where, Camera& camera,
                    std::vector<std::string>& warnings) {
  const tinygltf::Value& extras = source.extras;
  camera.pixel_aspect = in_range_or_warn(number_or(extras, "pixelAspectRatio", 1), kMinPixelAspect,
                                         kMaxPixelAspect, where + ".extras.pixelAspectRatio", warnings);
  if (!extras.Has("principalPoint")) return;
  const std::string name = where + ".extras.principalPoint";
  const tinygltf::Value& point = extras.Get("principalPoint");
  if (!point.IsArray() || point.ArrayLen() != 2 || !point.Get(0).IsNumber() || !point.Get(1).IsNumber()) {
    warnings.push_back(name + " is no list of two numbers: the camera is centred");
    return;
  }
  for (int i = 0; i < 2; ++i)
    camera.principal_point[i] = in_range_or_warn(point.Get(i).GetNumberAsDouble(), -kMaxPrincipalPoint,
                                                 kMaxPrincipalPoint, name, warnings);
}

Result<Camera> camera_of(const tinygltf::Camera& source, const std::string& where,
                         std::vector<std::string>& warnings) {
  Camera camera;
  camera.name = source.name;
  if (source.type == "orthographic") {
    const tinygltf::OrthographicCamera& ortho = source.orthographic;
    camera.orthographic = true;
    camera.half_extent_m = {to_float(ortho.xmag), to_float(ortho.ymag)};
    camera.near_m = to_float(ortho.znear);
    camera.far_m = to_float(ortho.zfar);
    if (camera.half_extent_m.x == 0 || camera.half_extent_m.y == 0)
      return Error{where + ".orthographic: xmag or ymag is 0"};
    if (!(camera.near_m >= 0 && camera.far_m > camera.near_m))
      return Error{where + ".orthographic: znear and zfar are not 0 <= znear < zfar"};
    return camera;
  }
  camera.lens = lens_of(source, where, warnings);
  set_intrinsics(source, where, camera, warnings);
  const tinygltf::PerspectiveCamera& perspective = source.perspective;
  camera.vertical_fov_rad = to_float(perspective.yfov);
  constexpr float kMaxFov = 3.1f;
  if (perspective.yfov >= std::numbers::pi && std::isfinite(perspective.yfov)) {
    warnings.push_back(where + ".perspective: yfov is not below pi: 3.1 is taken");
    camera.vertical_fov_rad = kMaxFov;
  }
  camera.aspect = to_float(perspective.aspectRatio);
  camera.near_m = to_float(perspective.znear);
  camera.far_m = to_float(perspective.zfar);
  if (!(camera.vertical_fov_rad > 0 && camera.vertical_fov_rad < std::numbers::pi_v<float>)) {
    return Error{where + ".perspective: yfov is not between 0 and pi"};
  }
  if (camera.aspect < 0) return Error{where + ".perspective: aspectRatio is negative"};
  if (!(camera.near_m > 0) || (camera.far_m != 0 && !(camera.far_m > camera.near_m))) {
    return Error{where + ".perspective: znear and zfar are not 0 < znear < zfar"};
  }
  return camera;
}

// glTF has no default view; its direction is read from the extras of the scene.
void add_default_view(const tinygltf::Model& model, Scene& scene) {
  const int shown = std::max(model.defaultScene, 0);
  if (!in_range(shown, model.scenes.size())) return;
  const tinygltf::Value& extras = model.scenes[static_cast<size_t>(shown)].extras;
  if (!extras.Has("viewFrom")) return;
  const tinygltf::Value& from = extras.Get("viewFrom");
  glm::vec3 direction(0);
  for (int i = 0; i < 3; ++i) {
    const bool is_number = from.IsArray() && from.ArrayLen() == 3 && from.Get(i).IsNumber();
    direction[i] = is_number ? to_float(from.Get(i).GetNumberAsDouble()) : 0;
  }
  const float length = glm::length(direction);
  if (length > 1e-6f && length < 1e6f)
    scene.view_from = direction / length;
  else
    scene.warnings.push_back(element("scenes", static_cast<size_t>(shown)) +
                             ".extras.viewFrom is no direction of three numbers");
}

}  // namespace

Result<void> add_lights(const GltfDocument& document, Scene& scene) {
  for (size_t i = 0; i < document.model.lights.size(); ++i) {
    auto light = light_of(document.model.lights[i], "extensions.KHR_lights_punctual." + element("lights", i),
                          scene.warnings);
    if (!light) return light.error();
    scene.lights.push_back(std::move(*light));
  }
  return {};
}

Result<void> add_cameras(const GltfDocument& document, Scene& scene) {
  add_default_view(document.model, scene);
  for (size_t i = 0; i < document.model.cameras.size(); ++i) {
    auto camera = camera_of(document.model.cameras[i], element("cameras", i), scene.warnings);
    if (!camera) return camera.error();
    scene.cameras.push_back(std::move(*camera));
  }
  return {};
}

}  // namespace fire3dv::scene
