// Compute filter from one image to another of the same size: tone mapping, anti-aliasing.
#pragma once

#include <string_view>

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"

namespace fire3dv::passes {

class ImageFilter {
 public:
  // The shader reads FIRE3DV_BINDING_FILTER_IN through a sampler (linear or nearest) and writes
  // FIRE3DV_BINDING_FILTER_OUT.
  ImageFilter(gpu::Device& device, std::string_view shader, VkFilter sampling);

  // Source and target with their descriptor set.
  struct Images {
    gpu::Image& in;
    gpu::Image& out;
    const gpu::DescriptorSet& set;
  };
  gpu::DescriptorSet bind(const gpu::Image& in, const gpu::Image& out) const;

  // also_written: a buffer that the push constants refer to, or null. part: size of the processed area, from
  // the corner that the push constants name; the rest of `out` stays. Empty: the whole image.
  template <typename Push>
  void record(gpu::Recorder& recorder, const char* name, const Images& images, const Push& push,
              gpu::Buffer* also_written = nullptr, VkExtent2D part = {0, 0}) {
    static_assert(sizeof(Push) <= gpu::kPushConstantBytes);
    record(recorder, name, images, &push, sizeof(Push), also_written, part);
  }

 private:
  void record(gpu::Recorder& recorder, const char* name, const Images& images, const void* push,
              uint32_t push_bytes, gpu::Buffer* also_written, VkExtent2D part);

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Sampler sampler_;
};

}  // namespace fire3dv::passes
