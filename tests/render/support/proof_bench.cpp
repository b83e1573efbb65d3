// Bench with one renderer for many scenes, and brightness comparison.
#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {

settings::DrawSettings plain_settings(uint32_t samples) {
  settings::DrawSettings settings;
  settings.raster = settings::RasterPath::visibility;
  settings.samples = samples;
  settings.shadows.method = settings::ShadowMethod::off;
  settings.environment_intensity = 0;
  settings.background.color = {0, 0, 0};
  settings.post.fxaa = false;
  settings.post.tone_map = settings::ToneMap::none;
  return settings;
}

settings::DrawSettings shadowed_by(settings::ShadowMethod method, bool hybrid, uint32_t samples) {
  settings::DrawSettings settings = plain_settings(samples);
  settings.shadows.method = method;
  settings.shadows.hybrid = hybrid;
  return settings;
}

settings::DrawSettings with_fine_maps(settings::DrawSettings settings) {
  settings.shadows.map_side = kFineMapSide;
  return settings;
}

ProofBench::ProofBench(VkExtent2D extent, const settings::DrawSettings& settings)
    : nothing_(SceneBuilder().build()), scene_(&nothing_), bench_(nothing_, extent, settings) {}

void ProofBench::show(const scene::Scene& scene) {
  scene_ = &scene;
  bench_.renderer().set_scene(scene);
}

sinks::FrameImage ProofBench::draw(const scene::Camera& camera, const glm::mat4& world_from_camera) {
  const VkExtent2D extent = bench_.renderer().extent();
  const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
  return bench_.draw(state::PoseState(*scene_), passes::make_view(camera, world_from_camera, aspect));
}

sinks::FrameImage ProofBench::draw(glm::vec3 eye, glm::vec3 target, float vertical_fov_rad, float near_m) {
  scene::Camera camera;
  camera.vertical_fov_rad = vertical_fov_rad;
  camera.near_m = near_m;
  return draw(camera, passes::look_at_pose(eye, target));
}

sinks::FrameImage ProofBench::draw_first_camera() {
  const state::PoseState poses(*scene_);
  return bench_.draw(poses, first_camera_view(*scene_, poses, bench_.renderer().extent()));
}

Brightness compare_brightness(const sinks::FrameImage& image, const sinks::FrameImage& other, int more_than) {
  Brightness result;
  for (uint32_t y = 0; y < other.height; ++y) {
    for (uint32_t x = 0; x < other.width; ++x) {
      const glm::ivec3 a = pixel(image, x, y), b = pixel(other, x, y);
      const int more = a.r + a.g + a.b - b.r - b.g - b.b;
      if (more > more_than) {
        ++result.brighter;
        result.x = x;
        result.y = y;
      }
      result.darker += more < -more_than;
      (b.r + b.g + b.b > 0 ? result.bright : result.dark) += 1;
    }
  }
  return result;
}

}  // namespace fire3dv::test
