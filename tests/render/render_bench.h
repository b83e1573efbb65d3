// Draws scenes for tests: one device for the whole program (lavapipe, by the environment that CTest sets), validation
// always on. Where device or layer is missing, tests fail; they never skip.
#pragma once

#include <gtest/gtest.h>

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

// Draws one image and waits for it.
class RenderBench {
 public:
  RenderBench(const scene::Scene& scene, VkExtent2D extent, const passes::DrawSettings& settings = {});

  sinks::FrameImage draw(const state::PoseState& poses, const passes::View& view);
  // From the scene's first camera, everything at rest.
  sinks::FrameImage draw_at_rest();
  passes::SceneRenderer& renderer() { return renderer_; }

 private:
  const scene::Scene& scene_;
  gpu::FrameRing frames_;
  passes::SceneRenderer renderer_;
  passes::ReadbackBelt<int> readback_;
};

passes::View first_camera_view(const scene::Scene& scene, const state::PoseState& poses, VkExtent2D extent);

// Every render test ends with this: nothing was found by core or synchronisation validation.
class ValidationIsSilent : public ::testing::Test {
 protected:
  void TearDown() override;
};

glm::ivec3 pixel(const sinks::FrameImage& image, uint32_t x, uint32_t y);

}  // namespace fire3dv::test
