// Bench for tests with many scenes and views and few renderers. Direct light only, without environment, tone
// mapping and anti-aliasing, so that bytes are comparable.
#pragma once

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

passes::DrawSettings plain_settings(uint32_t samples = 1);
passes::DrawSettings shadowed_by(passes::ShadowMethod method, bool hybrid = true, uint32_t samples = 1);
// Selects shadow maps at the resolution that a GPU uses with hybrid shadows, on any device.
passes::DrawSettings with_fine_maps(passes::DrawSettings settings);
constexpr uint32_t kFineMapSide = 2048;

// One renderer for successive scenes.
class ProofBench {
 public:
  ProofBench(VkExtent2D extent, const passes::DrawSettings& settings);

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

}  // namespace fire3dv::test
