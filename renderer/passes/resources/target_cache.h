// Cache of targets: those of the last few small sizes are reused.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "renderer/passes/resources/targets.h"

namespace fire3dv::passes {

class TargetCache {
 public:
  TargetCache(gpu::Device& device, VkSampleCountFlagBits samples) : device_(device), samples_(samples) {}

  // Null before the first select(), and after one that failed.
  Targets* current() const { return current_; }
  // Makes targets of this size the current ones. create: binds new ones. use: hands others than the current
  // ones to the passes, and may throw VulkanFailure; they leave the cache then.
  void select(VkExtent2D extent, uint32_t views, const std::function<void(Targets&)>& create,
              const std::function<void(Targets&)>& use);
  // Invalidates the ids of all visibility buffers.
  void invalidate_ids();

 private:
  void find_or_create(VkExtent2D extent, uint32_t views, const std::function<void(Targets&)>& create);
  void drop_old();

  gpu::Device& device_;
  VkSampleCountFlagBits samples_;
  std::vector<std::unique_ptr<Targets>> cache_;  // newest first
  Targets* current_ = nullptr;                   // the first of them
};

}  // namespace fire3dv::passes
