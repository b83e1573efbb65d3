#include "renderer/passes/debug/inspector.h"

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Bit mask of a node and its descendants. Parents precede their children.
std::vector<uint32_t> bits_of_all_below(const scene::Scene& scene, uint32_t selected) {
  std::vector<uint32_t> bits(scene.nodes.size() / 32 + 1, 0);
  const auto is_set = [&](uint32_t node) { return (bits[node / 32] >> (node % 32) & 1) != 0; };
  for (uint32_t node = selected; node < scene.nodes.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    if (node == selected || (parent != scene::kNone && is_set(parent))) bits[node / 32] |= 1u << (node % 32);
  }
  return bits;
}

}  // namespace

Inspector::Inspector(gpu::Device& device, VkPipelineLayout layout, VkDescriptorSetLayout scene_set_layout,
                     uint32_t samples)
    : device_(device), layout_(layout), samples_(samples), overlay_(device, scene_set_layout) {}

void Inspector::pick(gpu::Recorder& recorder, const InspectedView& seen, const Pick& pick) {
  if (!pick_) pick_ = std::make_unique<PickPass>(device_, layout_, samples_);
  pick_->record(recorder, seen, pick);
}

DebugViews& Inspector::debug_views() {
  if (!debug_views_) debug_views_ = std::make_unique<DebugViews>(device_, layout_, overlay_, samples_);
  return *debug_views_;
}

void Inspector::outline(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen,
                        uint32_t selected, gpu::Image& image) {
  if (!outline_)
    outline_ = gpu::create_compute_pipeline(device_, overlay_.layout(),
                                            samples_ == 4 ? "outline_4.comp" : "outline_1.comp");
  const std::vector<uint32_t> bits = bits_of_all_below(seen.scene, selected);
  const gpu_types::OutlinePush push{seen.globals, seen.visibility.address,
                                    staging.write(std::span<const uint32_t>(bits)).address};
  std::vector<Use> uses{Use(seen.visibility, access::compute_read), Use(image, access::compute_write)};
  seen.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("outline", uses, [&](VkCommandBuffer commands) {
    overlay_.begin(commands, outline_, seen.gpu_scene, push);
    vkCmdDispatch(commands, (seen.extent.width + 7) / 8, (seen.extent.height + 7) / 8, 1);
  });
}

}  // namespace fire3dv::passes
