// Captured images: asynchronous read-back with provenance, and the instances in them with their boxes and
// names.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/wire/image_outputs.h"
#include "renderer/capture/amodal.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/model/scene.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::capture {

// Bounding boxes of the visible instances, sorted by instance.
struct VisibleBoxes {
  std::vector<wire::BoxRecord2d> boxes2d;
  std::vector<wire::BoxRecord3d> boxes3d;
};
// instance_plane: kInstanceU32 in rows of `width` pixels, at any alignment. known: boxes of all instances at
// the image's poses.
VisibleBoxes find_visible_boxes(std::span<const uint8_t> instance_plane, uint32_t width,
                                std::span<const wire::BoxRecord3d> known);

// One line of JSON per node with a mesh: instance, class, name and path.
std::string list_instances(const scene::Scene& scene);

struct Provenance {
  uint64_t frame_index = 0;  // of this run of the renderer, from 0
  std::string camera;
  std::vector<state::FrameTag> shown;  // displayed pose frames
  std::optional<sinks::PathTraced> path_traced = std::nullopt;
  std::vector<std::string> hidden_streams = {};      // whose content the image lacks
  std::shared_ptr<const std::string> run = nullptr;  // see sinks::encode_provenance()
};

// Settings and samples so far of the image that the renderer has traced, for Provenance. nullopt: raster.
std::optional<sinks::PathTraced> path_provenance(const passes::SceneRenderer& renderer);

// Asynchronous read-back of rendered images and planes, each with its provenance. Finished captures arrive
// frames later, in order and without a stall.
class CaptureQueue {
 public:
  explicit CaptureQueue(gpu::Device& device) : readback_(device) {}

  // Records a copy of the colours only. Call submitted() with the frame's timeline value.
  void record(gpu::Recorder& recorder, gpu::Image& color, Provenance provenance);
  // Records a copy of these outputs of the image that `renderer` has recorded with at least
  // with_sources(outputs).
  void record(gpu::Recorder& recorder, passes::SceneRenderer& renderer, wire::ImageOutputs outputs,
              const scene::Scene& scene, const state::PoseState& poses, Provenance provenance);
  void submitted(uint64_t timeline_value) { readback_.submitted(timeline_value); }

  // Hands over all finished images, oldest first.
  void poll(const std::function<void(sinks::FrameImage&&)>& take);
  // The same to a sink, up to its first error; later images are dropped.
  Result<void> deliver(sinks::FrameSink& sink);

  size_t in_flight() const { return readback_.in_flight(); }

 private:
  struct Capture {
    wire::ImageOutputs outputs;
    std::vector<passes::PlaneRange> plane_ranges;
    std::vector<wire::BoxRecord3d> boxes;  // of all instances, if boxes are requested
    std::vector<Silhouetted> silhouetted;  // if silhouettes are requested
    Provenance provenance;
  };
  static sinks::FrameImage convert(Capture&& capture, VkExtent2D extent, std::span<const uint8_t> bytes);

  gpu::ReadbackRing<Capture> readback_;
};

}  // namespace fire3dv::capture
