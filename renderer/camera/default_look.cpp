#include "renderer/camera/default_look.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/passes/view/facing.h"
#include "renderer/passes/view/framing.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/scene/model/exposure_estimate.h"
#include "renderer/scene/textures/environment.h"

namespace fire3dv::app {
namespace {

constexpr float kGroundRadii = 2.5f;  // of the scene
// Farthest shadows, in ground radii: they have hardly begun to fade.
constexpr float kFarthestShadow = 0.55f;
constexpr float kMaxGroundGrowth = 6;  // for shadows of low lights

// The eye, or with w 0 the direction towards an orthographic camera.
glm::vec4 eye_of(const passes::View& view) {
  return view.orthographic ? glm::vec4(-view.look_world, 0) : glm::vec4(view.eye_world, 1);
}

std::vector<glm::vec3> corners_of(const scene::Box& box) {
  std::vector<glm::vec3> corners;
  for (int corner = 0; corner < 8; ++corner)
    corners.emplace_back(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                         corner & 4 ? box.high.z : box.low.z);
  return corners;
}

std::optional<scene::Ground> ground_below(const ViewDefaults& defaults, const scene::Scene& scene) {
  // Other backgrounds have a horizon of their own, or are meant to be one colour.
  const bool has_sky = defaults.background.show_sky && scene.sky_texture != scene::kNone;
  const bool is_default = defaults.background.zenith && !defaults.background.show_environment && !has_sky;
  if (defaults.ground == GroundMode::off || (defaults.ground == GroundMode::automatic && !is_default))
    return std::nullopt;
  const scene::Box box = passes::bounds_without_outliers(scene, state::rest_pose(scene).world_from_node);
  if (box.empty()) return std::nullopt;
  scene::Ground ground;
  ground.radius_m = kGroundRadii * 0.5f * glm::length(box.high - box.low);
  if (!(ground.radius_m > 0) || !std::isfinite(ground.radius_m)) return std::nullopt;
  ground.height_m = defaults.ground == GroundMode::height ? defaults.ground_height_m : box.low.y;
  ground.center_world = {0.5f * (box.low.x + box.high.x), 0.5f * (box.low.z + box.high.z)};
  const float largest_m = kMaxGroundGrowth * ground.radius_m;
  for (const std::vector<glm::vec3>& of_light :
       passes::ground_shadows(scene, corners_of(box), ground.height_m)) {
    for (const glm::vec3& shadow : of_light) {
      const float reach_m =
          glm::distance(glm::vec2(shadow.x, shadow.z), ground.center_world) / kFarthestShadow;
      if (reach_m > ground.radius_m) ground.radius_m = std::min(reach_m, largest_m);
    }
  }
  return ground;
}

// The view that the scene has without options, at rest. Exposure does not depend on --camera, so that all
// cameras of a scene agree.
scene::SeenFrom default_view(const scene::Scene& scene) {
  constexpr float kAspect = 4.0f / 3;
  const Result<CameraRig> rig = CameraRig::create(scene);
  const passes::View view = rig ? rig->view(state::PoseState(scene), kAspect) : passes::View();
  return {view.clip_from_world, eye_of(view)};
}

// Image-space extent of the points in front of the camera, in normalised device coordinates.
struct Extent {
  glm::vec2 low{1e30f}, high{-1e30f};
  size_t in_front = 0;
};

Extent extent_of(const std::vector<glm::vec3>& points, const passes::View& view) {
  Extent extent;
  for (const glm::vec3& point : points) {
    const glm::vec4 clip = view.clip_from_world * glm::vec4(point, 1);
    if (!(clip.w > 0)) continue;
    ++extent.in_front;
    extent.low = glm::min(extent.low, glm::vec2(clip) / clip.w);
    extent.high = glm::max(extent.high, glm::vec2(clip) / clip.w);
  }
  return extent;
}

}  // namespace

bool wants_key_light(KeyLight wanted, bool has_chosen_light) {
  if (wanted != KeyLight::automatic) return wanted == KeyLight::on;
  return !has_chosen_light;
}

CameraStart camera_start(const ViewDefaults& defaults, const scene::Scene& scene, const std::string& camera,
                         std::vector<uint32_t> animations) {
  return {camera, defaults.frame_all, std::move(animations), ground_below(defaults, scene)};
}

std::string set_exposure(const settings::PostSettings& wanted, const scene::Scene& scene,
                         settings::DrawSettings& settings) {
  if (!wanted.estimated) {
    settings.post.exposure = wanted.exposure;
    return "";
  }
  const float radiance =
      settings.environment_intensity *
      (settings.environment ? scene::mean_radiance(*settings.environment) : scene::kStudioMeanRadiance);
  const scene::ExposureEstimate estimate =
      scene::estimate_exposure(scene, radiance, [&] { return default_view(scene); });
  settings.post.exposure = estimate.exposure;
  if (estimate.exposure == 1 || settings.post.metered) return "";
  char text[160];
  std::snprintf(text, sizeof(text), "exposure %.3g: lights give about %.3g lux (--exposure X sets another)",
                static_cast<double>(estimate.exposure), static_cast<double>(estimate.illuminance_lux));
  return text;
}

std::optional<std::string> reason_for_empty_image(const scene::Scene& scene, const scene::SceneEdits* edits,
                                                  const state::PoseState& poses, const passes::View& view,
                                                  uint32_t image_height) {
  size_t instances = 0;
  std::vector<glm::mat4> world_from_node;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) world_from_node.push_back(poses.world_from_node(n));
  std::vector<glm::vec3> points;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh == scene::kNone) continue;
    ++instances;
    if (edits && edits->is_hidden(n)) continue;
    const scene::Box box = scene::bounds_in_world(scene, n, world_from_node);
    if (box.empty()) continue;
    const std::vector<glm::vec3> corners = corners_of(box);
    points.insert(points.end(), corners.begin(), corners.end());
  }
  if (instances == 0) return "the scene has no meshes";
  if (points.empty()) return "all meshes are hidden or empty";
  const std::string camera = view.camera.empty() ? "the camera" : "camera \"" + view.camera + "\"";
  const Extent extent = extent_of(points, view);
  if (extent.in_front == 0) return "everything is behind " + camera + "; --camera auto shows the whole scene";
  if (passes::front_facing_share(scene, edits, world_from_node, eye_of(view)) == 0)
    return "only backs of single-sided triangles are towards " + camera +
           "; look from the other side (--camera auto), or make the material double-sided";
  if (extent.in_front < points.size()) return std::nullopt;  // partly behind: the extent is unknown
  if (extent.low.x > 1 || extent.low.y > 1 || extent.high.x < -1 || extent.high.y < -1)
    return "everything is outside of the view of " + camera + "; --camera auto shows the whole scene";
  const glm::vec2 size = extent.high - extent.low;
  if (0.5f * std::max(size.x, size.y) * static_cast<float>(image_height) < 1)
    return "the whole scene is smaller than a pixel for " + camera + "; --camera auto comes nearer";
  return std::nullopt;
}

}  // namespace fire3dv::app
