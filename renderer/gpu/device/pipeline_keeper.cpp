#include "renderer/gpu/device/pipeline_keeper.h"

#include <utility>

#include "renderer/gpu/device/pipeline_builder.h"

namespace fire3dv::gpu {
namespace {

template <typename Layout>
std::optional<std::string> found(const std::map<Layout, std::string>& descriptions, Layout layout) {
  const auto entry = descriptions.find(layout);
  return entry == descriptions.end() ? std::nullopt : std::optional(entry->second);
}

}  // namespace

void PipelineKeeper::describe(VkDescriptorSetLayout layout, std::string description) {
  if (keeps_) set_layouts_[layout] = std::move(description);
}

void PipelineKeeper::describe(VkPipelineLayout layout, std::string description) {
  if (!keeps_) return;
  lasting_.try_emplace(description, layout);
  layouts_[layout] = std::move(description);
}

std::optional<std::string> PipelineKeeper::description(VkDescriptorSetLayout layout) const {
  return found(set_layouts_, layout);
}

std::optional<std::string> PipelineKeeper::description(VkPipelineLayout layout) const {
  return found(layouts_, layout);
}

VkPipelineLayout PipelineKeeper::lasting(VkPipelineLayout layout) const {
  const auto entry = layouts_.find(layout);
  return entry == layouts_.end() ? layout : lasting_.at(entry->second);
}

bool PipelineKeeper::holds(VkPipelineLayout layout) const {
  return layouts_.contains(layout) && lasting(layout) == layout;
}

std::shared_ptr<PipelineMaking> PipelineKeeper::find(const std::string& key) const {
  const auto entry = kept_.find(key);
  return entry == kept_.end() ? nullptr : entry->second;
}

void PipelineKeeper::keep(const std::string& key, std::shared_ptr<PipelineMaking> making) {
  making->stay();
  kept_[key] = std::move(making);
}

void PipelineKeeper::destroy_all(VkDevice device) {
  for (const auto& [key, making] : kept_) {
    if (const VkPipeline pipeline = making->end()) vkDestroyPipeline(device, pipeline, nullptr);
  }
  for (const auto& [description, layout] : lasting_) vkDestroyPipelineLayout(device, layout, nullptr);
  kept_.clear();
  lasting_.clear();
  held_.clear();
}

}  // namespace fire3dv::gpu
