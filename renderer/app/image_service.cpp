#include "renderer/app/image_service.h"

#include <chrono>
#include <cstring>

namespace fire3dv::app {
namespace {

using Reason = wire::ImageRefusal;

glm::mat4 matrix_of(const wire::Affine3x4& affine) {
  glm::mat4 matrix(1);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      matrix[column][row] = affine.m[static_cast<size_t>(row * 4 + column)];
  return matrix;
}

glm::mat4 matrix_of(const wire::Affine3x4d& affine) {
  wire::Affine3x4 single;
  for (size_t i = 0; i < 12; ++i) single.m[i] = static_cast<float>(affine.m[i]);
  return matrix_of(single);
}

wire::Affine3x4 affine_of(const glm::mat4& matrix) {
  wire::Affine3x4 affine;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      affine.m[static_cast<size_t>(row * 4 + column)] = matrix[column][row];
  return affine;
}

// A camera has no scale: Z keeps its direction, Y gives the plane of up, X follows. Nothing where these have
// no direction.
std::optional<glm::mat4> rigid(const glm::mat4& pose) {
  const glm::vec3 z(pose[2]);
  const float z_length = glm::length(z);
  if (!(z_length > 0) || !std::isfinite(z_length)) return {};
  const glm::vec3 back = z / z_length;
  const glm::vec3 y(pose[1]);
  const glm::vec3 up = y - glm::dot(y, back) * back;
  const float up_length = glm::length(up);
  if (!(up_length > 1e-6f * glm::length(y)) || !std::isfinite(up_length)) return {};
  glm::mat4 result(1);
  result[1] = glm::vec4(up / up_length, 0);
  result[2] = glm::vec4(back, 0);
  result[0] = glm::vec4(glm::cross(glm::vec3(result[1]), back), 0);
  result[3] = glm::vec4(glm::vec3(pose[3]), 1);
  return result;
}

int64_t monotonic_now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

// The targets that an image is drawn into have some 20 times its bytes with 4 samples.
state::ImageAbilities image_abilities() {
  return {.most_pixel_bytes = uint64_t{64} << 20};
}

std::optional<ImageService::Camera> ImageService::camera_of(const state::ImageBook::Due& due) {
  const wire::ImageRequest& request = due.request;
  const auto refuse = [&](Reason reason, const std::string& why) {
    intake_.refuse_image(due, reason, why);
    return std::nullopt;
  };
  Camera camera;
  const scene::Camera* own = nullptr;
  glm::mat4 world_from_parent(1);
  if (request.node.empty()) {
    world_from_parent = matrix_of(intake_.world_from_stream(due.asker));
  } else {
    const uint32_t node = poses_.names().find(request.node);
    if (node == scene::kNone)
      return refuse(Reason::unknown_camera, "no node of the scene, or several, are called \"" + request.node +
                                                "\"; name one, or give the camera's pose in the stream");
    world_from_parent = poses_.world_from_node(node);
    const scene::Scene& scene = scene_.scene();
    own = scene_.edits().camera_at(node);
    if (!own && scene.nodes[node].camera != scene::kNone) own = &scene.cameras[scene.nodes[node].camera];
  }
  const auto pose = rigid(world_from_parent * matrix_of(request.parent_from_camera));
  if (!pose) return refuse(Reason::bad_request, "the camera's pose is flat: it has no direction, or no up");
  camera.world_from_camera = *pose;
  const wire::Intrinsics& wanted = request.intrinsics;
  if (wanted.fx > 0) {
    camera.intrinsics = {wanted.fx,     wanted.fy,   wanted.cx, wanted.cy, {wanted.width, wanted.height},
                         wanted.near_m, wanted.far_m};
  } else {
    if (!own || own->orthographic)
      return refuse(Reason::unknown_camera,
                    "the node \"" + request.node + "\" has no perspective camera; give fx, fy, cx and cy");
    camera.intrinsics = passes::intrinsics_of(*own, {wanted.width, wanted.height});
  }
  if (own) camera.exposure = own->exposure;
  if (auto good = passes::check(camera.intrinsics); !good)
    return refuse(Reason::bad_request, good.error().message);
  return camera;
}

bool ImageService::draw_due(gpu::FrameRing& frames) {
  const std::vector<state::ImageBook::Due> due = intake_.take_due_images(monotonic_now_ns());
  for (const state::ImageBook::Due& one : due) {
    deliver();  // so that no more are under way than the device works at
    if (const std::optional<Camera> camera = camera_of(one)) draw(frames, one, *camera);
  }
  return !due.empty();
}

void ImageService::draw(gpu::FrameRing& frames, const state::ImageBook::Due& due, const Camera& camera) {
  const passes::Intrinsics& used = camera.intrinsics;
  const VkExtent2D extent{used.image_px.x, used.image_px.y};
  if (renderer_.extent().width != extent.width || renderer_.extent().height != extent.height)
    renderer_.set_size(extent);
  passes::View view = passes::make_view(used, camera.world_from_camera);
  view.camera = due.request.node;
  view.exposure = camera.exposure;

  Tag tag;
  tag.asker = due.asker;
  wire::ImageFrame& frame = tag.frame;
  frame.request = due.request.id;
  frame.number = due.number;
  frame.epoch = due.request.epoch;
  frame.sequence = due.sequence;
  frame.sim_time_ns = due.sim_time_ns;
  frame.world_from_camera = affine_of(camera.world_from_camera);
  frame.intrinsics = {extent.width, extent.height, used.fx_px, used.fy_px, used.cx_px,
                      used.cy_px,   used.near_m,   used.far_m, {}};

  gpu::Recorder& recorder = frames.begin();
  renderer_.record(recorder, frames.belt(), poses_, view);
  readback_.record(recorder, renderer_.image(), std::move(tag));
  readback_.submitted(frames.submit());
}

void ImageService::deliver() {
  readback_.poll([&](Tag tag, VkExtent2D extent, std::span<const uint8_t> rgba8) {
    wire::ImageFrame& frame = tag.frame;
    frame.planes = {
        {0, wire::ImageFormat::rgba8, extent.width, extent.height, 4 * extent.width, 0, rgba8.size()}};
    frame.pixel_bytes = (rgba8.size() + 63) / 64 * 64;
    intake_.send_image(tag.asker, frame, [&](std::span<std::byte> pixels) {
      std::memcpy(pixels.data(), rgba8.data(), rgba8.size());
      std::memset(pixels.data() + rgba8.size(), 0, pixels.size() - rgba8.size());
    });
  });
}

}  // namespace fire3dv::app
