#include "renderer/passes/post/lens_pass.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Address of a plane, or 0.
VkDeviceAddress address_of(VkDeviceAddress first, std::span<const PlaneRange> places, ImageOutput output) {
  for (const PlaneRange& place : places) {
    if (place.output == output) return first + place.offset_bytes;
  }
  return 0;
}

void grow(gpu::Device& device, gpu::Buffer& buffer, VkDeviceSize bytes) {
  if (buffer && buffer.size_bytes >= bytes) return;
  buffer = gpu::create_buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

}  // namespace

ImageOutputs pinhole_outputs(ImageOutputs outputs) {
  outputs = with_sources(outputs);
  // Depth is interpolated within one instance.
  if (outputs.has(wire::kDepthF32)) outputs.add(wire::kInstanceU32);
  return outputs;
}

LensPass::LensPass(gpu::Device& device)
    : device_(device),
      layout_(gpu::create_pipeline_layout(device, {})),
      pipeline_(
          gpu::create_compute_pipeline(device, layout_.get(), "lens.comp", gpu::Compile::on_first_use)) {}

void LensPass::copy_color(gpu::Recorder& recorder, gpu::Image& color) {
  recorder.pass("lens colors", {Use(color, access::transfer_read), Use(color_, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  VkBufferImageCopy copy{};
                  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
                  copy.imageExtent = {color.extent.width, color.extent.height, 1};
                  vkCmdCopyImageToBuffer(commands, color.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                         color_.get(), 1, &copy);
                });
}

gpu_types::LensWanted LensPass::describe(const Source& source, const Wanted& wanted) const {
  const Intrinsics &camera = wanted.camera, &pinhole = source.pinhole;
  const VkDeviceSize color_bytes =
      wanted.outputs.has(wire::kColorSrgb8) ? VkDeviceSize{4} * camera.image_px.x * camera.image_px.y : 0;
  const auto from = [&](ImageOutput output) {
    return source.planes ? address_of(source.planes->address, source.places, output) : 0;
  };
  const auto to = [&](ImageOutput output) {
    return address_of(result_.address + color_bytes, places_, output);
  };
  gpu_types::LensWanted w{};
  w.color_in = wanted.outputs.has(wire::kColorSrgb8) ? color_.address : 0;
  w.color_out = wanted.outputs.has(wire::kColorSrgb8) ? result_.address : 0;
  w.linear_in = from(wire::kColorLinearF16);
  w.linear_out = to(wire::kColorLinearF16);
  w.depth_in = from(wire::kDepthF32);
  w.depth_out = to(wire::kDepthF32);
  w.instance_in = from(wire::kInstanceU32);
  w.instance_out = to(wire::kInstanceU32);
  w.semantic_in = from(wire::kSemanticU32);
  w.semantic_out = to(wire::kSemanticU32);
  w.normal_in = from(wire::kNormal);
  w.normal_out = to(wire::kNormal);
  w.motion_in = from(wire::kMotion);
  w.motion_out = to(wire::kMotion);
  w.width = camera.image_px.x;
  w.height = camera.image_px.y;
  w.width_in = pinhole.image_px.x;
  w.height_in = pinhole.image_px.y;
  w.focal = {camera.fx_px, camera.fy_px};
  w.principal_point = {camera.cx_px, camera.cy_px};
  w.focal_in = {pinhole.fx_px, pinhole.fy_px};
  w.principal_point_in = {pinhole.cx_px, pinhole.cy_px};
  const auto& k = wanted.lens.coefficients;
  w.coefficients = {k[0], k[1], k[2], k[3]};
  w.last_coefficient = k[4];
  w.largest_radius = static_cast<float>(largest_radius(wanted.lens));
  w.fisheye = wanted.lens.model == LensModel::fisheye ? 1 : 0;
  return w;
}

void LensPass::make_room(const Intrinsics& pinhole, const Wanted& wanted) {
  const glm::uvec2 size = wanted.camera.image_px, behind = pinhole.image_px;
  places_ = lay_out_planes(with_sources(wanted.outputs), size.x, size.y);
  result_bytes_ =
      (wanted.outputs.has(wire::kColorSrgb8) ? uint64_t{4} * size.x * size.y : 0) + bytes_of(places_);
  grow(device_, result_, result_bytes_);
  if (wanted.outputs.has(wire::kColorSrgb8)) grow(device_, color_, VkDeviceSize{4} * behind.x * behind.y);
}

void LensPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                      const Wanted& wanted) {
  const glm::uvec2 size = wanted.camera.image_px;
  make_room(source.pinhole, wanted);
  if (source.color) copy_color(recorder, *source.color);
  const gpu_types::LensWanted described = describe(source, wanted);
  const gpu_types::LensPush push{
      staging.write(std::span<const gpu_types::LensWanted>(&described, 1)).address};
  std::vector<Use> uses{Use(result_, access::compute_write)};
  if (source.color) uses.emplace_back(color_, access::compute_read);
  if (source.planes) uses.emplace_back(*source.planes, access::compute_read);
  recorder.pass("lens", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (size.x + 7) / 8, (size.y + 7) / 8, 1);
  });
}

}  // namespace fire3dv::passes
