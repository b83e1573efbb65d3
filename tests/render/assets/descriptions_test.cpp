// Golden image test of small robots from URDF and MJCF description files; the goldens were reviewed by eye.
#include <gtest/gtest.h>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{240, 180};

class Descriptions : public ValidationIsSilent {};

convert::Model read(const std::string& file) {
  const std::filesystem::path path = std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/assets/robots" / file;
  auto model = convert::read_description(path, {});
  EXPECT_TRUE(model.ok()) << model.error().message;
  if (!model) return {};
  for (const std::string& warning : model->warnings) ADD_FAILURE() << warning;
  return std::move(*model);
}

sinks::FrameImage drawn(const convert::Model& model) {
  const auto glb = convert::write_glb(model);
  EXPECT_TRUE(glb.ok());
  const auto scene = scene::load_glb(*glb, model.name);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  if (!scene) return {};
  settings::DrawSettings settings;
  settings.background.show_environment = true;
  return RenderBench(*scene, kExtent, settings).draw_at_rest();
}

TEST_F(Descriptions, UrdfLooksAsItsGolden) {
  convert::Model model = read("arm_description/urdf/arm.urdf");
  convert::Node eye;  // URDF has no cameras
  eye.name = "eye";
  const glm::dvec3 place(1.7, -1.6, 1.3), target(0.3, 0.15, 0.45);
  eye.translation = place;
  eye.rotation = glm::quatLookAt(glm::normalize(target - place), glm::dvec3(0, 0, 1));
  eye.camera = 0;
  model.cameras.push_back({"eye", 0.6f});
  model.nodes.push_back(eye);
  EXPECT_TRUE(matches_golden(drawn(model), "description_urdf", Tolerance::colour()));
}

TEST_F(Descriptions, MjcfLooksAsItsGolden) {
  EXPECT_TRUE(matches_golden(drawn(read("arm.xml")), "description_mjcf", Tolerance::colour()));
}

TEST_F(Descriptions, BodyCamerasSeeMjcf) {
  convert::Model model = read("arm.xml");
  model.nodes.front().camera.reset();  // the free camera
  EXPECT_TRUE(matches_golden(drawn(model), "description_mjcf_wrist", Tolerance::colour()));
}

}  // namespace
}  // namespace fire3dv::test
