// Optics and sensor of a camera: condensation, lateral colour, vignette, noise, response curve and content
// mask, from exposed light to the pixels of `color`. docs/endoscope.md has the formulas.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view/view.h"
#include "renderer/settings/post_settings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Identity of a frame for noise, of the shown simulated time and the view: the same on every drawing, another
// one for each camera of a frame.
uint64_t frame_hash(const View& view, std::optional<int64_t> sim_time_ns);

class SensorPass {
 public:
  // samples: of the HDR target. is_path_traced: the light comes from path-traced sums instead.
  SensorPass(gpu::Device& device, VkSampleCountFlagBits samples, bool is_path_traced);

  // Allocates the memory of an image with these settings.
  void allocate(Targets& targets, const View* view, const settings::PostSettings& settings);
  struct Source {
    const View& view;
    std::optional<int64_t> sim_time_ns;
    const settings::PostSettings& settings;  // with the exposure and bloom of this image
    MeteredExposure metered;
    gpu::Buffer* sums;  // of a path-traced image, else null
  };
  // Writes light(): exposed, with bloom and condensation.
  void record_light(gpu::Recorder& recorder, gpu::StagingRing& staging, Targets& targets,
                    const Source& source);
  // Light of the last image for develop(), gpu_types::SensorRecord::light.
  gpu::Buffer& light() { return shown_light_ ? *shown_light_ : light_; }
  // Develops light(), of targets.extent, into targets.display.
  void develop(gpu::Recorder& recorder, gpu::StagingRing& staging, Targets& targets, const Source& source);
  // The same for light that a lens has distorted, of any size; into the returned image, which stays valid
  // until the next call.
  gpu::Image& develop(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Buffer& light,
                      VkExtent2D extent, const Source& source);

 private:
  gpu_types::SensorRecord describe(VkExtent2D extent, const Source& source) const;
  void condense(gpu::Recorder& recorder, const gpu_types::SensorPush& push,
                const gpu_types::SensorRecord& record);
  void dispatch(gpu::Recorder& recorder, const char* name, gpu::Pipeline& pipeline,
                const gpu_types::SensorPush& push, std::span<const gpu::Use> uses, VkExtent2D groups);
  void record_sensor(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu_types::SensorRecord record,
                     gpu::Buffer& light, gpu::Image& out, const gpu::DescriptorSet& set);
  // Cells of the coarse image that fog is blurred in.
  struct Grid {
    uint32_t block = 1, width = 0, height = 0;
    float blur_cells = 1;
    VkDeviceSize cells() const { return VkDeviceSize{width} * height; }
  };
  static Grid grid_of(VkExtent2D extent, float focal_px, const settings::OpticsSettings& optics);

  gpu::Device& device_;
  VkSampleCountFlagBits samples_;
  bool is_path_traced_;
  ImageFilter sensor_;
  std::unique_ptr<ImageFilter> light_filters_[2];  // without and with bloom, created on first use
  gpu::PipelineLayout layout_;
  struct Condensation {
    gpu::Pipeline blocks, blur, means, window;
  };
  std::optional<Condensation> condensation_;  // created on first use
  gpu::Buffer light_, fogged_, grid_, means_;
  gpu::Buffer* shown_light_ = nullptr;
  gpu::Image developed_;
  gpu::DescriptorSet developed_set_;
};

// Empties the pixels of planes beyond a content mask, with the values of the background.
class MaskPlanesPass {
 public:
  explicit MaskPlanesPass(gpu::Device& device);
  void record(gpu::Recorder& recorder, gpu::Buffer& planes, std::span<const PlaneRange> places,
              VkExtent2D extent, const settings::OpticsSettings& optics);

 private:
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
};

}  // namespace fire3dv::passes
