// Benches of the proofs: many scenes and views with few renderers, and single shaders. Direct light only,
// without environment, tone mapping and anti-aliasing, so that bytes are comparable.
#pragma once

#include <array>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

settings::DrawSettings plain_settings(uint32_t samples = 1);
settings::DrawSettings shadowed_by(settings::ShadowMethod method, bool hybrid = true, uint32_t samples = 1);
// Selects shadow maps at the resolution that a GPU uses with hybrid shadows, on any device.
settings::DrawSettings with_fine_maps(settings::DrawSettings settings);
constexpr uint32_t kFineMapSide = 2048;

// One renderer for successive scenes.
class ProofBench {
 public:
  ProofBench(VkExtent2D extent, const settings::DrawSettings& settings);

  void show(const scene::Scene& scene);  // must outlive its use
  sinks::FrameImage draw(const scene::Camera& camera, const glm::mat4& world_from_camera);
  sinks::FrameImage draw(glm::vec3 eye, glm::vec3 target, float vertical_fov_rad = 0.7f,
                         float near_m = 0.01f);
  sinks::FrameImage draw_first_camera();
  passes::SceneRenderer& renderer() { return bench_.renderer(); }

 private:
  scene::Scene nothing_;
  const scene::Scene* scene_ = nullptr;
  RenderBench bench_;
};

struct Brightness {
  uint32_t brighter = 0, darker = 0;  // pixel counts of one image compared with the other
  uint32_t x = 0, y = 0;              // position of the last brighter pixel
  uint32_t dark = 0, bright = 0;      // pixel counts of the other image
};
Brightness compare_brightness(const sinks::FrameImage& image, const sinks::FrameImage& other,
                              int more_than = 0);

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

// Compute pipelines by shader name, with the pipeline layout of the passes. Tests can run each variant of a
// shader, independent of the device's choice.
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
