// Pipelines that outlive their renderer. A later renderer of the same device takes them instead of compiling
// them again. For programs that make many renderers, such as tests: a CPU driver caches little of what a
// pipeline takes to compile.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

class PipelineMaking;

// Belongs to the device's thread.
class PipelineKeeper {
 public:
  // Pipelines created from now on are kept until the device ends.
  void start() { keeps_ = true; }
  bool keeps() const { return keeps_; }

  // Layouts are known by what they were made of: pipelines fit all layouts of equal descriptions. A handle
  // may name another object once its own is destroyed, hence forget().
  void describe(VkDescriptorSetLayout layout, std::string description);
  void describe(VkPipelineLayout layout, std::string description);
  void forget(VkDescriptorSetLayout layout) { set_layouts_.erase(layout); }
  void forget(VkPipelineLayout layout) { layouts_.erase(layout); }
  // The first layout of the same description, which lasts as long as the device. The layout itself where it
  // has no description.
  VkPipelineLayout lasting(VkPipelineLayout layout) const;
  // Nothing where the layout has no description, or no pipelines are kept.
  std::optional<std::string> description(VkDescriptorSetLayout layout) const;
  std::optional<std::string> description(VkPipelineLayout layout) const;

  // key: everything that the pipeline was made of. Null: none is kept.
  std::shared_ptr<PipelineMaking> find(const std::string& key) const;
  void keep(const std::string& key, std::shared_ptr<PipelineMaking> making);
  // A compiled pipeline of keep(), which its users do not destroy.
  void hold(VkPipeline pipeline) { held_.insert(pipeline); }
  bool holds(VkPipeline pipeline) const { return held_.contains(pipeline); }
  bool holds(VkPipelineLayout layout) const;

  // Requires that no thread compiles and no submission is in flight.
  void destroy_all(VkDevice device);

 private:
  bool keeps_ = false;
  std::map<VkDescriptorSetLayout, std::string> set_layouts_;
  std::map<VkPipelineLayout, std::string> layouts_;
  std::map<std::string, VkPipelineLayout> lasting_;  // by description
  std::map<std::string, std::shared_ptr<PipelineMaking>> kept_;
  std::set<VkPipeline> held_;
};

}  // namespace fire3dv::gpu
