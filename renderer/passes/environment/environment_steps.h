// Compute steps of environment preprocessing: each writes one level of an image.
#pragma once

#include <string_view>
#include <vector>

#include "renderer/gpu/device/loader_commands.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

class EnvironmentSteps {
 public:
  EnvironmentSteps(gpu::Device& device, gpu::LoaderCommands& loader);

  // Reads all levels of `in` through a sampler.
  void sample(std::string_view shader, gpu::Image& in, VkSampler sampler, gpu::Image& out, uint32_t level,
              gpu_types::EnvironmentPush push);
  // Reads one level texel by texel.
  void load(std::string_view shader, gpu::Image& in, uint32_t in_level, gpu::Image& out, uint32_t level,
            gpu_types::EnvironmentPush push);
  // Reads no image.
  void fill(std::string_view shader, gpu::Image& out, gpu_types::EnvironmentPush push);

 private:
  struct Input {
    gpu::Image* image = nullptr;
    VkSampler sampler = VK_NULL_HANDLE;  // null: reads `level` texel by texel
    uint32_t level = 0;
  };
  void step(std::string_view shader, const Input& in, gpu::Image& out, uint32_t level,
            gpu_types::EnvironmentPush push);

  gpu::Device& device_;
  gpu::LoaderCommands& loader_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::DescriptorPool pool_;
  // Alive until the commands are done; they retire with this object.
  std::vector<gpu::ImageView> views_;
  std::vector<std::pair<std::string_view, gpu::Pipeline>> pipelines_;
};

}  // namespace fire3dv::passes
