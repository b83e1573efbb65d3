// Draws scenes for tests: one device for the whole program (lavapipe, by the environment that CTest sets),
// validation always on. Where device or layer is missing, tests fail; they never skip.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>

#include "renderer/gpu/device.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::test {

// The program's device. Aborts the program with a reason when there is none.
gpu::Instance& instance();
gpu::Device& device();
// The same one, opened once more.
std::unique_ptr<gpu::Device> open_device(gpu::AsyncCompute async_compute);

// An image with its planes.
struct Taken {
  sinks::FrameImage image;  // colours, where they were wanted
  std::vector<passes::PlanePlace> places;
  std::vector<uint8_t> planes;

  // T: float, uint32_t, a vector: what the plane's pixels are made of.
  template <typename T>
  std::vector<T> plane(passes::Plane wanted) const {
    for (const passes::PlanePlace& place : places) {
      if (place.plane != wanted) continue;
      std::vector<T> pixels(place.size_bytes / sizeof(T));
      std::memcpy(pixels.data(), planes.data() + place.offset_bytes, place.size_bytes);
      return pixels;
    }
    ADD_FAILURE() << "the image has no such plane";
    return {};
  }
};

// Draws one image and waits for it.
class RenderBench {
 public:
  RenderBench(const scene::Scene& scene, VkExtent2D extent, const passes::DrawSettings& settings = {},
              gpu::Device& on = device());

  sinks::FrameImage draw(const state::PoseState& poses, const passes::View& view);
  Taken take(const state::PoseState& poses, const passes::View& view, const passes::ImageOutputs& outputs,
             passes::CameraHistory* history = nullptr);
  // As many as set_size() has been told: one below the other.
  Taken take(const state::PoseState& poses, std::span<const passes::View> views,
             const passes::ImageOutputs& outputs, std::span<passes::CameraHistory> histories = {});
  // From the scene's first camera, everything at rest.
  sinks::FrameImage draw_at_rest();
  // Draws as many images as there are poses, without waiting for one before the next. From the first camera.
  std::vector<sinks::FrameImage> draw_on(state::PoseState& poses, const std::vector<state::RestPose>& moved);
  // How images from now on are marked.
  void set_held(state::Condition condition) { held_ = condition; }
  passes::SceneRenderer& renderer() { return renderer_; }
  gpu::FrameRing& frames() { return frames_; }

 private:
  void record_and_submit(const state::PoseState& poses, const passes::View& view);
  void collect(std::vector<sinks::FrameImage>& images, bool all);

  const scene::Scene& scene_;
  gpu::FrameRing frames_;
  passes::SceneRenderer renderer_;
  passes::ReadbackBelt<int> readback_;
  state::Condition held_ = state::Condition::live;
};

passes::View first_camera_view(const scene::Scene& scene, const state::PoseState& poses, VkExtent2D extent);

// Every render test ends with this: nothing was found by core or synchronisation validation.
class ValidationIsSilent : public ::testing::Test {
 protected:
  void TearDown() override;
};

glm::ivec3 pixel(const sinks::FrameImage& image, uint32_t x, uint32_t y);

}  // namespace fire3dv::test
