// Marker pass: draws markers of streams into the multisampled HDR colour, after blended surfaces and with
// their depth. One buffer holds the arrays of all markers as they came; vertices are generated in the vertex
// shader. Colours are display-referred: neither exposure nor tone mapping change them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <vector>

#include "renderer/gpu/device/vk.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/state/marker_registry.h"

namespace fire3dv::passes {

class MarkerPass {
 public:
  MarkerPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples)
      : device_(device), layout_(layout), samples_(samples) {}

  // Uploads values that are new since the last call, and forgets those that are gone.
  void update(gpu::Recorder& recorder, gpu::StagingRing& staging,
              std::span<const state::ShownMarker> markers);

  // Screen-space bounds of the markers of the last update(). The whole image if one crosses the near plane.
  VkRect2D bounds(std::span<const state::ShownMarker> markers, const View& view, VkExtent2D extent) const;

  struct Frame {
    Targets& targets;  // with colour and depth of the surfaces
    const View& view;
    VkDeviceAddress globals;
    VkRect2D area;  // scissor in the image
  };
  // Draws the markers of the last update().
  void record(gpu::Recorder& recorder, std::span<const state::ShownMarker> markers, const Frame& frame);

  // Number of bytes uploaded so far, for tests and measurements.
  uint64_t uploaded_bytes() const { return uploaded_bytes_; }
  // True while markers are not drawn for lack of device memory.
  bool lacks_memory() const { return lacks_memory_; }

 private:
  // Arrays of one value in the buffer.
  struct Place {
    VkDeviceSize positions = 0, rotations = 0, sizes = 0, colors = 0, end = 0;  // offsets
    bool is_opaque = true;
    scene::Box box;  // of the elements, in marker space, without widths
  };
  enum class Layer : uint8_t { opaque, blended, overlaid };
  static Place place_after(VkDeviceSize begin, const wire::Marker& marker);
  void write(gpu::StagingRing& staging, const wire::Marker& marker, const Place& place,
             std::vector<VkBufferCopy>& copies, std::vector<VkBuffer>& sources);
  bool grow(VkDeviceSize bytes);
  const gpu::Pipeline& pipeline(Layer layer, bool is_disc);
  void draw(VkCommandBuffer commands, const state::ShownMarker& shown, const Place& place, Layer layer,
            const Frame& frame);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  VkSampleCountFlagBits samples_;
  std::array<gpu::Pipeline, 6> pipelines_;  // by layer and disc; created on first use
  gpu::Buffer elements_;
  VkDeviceSize capacity_ = 0, end_ = 0;
  VkDeviceSize refused_bytes_ = UINT64_MAX;  // the smallest size that the device refused
  bool lacks_memory_ = false;
  std::map<uint64_t, Place> places_;  // by id
  uint64_t uploaded_bytes_ = 0;
};

}  // namespace fire3dv::passes
