#include "renderer/passes/post/depth_of_field_pass.h"

#include <algorithm>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

uint32_t tiles_along(uint32_t pixels) {
  return (pixels + FIRE3DV_BLUR_TILE - 1) / FIRE3DV_BLUR_TILE;
}

}  // namespace

CircleOfConfusion circle_of_confusion(const View& view, const scene::ThinLens& lens, VkExtent2D image) {
  // The reversed depth is change + at_eye / z at the distance z along the view direction.
  const glm::dvec4 row = glm::transpose(glm::dmat4(view.clip_from_world))[2];
  const double at_eye = glm::dot(row, glm::dvec4(view.eye_world, 1));
  const double change = glm::dot(glm::dvec3(row), glm::dvec3(view.look_world));
  const double half_height = glm::length(glm::dvec3(view.world_from_ndc_y));  // at distance 1
  const double focal_length_m = static_cast<double>(scene::kSensorHeightM) / 2 / half_height;
  const double lens_radius_m = focal_length_m / static_cast<double>(lens.f_number) / 2;
  const double fy_px = image.height / (2 * half_height);
  const double fx_px = image.width / (2 * glm::length(glm::dvec3(view.world_from_ndc_x)));
  const double longer_px = std::max(fx_px, fy_px);
  // A difference by rounding alone is none.
  const auto stretch = [&](double focal_px) {
    return longer_px < 1.0001 * focal_px ? 1.0f : static_cast<float>(longer_px / focal_px);
  };
  const double scale = lens_radius_m * longer_px;  // radius = scale * (1 / focus - 1 / z)
  const double background = scale / static_cast<double>(lens.focus_distance_m);
  constexpr double kMax = 1e30;  // finite, also where the near distance is nearly 0
  return {static_cast<float>(std::clamp(background + scale * change / at_eye, -kMax, kMax)),
          static_cast<float>(std::clamp(-scale / at_eye, -kMax, kMax)),
          static_cast<float>(background),
          {stretch(fx_px), stretch(fy_px)}};
}

DepthOfFieldPass::DepthOfFieldPass(gpu::Device& device, VkSampleCountFlagBits samples)
    : device_(device),
      split_(device,
             samples == VK_SAMPLE_COUNT_1_BIT ? "depth_of_field_split.comp"
                                              : "depth_of_field_split_multisampled.comp",
             VK_FILTER_NEAREST),
      gather_(device,
              samples == VK_SAMPLE_COUNT_1_BIT ? "depth_of_field_gather.comp"
                                               : "depth_of_field_gather_multisampled.comp",
              VK_FILTER_NEAREST) {}

void DepthOfFieldPass::allocate(Targets& targets) {
  const VkExtent2D extent = targets.extent;
  gpu::grow_storage_buffer(device_, texels_,
                           VkDeviceSize{extent.width} * extent.height * sizeof(gpu_types::BlurTexel));
  gpu::grow_storage_buffer(
      device_, tiles_,
      VkDeviceSize{tiles_along(extent.width)} * tiles_along(extent.height) * sizeof(gpu_types::BlurTile));
  if (targets.depth_of_field_set.get() == VK_NULL_HANDLE)
    targets.depth_of_field_set = gather_.bind(nullptr, targets.hdr);
}

void DepthOfFieldPass::record(gpu::Recorder& recorder, Targets& targets, VkDeviceAddress globals,
                              const CircleOfConfusion& circle) {
  gpu_types::DepthOfFieldPush push{};
  push.globals = globals;
  push.visibility = targets.visibility.buffer.address;
  push.texels = texels_.address;
  push.tiles = tiles_.address;
  push.width = targets.extent.width;
  push.height = targets.extent.height;
  push.samples = targets.samples;
  push.generation = targets.visibility.generation();
  push.radius_at_zero = circle.at_zero;
  push.radius_per_depth = circle.per_depth;
  push.radius_of_background = circle.background;
  push.stretch = circle.stretch;
  const ImageFilter::Images images{nullptr, targets.hdr, targets.depth_of_field_set};
  const Use written[] = {{targets.visibility.buffer, access::compute_read},
                         {texels_, access::compute_write},
                         {tiles_, access::compute_write}};
  split_.record(recorder, "lens layers", images, push, written, targets.extent);
  const Use read[] = {{texels_, access::compute_read}, {tiles_, access::compute_read}};
  gather_.record(recorder, "lens blur", images, push, read, targets.extent);
}

}  // namespace fire3dv::passes
