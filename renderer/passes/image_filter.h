// A compute pass from one image to another of the same size: tone mapping, anti-aliasing.
#pragma once

#include <string_view>

#include "renderer/gpu/descriptors.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/gpu/recorder.h"

namespace fire3dv::passes {

class ImageFilter {
 public:
  // The shader reads FIRE3DV_BINDING_FILTER_IN through a sampler (linear or nearest) and writes
  // FIRE3DV_BINDING_FILTER_OUT.
  ImageFilter(gpu::Device& device, std::string_view shader, VkFilter sampling);

  // From one to the other, and the set by which the shader reaches them.
  struct Images {
    gpu::Image& in;
    gpu::Image& out;
    const gpu::DescriptorSet& set;
  };
  gpu::DescriptorSet bind(const gpu::Image& in, const gpu::Image& out) const;

  // also_written: a buffer that the push names; may be null. part: of the image, from its corner on; what
  // else is in `out` stays. Of no size: all of it.
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
