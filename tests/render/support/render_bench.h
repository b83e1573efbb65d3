// Test bench of the renderer: one device for the whole program (lavapipe, selected by CTest's environment),
// always with validation layers. Without the device or the layers tests fail; they never skip.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "renderer/gpu/device/device.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/marker_registry.h"

namespace fire3dv::test {

// The program's instance and device. Abort the program with a reason if there is none.
gpu::Instance& instance();
gpu::Device& device();
// Opens the same device again.
std::unique_ptr<gpu::Device> open_device(gpu::AsyncCompute async_compute);

// An image with its output planes.
struct Taken {
  sinks::FrameImage image;  // colours, if requested
  std::vector<passes::PlaneRange> places;
  std::vector<uint8_t> planes;

  // T: type of the plane's pixels: float, uint32_t, or a vector.
  template <typename T>
  std::vector<T> plane(wire::ImageOutput wanted) const {
    for (const passes::PlaneRange& place : places) {
      if (place.output != wanted) continue;
      std::vector<T> pixels(place.size_bytes / sizeof(T));
      std::memcpy(pixels.data(), planes.data() + place.offset_bytes, place.size_bytes);
      return pixels;
    }
    ADD_FAILURE() << "the image has no such plane";
    return {};
  }
};

// Draws images synchronously.
class RenderBench {
 public:
  RenderBench(const scene::Scene& scene, VkExtent2D extent, const settings::DrawSettings& settings = {},
              gpu::Device& on = device());

  sinks::FrameImage draw(const state::PoseState& poses, const passes::View& view);
  // Adds one submission of paths to the image that refines, and draws it.
  sinks::FrameImage refine(const state::PoseState& poses, const passes::View& view);
  Taken take(const state::PoseState& poses, const passes::View& view, const passes::ImageOutputs& outputs,
             passes::CameraHistory* history = nullptr);
  // Draws several views, stacked vertically.
  Taken take(const state::PoseState& poses, std::span<const passes::View> views,
             const passes::ImageOutputs& outputs, std::span<passes::CameraHistory> histories = {});
  // The same with poses of several worlds.
  Taken take(std::span<const state::PoseState* const> poses, std::span<const passes::View> views,
             const passes::ImageOutputs& outputs, std::span<passes::CameraHistory> histories = {});
  // Draws the scene at rest from its first camera.
  sinks::FrameImage draw_at_rest();
  // Draws one image per pose from the first camera, with frames in flight.
  std::vector<sinks::FrameImage> draw_on(state::PoseState& poses, const std::vector<state::RestPose>& moved);
  // Sets the stream condition that marks later images.
  void set_condition(state::Condition condition) { condition_ = condition; }
  // Whether the view of later images moves; see passes::FrameRequest.
  void set_in_motion(bool in_motion) { in_motion_ = in_motion; }
  // Shows these markers in later images of draw() and take(). Null: none are requested.
  void set_markers(const std::vector<state::ShownMarker>* markers) {
    shows_markers_ = markers != nullptr;
    if (markers) renderer_.set_markers(*markers);
  }
  // Sets the size of later images and allocates their targets.
  void set_size(VkExtent2D extent);
  // Prepares an image of this size; fails the test without memory.
  passes::PreparedFrame prepare(passes::FrameRequest request = {});
  // Changes settings of later images: change(settings::DrawSettings&).
  template <typename Change>
  void change_settings(Change&& change) {
    settings::DrawSettings settings = renderer_.settings().draw();
    change(settings);
    renderer_.apply(settings);
  }
  passes::SceneRenderer& renderer() { return renderer_; }
  gpu::FrameRing& frames() { return frames_; }

 private:
  void record_and_submit(const state::PoseState& poses, const passes::View& view, bool refines = false);
  void collect(std::vector<sinks::FrameImage>& images, bool all);

  const scene::Scene& scene_;
  gpu::FrameRing frames_;
  passes::SceneRenderer renderer_;
  gpu::ReadbackRing<int> readback_;
  VkExtent2D extent_{};
  bool shows_markers_ = false, in_motion_ = false;
  state::Condition condition_ = state::Condition::live;
};

passes::View first_camera_view(const scene::Scene& scene, const state::PoseState& poses, VkExtent2D extent);

// Base class of render tests: each ends without messages of core or synchronisation validation.
class ValidationIsSilent : public ::testing::Test {
 protected:
  void TearDown() override;
};

glm::ivec3 pixel(const sinks::FrameImage& image, uint32_t x, uint32_t y);

}  // namespace fire3dv::test
