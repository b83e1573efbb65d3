#include "renderer/passes/debug/pick_pass.h"

#include <cstring>

#include "shaders/shared/types.h"

namespace fire3dv::passes {

using gpu::Use;
namespace access = gpu::access;

PickPass::PickPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples)
    : layout_(layout),
      pipeline_(gpu::create_compute_pipeline(device, layout, samples == 4 ? "pick_4.comp" : "pick_1.comp")),
      picked_(gpu::create_buffer(device, sizeof(gpu_types::PickedSurface), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                 gpu::Memory::device)),
      belt_(device) {}

void PickPass::record(gpu::Recorder& recorder, const InspectedView& seen, const Pick& pick) {
  FIRE3DV_ASSERT(pick.x < seen.extent.width && pick.y < seen.extent.height);
  std::vector<Use> uses{Use(seen.visibility, access::compute_read), Use(picked_, access::compute_write)};
  seen.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("pick", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    const VkDescriptorSet set = seen.gpu_scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    gpu_types::PickPush push{};
    push.globals = seen.globals;
    push.visibility = seen.visibility.address;
    push.picked = picked_.address;
    push.look_world = seen.view.look_world;
    push.orthographic = seen.view.orthographic ? 1 : 0;
    push.x = pick.x;
    push.y = pick.y;
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, 1, 1, 1);
  });
  belt_.record(recorder, nullptr, {0, 0}, {&picked_, sizeof(gpu_types::PickedSurface)}, pick.tag);
}

std::vector<Picked> PickPass::take_picked() {
  std::vector<Picked> found;
  belt_.poll([&](uint64_t tag, VkExtent2D, std::span<const uint8_t> bytes) {
    gpu_types::PickedSurface surface;
    std::memcpy(&surface, bytes.data(), sizeof(surface));
    static_assert(scene::kNone == FIRE3DV_NO_INDEX);
    found.push_back({tag, surface.node, surface.world, surface.depth_m});
  });
  return found;
}

}  // namespace fire3dv::passes
