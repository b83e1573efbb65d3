// Render test of tangent frames: a normal map gives the same image as geometry with the tilted normals.
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "renderer/scene/model/bounds.h"
#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{128, 128};
constexpr glm::vec3 kTexel(153, 90, 216);  // of 255; leans along the tangent and against the bitangent

glm::vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
}

// Large and small squares before the eye, with random tangents and signs, and random normals that face it.
// eye_z: 1 or -1.
scene::Scene squares(bool by_normal_map, float eye_z) {
  SceneBuilder builder;
  scene::Material material = matte({0.7f, 0.7f, 0.7f});
  if (by_normal_map) {
    material.normal_texture.texture =
        builder.texture(1, 1, false, [](float, float) { return glm::vec4(kTexel / 255.0f, 1); });
  }
  const uint32_t number = builder.material(material);
  std::mt19937 random(3);
  for (const int side : {5, 40}) {
    for (int i = 0; i < side * side; ++i) {
      std::vector<glm::vec3> positions;
      std::vector<scene::VertexAttributes> attributes(4);
      const glm::vec3 towards(0, 0, 1.5f * eye_z);
      const glm::vec3 normal = glm::normalize(random_direction(random) + towards);
      const glm::vec3 tangent = glm::normalize(glm::cross(normal, random_direction(random)));
      const float sign = random() % 2 ? 1 : -1;
      const glm::vec3 tilt = glm::normalize(kTexel / 255.0f * 2.0f - 1.0f);
      const glm::vec3 tilted =
          tilt.x * tangent + tilt.y * sign * glm::cross(normal, tangent) + tilt.z * normal;
      const float size = 0.95f / static_cast<float>(side);
      const glm::vec3 corner(static_cast<float>(i % side) / static_cast<float>(side) - (side == 5 ? 1 : 0),
                             static_cast<float>(i / side) / static_cast<float>(side) - 0.5f, 0);
      for (int c = 0; c < 4; ++c) {
        positions.push_back((corner + size * glm::vec3(c == 1 || c == 2, c >= 2, 0)) *
                            glm::vec3(eye_z, 1, 1));
        attributes[static_cast<size_t>(c)].normal = by_normal_map ? normal : tilted;
        attributes[static_cast<size_t>(c)].tangent = glm::vec4(tangent, sign);
      }
      builder.mesh_node("square", builder.mesh(number, positions, attributes, {0, 1, 2, 0, 2, 3}),
                        glm::mat4(1));
    }
  }
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-0.3f, -0.4f, -eye_z}));
  builder.camera_node("camera", {0, 0, 3 * eye_z}, {0, 0, 0});
  return builder.build();
}

// A square with the default tangents, which a scene need not store, rotated by its joint or by its node.
scene::Scene turned_square(bool by_joint) {
  SceneBuilder builder;
  scene::Material material = matte({0.7f, 0.7f, 0.7f});
  material.normal_texture.texture =
      builder.texture(1, 1, false, [](float, float) { return glm::vec4(kTexel / 255.0f, 1); });
  const std::vector<glm::vec3> positions{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const uint32_t mesh = builder.mesh(builder.material(material), positions,
                                     std::vector<scene::VertexAttributes>(4), {0, 1, 2, 0, 2, 3});
  const glm::mat4 turned = glm::rotate(glm::mat4(1), 1.2f, glm::normalize(glm::vec3(0.2f, 0.3f, 1)));
  const uint32_t node = builder.mesh_node("square", mesh, by_joint ? glm::mat4(1) : turned);
  const uint32_t joint = builder.mesh_node("joint", scene::kNone, by_joint ? turned : glm::mat4(1));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-0.6f, -0.4f, -1}));
  builder.camera_node("camera", {0, 0, 4}, {0, 0, 0});
  scene::Scene scene = builder.build();
  if (!by_joint) return scene;
  scene.skins.push_back({"", 0, 1});
  scene.joints.push_back({joint, glm::mat4(1)});
  scene.nodes[node].skin = 0;
  scene::Primitive& primitive = scene.primitives[0];
  primitive.first_influence = 0;
  primitive.influence_sets = 1;
  primitive.joint_limit = 1;
  scene.influences.assign(positions.size(), {{0, 0, 0, 0}, {1, 0, 0, 0}});
  scene::bound_deformed_primitives(scene);
  return scene;
}

class Tangents : public ValidationIsSilent {};

TEST_F(Tangents, NormalMapIsRotatedToWorld) {
  for (const float eye_z : {1.0f, -1.0f}) {
    const scene::Scene mapped = squares(true, eye_z), tilted = squares(false, eye_z);
    for (const settings::RasterPath path :
         {settings::RasterPath::visibility, settings::RasterPath::forward}) {
      settings::DrawSettings settings = plain_settings(1);
      settings.raster = path;
      RenderBench bench(mapped, kExtent, settings), reference(tilted, kExtent, settings);
      EXPECT_TRUE(matches_image(bench.draw_at_rest(), reference.draw_at_rest(),
                                path == settings::RasterPath::forward ? "tangents_forward" : "tangents",
                                Tolerance::colour()));
    }
  }
}

TEST_F(Tangents, FollowJointsThoughSceneKeepsNone) {
  const scene::Scene posed = turned_square(true), still = turned_square(false);
  ASSERT_TRUE(posed.tangents.empty());
  RenderBench bench(posed, kExtent, plain_settings(1)), reference(still, kExtent, plain_settings(1));
  EXPECT_TRUE(matches_image(bench.draw_at_rest(), reference.draw_at_rest(), "tangents_of_joints",
                            Tolerance::colour()));
}

}  // namespace
}  // namespace fire3dv::test
