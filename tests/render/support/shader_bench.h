// Bench for single shaders: tests can run each variant, independent of the device's choice.
#pragma once

#include <array>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "renderer/gpu/bindless_textures.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "tests/render/support/render_bench.h"

namespace fire3dv::test {

template <typename T>
gpu::Buffer uploaded(const std::vector<T>& values) {
  gpu::Buffer buffer = gpu::create_buffer(device(), values.size() * sizeof(T),
                                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::upload);
  std::memcpy(buffer.mapped, values.data(), values.size() * sizeof(T));
  return buffer;
}

// Zeroed buffer for shader writes and host reads.
inline gpu::Buffer written_by_shaders(VkDeviceSize bytes) {
  gpu::Buffer buffer =
      gpu::create_buffer(device(), bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::readback);
  std::memset(buffer.mapped, 0, bytes);
  return buffer;
}

// Compute pipelines by shader name, with the pipeline layout of the passes.
class ShaderPipelines {
 public:
  explicit ShaderPipelines(uint32_t max_textures)
      : set_layout_(gpu::BindlessTextures::create_layout(device(), max_textures)),
        layout_(gpu::create_pipeline_layout(device(), std::array{set_layout_.get()})) {}

  VkPipelineLayout layout() const { return layout_.get(); }

  VkPipeline of(const std::string& shader) {
    gpu::Pipeline& known = pipelines_[shader];
    if (!known) known = made(shader);
    return known.get();
  }

 private:
  gpu::Pipeline made(const std::string& shader) const {
    const gpu::ShaderModule module = gpu::create_shader_module(device(), shader);
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module.get();
    info.stage.pName = "main";
    info.layout = layout_.get();
    VkPipeline pipeline = VK_NULL_HANDLE;
    EXPECT_EQ(vkCreateComputePipelines(device().handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
              VK_SUCCESS);
    return gpu::Pipeline(device(), pipeline);
  }

  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  std::map<std::string, gpu::Pipeline> pipelines_;
};

}  // namespace fire3dv::test
