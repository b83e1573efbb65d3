#include "adapters/mujoco/compare/image_client.h"

#include <atomic>
#include <cstring>
#include <utility>

#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::mujoco {
namespace {

const std::atomic<bool> kNeverStop{false};

}  // namespace

Result<RequestedImages> RequestedImages::open(const Simulation& simulation, const std::string& uri,
                                              const ImageSpec& spec, double timeout_s) {
  // Loads the scene as the renderer does, so that instance numbers match.
  std::vector<std::string> warnings;
  const auto glb = scene_of(simulation.model(), simulation.data(), "model", warnings);
  if (!glb) return glb.error();
  const Result<scene::Scene> scene = scene::load_glb(*glb, "model");
  if (!scene) return scene.error();
  Result<Publisher> publisher = Publisher::open(simulation.model(), {.uris = {uri}});
  if (!publisher) return publisher.error();
  const Result<uint64_t> request = publisher->request_images(simulation.model(), spec);
  if (!request) return request.error();
  return RequestedImages(std::move(*publisher), InstanceLabels(simulation.model(), *scene), *request,
                         timeout_s);
}

Result<Image> RequestedImages::draw(const Simulation& simulation) {
  publisher_.jump();  // makes every call publish a frame
  const Result<bool> sent = publisher_.publish(simulation.model(), simulation.data());
  if (!sent) return sent.error();
  return publisher_.wait_image(request_, timeout_s_, kNeverStop);
}

Result<LabelledDepth> RequestedImages::labelled(const fire3dv_image& image) const {
  const fire3dv_image_plane* const instances = plane_of(image, FIRE3DV_IMAGE_INSTANCE_U32);
  const fire3dv_image_plane* const depths = plane_of(image, FIRE3DV_IMAGE_DEPTH_F32);
  if (!instances || !depths) return Error{"the image has no labels and depths"};
  LabelledDepth found;
  found.width = image.width;
  found.height = image.height;
  const auto row = [](const fire3dv_image_plane& plane, uint32_t y) {
    return static_cast<const char*>(plane.data) + size_t{y} * plane.row_stride;
  };
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      uint32_t instance = 0;
      float depth_m = 0;
      std::memcpy(&instance, row(*instances, y) + sizeof instance * x, sizeof instance);
      std::memcpy(&depth_m, row(*depths, y) + sizeof depth_m * x, sizeof depth_m);
      found.labels.push_back(labels_[instance]);
      found.depths_m.push_back(depth_m);
    }
  }
  return found;
}

std::vector<uint8_t> RequestedImages::rgb(const fire3dv_image& image) {
  std::vector<uint8_t> found;
  const fire3dv_image_plane* const color = plane_of(image, FIRE3DV_IMAGE_COLOR_SRGB8);
  for (uint32_t y = 0; color && y < image.height; ++y) {
    const auto* const row = static_cast<const uint8_t*>(color->data) + size_t{y} * color->row_stride;
    for (uint32_t x = 0; x < image.width; ++x) found.insert(found.end(), row + 4 * x, row + 4 * x + 3);
  }
  return found;
}

}  // namespace fire3dv::mujoco
