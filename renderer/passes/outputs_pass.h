// The planes of an image that follow from ids and depths: see image_outputs.h.
#pragma once

#include <memory>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/passes/gpu_scene.h"
#include "renderer/passes/image_outputs.h"
#include "renderer/passes/view.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Where everything was when a camera took its last image, for motion. Its owner keeps one for each camera;
// those of one frame share the places.
struct CameraHistory {
  std::shared_ptr<gpu::Buffer> world_from_node;
  glm::mat4 clip_from_world{1};
  uint64_t scene = 0;  // SceneRenderer's count of scenes; 0: no image was taken
};

class OutputsPass {
 public:
  // samples: 1 or 4.
  OutputsPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples);

  void set_scene() { ++scenes_, labels_ = {}; }  // another one is drawn from now on

  // Everything has moved since the last record().
  void places_are_new() { places_now_.reset(); }
  // False: histories hold the places of so many frames that those of another one have no room.
  bool can_keep_places(const GpuScene& scene) const;

  // Makes the planes, and what motion keeps, large enough. Before whatever writes any of them; may be called
  // again.
  // Planes of several views lie one below the other.
  void begin(const ImageOutputs& outputs, const GpuScene& scene, VkExtent2D extent, uint32_t views);

  // What images are taken of.
  struct Taken {
    const scene::Scene& scene;
    GpuScene& gpu_scene;
    gpu::Buffer& visibility;  // of the triangles themselves: before surfaces are merged
    std::span<const View> views;
    std::span<const VkDeviceAddress> globals;  // of each view
  };
  // histories: of each view's camera, or none where no motion is wanted; are those of these images
  // afterwards.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, const Taken& taken,
              std::span<CameraHistory> histories);

  gpu::Buffer& planes() { return planes_; }
  const std::vector<PlanePlace>& places() const { return places_; }
  VkDeviceAddress address_of(Plane plane) const;  // 0: not wanted

 private:
  void upload_labels(gpu::Recorder& recorder, gpu::UploadBelt& belt, const Taken& taken);
  gpu_types::OutputsWanted wanted_of(const Taken& taken, uint32_t view, const CameraHistory* last) const;
  void keep_histories(gpu::Recorder& recorder, const Taken& taken, std::span<CameraHistory> histories);
  std::shared_ptr<gpu::Buffer> free_places(VkDeviceSize bytes);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer planes_;
  gpu::Buffer labels_;                                     // PartLabels[part]
  std::vector<std::shared_ptr<gpu::Buffer>> kept_places_;  // what histories hold, and what is free again
  std::shared_ptr<gpu::Buffer> places_now_;                // of this frame; null: not kept yet
  std::vector<PlanePlace> places_;
  VkExtent2D extent_{};  // of a view
  uint32_t samples_;
  uint64_t scenes_ = 0;
};

}  // namespace fire3dv::passes
