#include <charconv>
#include <chrono>

#include "adapters/mujoco/client_errors.h"
#include "adapters/mujoco/publisher.h"

namespace fire3dv::mujoco {
namespace {

using Clock = std::chrono::steady_clock;

Result<std::string> camera_node(const mjModel& m, const convert::MjcfNames& names,
                                const std::string& camera) {
  if (const int found = mj_name2id(&m, mjOBJ_CAMERA, camera.c_str()); found >= 0)
    return names.cameras[static_cast<size_t>(found)];
  if (camera == names.free_camera) return names.free_camera;
  size_t number = 0;
  const auto [end, error] = std::from_chars(camera.data(), camera.data() + camera.size(), number);
  if (error == std::errc() && end == camera.data() + camera.size() && number < names.cameras.size())
    return names.cameras[number];
  std::string known = "\"" + names.free_camera + "\"";
  for (const std::string& name : names.cameras) known += ", \"" + name + "\"";
  return Error{"the model has no camera \"" + camera + "\"; it has " + known};
}

}  // namespace

Result<uint64_t> Publisher::ask_images(const mjModel& model, const ImageSpec& wish) {
  if (targets_.empty()) return Error{"there is no renderer to ask for images: name where it listens"};
  const Result<std::string> node = camera_node(model, names_, wish.camera);
  if (!node) return node.error();
  fire3dv_image_request request{};
  request.node = node->c_str();
  request.width = wish.width;
  request.height = wish.height;
  request.outputs = wish.outputs;
  request.when = FIRE3DV_IMAGE_EVERY_NTH;
  uint64_t id = 0;
  const Result<void> asked =
      told("cannot ask for images", targets_[0].uri, [&] { id = targets_[0].stream.request_image(request); });
  if (!asked) return asked.error();
  return id;
}

Result<Image> Publisher::wait_image(uint64_t id, double timeout_s, const std::atomic<bool>& stop) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(timeout_s);
  uint64_t lost = 0;  // images lost or skipped here
  while (!stop) {
    Image image;
    const Result<void> waited = told("no images from", targets_[0].uri, [&] {
      image = targets_[0].stream.wait_image(id, std::chrono::milliseconds(100));  // short, so that `stop` is
                                                                                  // checked
    });
    if (!waited) return waited.error();
    if (image && image->sequence == sequence_) {
      image->lost += lost;
      return image;
    }
    if (image) lost += image->lost + (image->sequence > 0 ? 1 : 0);  // sequence 0: shows no frame
    if (Clock::now() >= deadline)
      return Error{"no renderer on " + targets_[0].uri + " has sent an image of frame " +
                   std::to_string(sequence_) + " in time: start one that listens there, or wait longer"};
  }
  return Image();
}

Result<Image> Publisher::take_image(uint64_t id) {
  Image image;
  const Result<void> taken = told("no images from", targets_[0].uri, [&] {
    image = targets_[0].stream.wait_image(id, std::chrono::milliseconds(0));
  });
  if (!taken) return taken.error();
  return image;
}

}  // namespace fire3dv::mujoco
