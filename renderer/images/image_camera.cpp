#include "renderer/images/image_camera.h"

#include <cmath>
#include <utility>

#include "base/error.h"
#include "renderer/scene/model/math.h"

namespace fire3dv::app {
namespace {

using Reason = wire::ImageRefusal;

constexpr uint32_t kMaxPinholeSide = 4096;
constexpr float kMaxDistance_m = 1e12f;  // that images can name

// Removes scale and shear: Z keeps its direction, Y defines the up plane, X follows. Returns nothing for
// degenerate axes and positions that images cannot name.
std::optional<glm::mat4> rigid(const glm::mat4& pose) {
  const glm::vec3 z(pose[2]);
  const float z_length = glm::length(z);
  if (!(z_length > 0) || !std::isfinite(z_length)) return {};
  const glm::vec3 back = z / z_length;
  const glm::vec3 y(pose[1]);
  const glm::vec3 up = y - glm::dot(y, back) * back;
  const float up_length = glm::length(up);
  if (!(up_length > 1e-6f * glm::length(y)) || !std::isfinite(up_length)) return {};
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(pose[3][axis]) <= kMaxDistance_m)) return {};
  glm::mat4 result(1);
  result[1] = glm::vec4(up / up_length, 0);
  result[2] = glm::vec4(back, 0);
  result[0] = glm::vec4(glm::cross(glm::vec3(result[1]), back), 0);
  result[3] = glm::vec4(glm::vec3(pose[3]), 1);
  return result;
}

// Whether the axes of a pose without scale are those of the rigid transform: neither sheared nor mirrored.
bool is_scaled(const glm::mat4& pose, const glm::mat4& rigid_pose) {
  for (int axis = 0; axis < 3; ++axis)
    if (glm::distance(glm::normalize(glm::vec3(pose[axis])), glm::vec3(rigid_pose[axis])) > 1e-5f)
      return false;
  return true;
}

// Reason why a name finds no node.
std::string unknown_node(const scene::Scene& scene, const std::string& name) {
  const auto count = std::ranges::count(scene.nodes, name, &scene::Node::name);
  if (count > 1)
    return std::to_string(count) + " scene nodes are called \"" + name + "\"; name the path of one of them";
  return "no scene node is called \"" + name + "\"; check the name, or give the camera's pose in the stream";
}

}  // namespace

wire::Affine3x4 affine_of(const glm::mat4& matrix) {
  wire::Affine3x4 affine;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      affine.m[static_cast<size_t>(row * 4 + column)] = matrix[column][row];
  return affine;
}

passes::View pinhole_view(const ImageCamera& camera) {
  if (!camera.node_camera) return passes::make_view(camera.pinhole, camera.world_from_camera);
  const glm::vec2 size(camera.pinhole.image_px);
  return passes::make_view(camera.node_camera->camera, camera.node_camera->world_from_camera,
                           size.x / size.y);
}

std::variant<ImageCamera, CameraRefused> resolve_camera(const wire::ImageRequest& request,
                                                        const wire::Affine3x4d& world_from_stream,
                                                        const state::PoseState& poses,
                                                        const LiveScene& live) {
  ImageCamera camera;
  const scene::Camera* own = nullptr;
  glm::mat4 world_from_parent(1);
  if (request.node.empty()) {
    world_from_parent = glm::mat4(scene::to_dmat4(world_from_stream));
  } else {
    const uint32_t node = poses.names().find(request.node);
    if (node == scene::kNone)
      return CameraRefused{Reason::unknown_camera, unknown_node(live.scene(), request.node)};
    world_from_parent = poses.world_from_node(node);
    const scene::Scene& scene = live.scene();
    own = live.edits().camera_at(node);
    if (!own && scene.nodes[node].camera != scene::kNone) own = &scene.cameras[scene.nodes[node].camera];
  }
  const glm::mat4 world_from_camera = world_from_parent * scene::to_mat4(request.parent_from_camera);
  const auto pose = rigid(world_from_camera);
  if (!pose)
    return CameraRefused{
        Reason::bad_request,
        "the camera's pose is flat (it has no direction, or no up), or more than 1e12 m away"};
  camera.world_from_camera = *pose;
  const wire::Intrinsics& wanted = request.intrinsics;
  if (wanted.fx > 0) {
    camera.intrinsics = {wanted.fx,     wanted.fy,   wanted.cx, wanted.cy, {wanted.width, wanted.height},
                         wanted.near_m, wanted.far_m};
    camera.lens = wanted.lens;
  } else {
    if (!own || own->orthographic)
      return CameraRefused{
          Reason::unknown_camera,
          "the node \"" + request.node + "\" has no perspective camera; give fx, fy, cx and cy"};
    camera.intrinsics = passes::intrinsics_of(*own, {wanted.width, wanted.height});
    if (camera.intrinsics.far_m > kMaxDistance_m) camera.intrinsics.far_m = 0;  // none
    if (camera.intrinsics.near_m > kMaxDistance_m)
      return CameraRefused{Reason::bad_request, "the camera of the node \"" + request.node +
                                                    "\" has a near distance of more than 1e12 m"};
    if (is_scaled(world_from_camera, *pose)) camera.node_camera = {*own, world_from_camera};
  }
  if (own) camera.exposure = own->exposure;
  if (own && !own->orthographic) camera.thin_lens = own->lens;
  if (wanted.f_number > 0) camera.thin_lens = {wanted.f_number, wanted.focus_distance_m, true};
  if (auto good = passes::check(camera.intrinsics); !good)
    return CameraRefused{Reason::bad_request, good.error().message};
  camera.pinhole = camera.intrinsics;
  if (camera.lens.model == passes::LensModel::none) return camera;
  Result<passes::Intrinsics> pinhole =
      passes::pinhole_behind(camera.intrinsics, camera.lens, kMaxPinholeSide);
  if (!pinhole) return CameraRefused{Reason::bad_request, pinhole.error().message};
  camera.pinhole = *pinhole;
  return camera;
}

}  // namespace fire3dv::app
