// Watertightness test: no background shows through closed meshes from a thousand views. Pixels well inside of
// the known silhouette must show the mesh; pixels near the outline do not count.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "renderer/scene/model/bounds.h"
#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

using glm::mat4;
using glm::vec3;

constexpr VkExtent2D kExtent{64, 48};

scene::Material glowing() {
  scene::Material material = matte({1, 1, 1});
  material.unlit = true;
  return material;
}

class Watertight : public ValidationIsSilent {
 protected:
  static ProofBench& bench(uint32_t samples) {
    static ProofBench one(kExtent, plain_settings(1));
    static ProofBench four(kExtent, plain_settings(4));
    return samples == 4 ? four : one;
  }

  // inside(origin, direction): true if the ray hits a convex body within the mesh. A pixel is well inside if
  // the rays through the centres of its 3x3 neighbourhood are.
  template <typename Inside>
  static uint32_t holes(const sinks::FrameImage& image, const mat4& pose, float fov_rad, const Inside& inside,
                        uint64_t& looked_at) {
    const float up = std::tan(fov_rad / 2),
                aspect = static_cast<float>(kExtent.width) / static_cast<float>(kExtent.height);
    const vec3 eye(pose[3]);
    std::vector<bool> covered((kExtent.width + 2) * (kExtent.height + 2));
    auto at_pixel = [&](int x, int y) {
      return static_cast<size_t>(y + 1) * (kExtent.width + 2) + static_cast<size_t>(x + 1);
    };
    for (int y = -1; y <= static_cast<int>(kExtent.height); ++y) {
      for (int x = -1; x <= static_cast<int>(kExtent.width); ++x) {
        const vec3 camera_direction(((static_cast<float>(x) + 0.5f) / kExtent.width * 2 - 1) * up * aspect,
                                    (1 - (static_cast<float>(y) + 0.5f) / kExtent.height * 2) * up, -1);
        covered[at_pixel(x, y)] = inside(eye, glm::normalize(glm::mat3(pose) * camera_direction));
      }
    }
    uint32_t found = 0;
    for (int y = 0; y < static_cast<int>(kExtent.height); ++y) {
      for (int x = 0; x < static_cast<int>(kExtent.width); ++x) {
        bool well_inside = true;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) well_inside = well_inside && covered[at_pixel(x + dx, y + dy)];
        }
        if (!well_inside) continue;
        ++looked_at;
        found += pixel(image, static_cast<uint32_t>(x), static_cast<uint32_t>(y)) != glm::ivec3(255);
      }
    }
    return found;
  }

  static vec3 any_direction(std::mt19937& random) {
    std::normal_distribution<float> normal;
    return glm::normalize(vec3(normal(random), normal(random), normal(random)));
  }
};

// A ball's mesh lies within its sphere and contains a slightly smaller one; an affine map turns both into
// ellipsoids.
struct Ellipsoid {
  mat4 node_from_world;
  float radius;
  bool operator()(vec3 eye, vec3 direction) const {
    const vec3 o(node_from_world * glm::vec4(eye, 1)), d(node_from_world * glm::vec4(direction, 0));
    const float b = glm::dot(o, d), c = glm::dot(o, o) - radius * radius, a = glm::dot(d, d);
    return b < 0 && b * b - a * c > 0;
  }
};

using Shape = std::function<vec3(float, float)>;
vec3 on_ball(float theta, float phi) {
  return {std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)};
}

TEST_F(Watertight, BallsFineBumpyRoughAndStretched) {
  std::mt19937 random(3);
  std::mt19937 noise(5);
  std::uniform_real_distribution<float> share(0, 1);
  struct Case {
    const char* name;
    Shape shape;
    uint32_t segments;
    float held;  // radius of the contained ball
    mat4 pose;
    int views;
  };
  const mat4 stretched = at({3, -2, 1}) * glm::rotate(mat4(1), 1.0f, vec3(0, 0.6f, 0.8f)) *
                         glm::scale(mat4(1), vec3(-2, 0.3f, 1));
  auto bumpy = [](float theta, float phi) {
    return on_ball(theta, phi) * (1 + 0.2f * std::sin(9 * theta) * std::sin(theta) * std::sin(11 * phi));
  };
  // Crumpled: folds smaller than a pixel everywhere.
  auto rough = [&](float theta, float phi) {
    return on_ball(theta, phi) * (0.9f + 0.1f * share(noise)) +
           0.01f * vec3(share(noise), share(noise), share(noise));
  };
  const std::vector<Case> cases = {{"fine", on_ball, 256, 0.995f, mat4(1), 150},
                                   {"coarse", on_ball, 12, 0.9f, mat4(1), 100},
                                   {"bumpy", bumpy, 96, 0.75f, mat4(1), 150},
                                   {"rough", rough, 192, 0.85f, mat4(1), 150},
                                   {"stretched and mirrored", bumpy, 96, 0.75f, stretched, 150}};
  uint64_t looked_at = 0;
  int views = 0;
  for (const Case& test : cases) {
    SceneBuilder builder;
    builder.mesh_node("ball", builder.lathe(builder.material(glowing()), test.shape, test.segments),
                      test.pose);
    const scene::Scene scene = builder.build();
    const Ellipsoid inside{glm::inverse(test.pose), test.held};
    for (uint32_t samples : {1u, 4u}) {
      bench(samples).show(scene);
      for (int i = 0; i < test.views / 2; ++i, ++views) {
        const vec3 center(test.pose[3]);
        const vec3 eye = center + any_direction(random) * (2.3f + 6 * share(random) * share(random));
        const vec3 target = center + 0.5f * share(random) * any_direction(random);
        const sinks::FrameImage image = bench(samples).draw(eye, target, 0.8f);
        ASSERT_EQ(holes(image, passes::look_at_pose(eye, target), 0.8f, inside, looked_at), 0u)
            << test.name << ", view " << i << ", " << samples << " samples";
      }
    }
  }
  EXPECT_EQ(views, 700);
  EXPECT_GT(looked_at, 200000u);
}

// A ball inflated by a morph target and pulled apart by two joints; at rest it lies within the ball of radius
// 1.
scene::Scene pulled_ball(const mat4& world_from_root, vec3 pull) {
  SceneBuilder builder;
  const uint32_t mesh = builder.lathe(builder.material(glowing()), on_ball, 128);
  const uint32_t node = builder.mesh_node("ball", mesh, at({5, 5, 5}));
  const uint32_t root = builder.mesh_node("root", scene::kNone, world_from_root);
  const uint32_t tip = builder.mesh_node("tip", scene::kNone, at(pull), root);
  scene::Scene scene = builder.build();
  scene::Primitive& primitive = scene.primitives[0];
  primitive.first_influence = primitive.first_morph_delta = 0;
  primitive.influence_sets = primitive.morph_target_count = 1;
  primitive.joint_limit = 2;
  for (const vec3& p : scene.positions) {
    const float weight = glm::smoothstep(-0.2f, 0.8f, p.y);
    scene.influences.push_back({{0, 1, 0, 0}, {1 - weight, weight, 0, 0}});
    scene.morph_deltas.push_back(
        {p * (0.2f + 0.2f * std::sin(40 * p.x) * std::sin(40 * p.z)), vec3(0), vec3(0)});
  }
  scene.joints = {{root, mat4(1)}, {tip, mat4(1)}};
  scene.skins = {{"bones", 0, 2}};
  scene.meshes[mesh].morph_target_count = 1;
  scene.nodes[node].skin = 0;
  scene.nodes[node].morph_weight_count = 1;
  scene.morph_weights = {0.7f};
  scene::bound_deformed_primitives(scene);
  return scene;
}

TEST_F(Watertight, BallsThatJointsAndTargetsDeform) {
  std::mt19937 random(13);
  std::uniform_real_distribution<float> share(0, 1);
  const mat4 root = at({-1, 2, 0.5f}) * glm::rotate(mat4(1), 1.3f, vec3(0.6f, 0, 0.8f)) *
                    glm::scale(mat4(1), vec3(0.8f, 1.1f, -1));
  const scene::Scene scene = pulled_ball(root, {0.1f, 0.6f, 0});
  const Ellipsoid inside{glm::inverse(root), 0.9f};
  uint64_t looked_at = 0;
  for (uint32_t samples : {1u, 4u}) {
    bench(samples).show(scene);
    for (int i = 0; i < 50; ++i) {
      const vec3 center(root[3]);
      const vec3 eye = center + any_direction(random) * (3 + 5 * share(random));
      const vec3 target = center + 0.5f * share(random) * any_direction(random);
      const sinks::FrameImage image = bench(samples).draw(eye, target, 0.8f);
      ASSERT_EQ(holes(image, passes::look_at_pose(eye, target), 0.8f, inside, looked_at), 0u)
          << "view " << i << ", " << samples << " samples";
    }
  }
  EXPECT_GT(looked_at, 10000u);
}

// Boxes of kilometres with the eye on or among them: triangles cross the near plane and leave the guard band,
// and many share long edges.
TEST_F(Watertight, HugeBoxesCloseToTheEye) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> share(0, 1);
  uint64_t looked_at = 0;
  for (float half : {1.0f, 300.0f, 20000.0f}) {
    SceneBuilder builder;
    const uint32_t white = builder.material(glowing());
    // The top consists of 8 x 8 pieces of different lengths, so that edges cross the eye plane at many
    // positions.
    std::vector<vec3> positions;
    std::vector<uint32_t> indices;
    const float steps[] = {-1, -0.3f, -0.01f, -1e-4f, 0, 1e-3f, 0.05f, 0.4f, 1};
    for (uint32_t z = 0; z < 9; ++z) {
      for (uint32_t x = 0; x < 9; ++x) {
        positions.push_back(half * vec3(steps[x], 0, steps[z]));
        if (x == 8 || z == 8) continue;
        const uint32_t a = z * 9 + x;
        for (uint32_t i : {a, a + 9, a + 1, a + 1, a + 9, a + 10}) indices.push_back(i);
      }
    }
    builder.mesh_node("ground", builder.triangles(white, positions, indices), mat4(1));
    const scene::Scene scene = builder.build();
    auto inside = [&](vec3 eye, vec3 direction) {
      if (direction.y >= -1e-6f) return false;
      const vec3 hit = eye - direction * (eye.y / direction.y);
      return std::abs(hit.x) < half && std::abs(hit.z) < half;
    };
    for (uint32_t samples : {1u, 4u}) {
      bench(samples).show(scene);
      for (int i = 0; i < 50; ++i) {
        const vec3 eye = vec3(0.3f * half * (2 * share(random) - 1) * std::pow(share(random), 4.0f),
                              0.02f + 0.5f * share(random),
                              0.3f * half * (2 * share(random) - 1) * std::pow(share(random), 4.0f));
        const vec3 target = eye + vec3(2 * share(random) - 1, -0.6f * share(random), 2 * share(random) - 1);
        const sinks::FrameImage image = bench(samples).draw(eye, target, 0.8f);
        ASSERT_EQ(holes(image, passes::look_at_pose(eye, target), 0.8f, inside, looked_at), 0u)
            << half << " m, view " << i << ", " << samples << " samples";
      }
    }
  }
  EXPECT_GT(looked_at, 100000u);
}

}  // namespace
}  // namespace fire3dv::test
