// Test of the benchmark scenes: triangle counts, sharing, determinism, visibility and motion match the
// report.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "renderer/passes/view/view.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/vertices.h"
#include "tools/lab/bench/bench_scene.h"
#include "tools/lab/bench/shapes.h"

namespace fire3dv::bench {
namespace {

constexpr float kAspect = 16.0f / 9;

const Surfaces& surfaces() {
  static const Surfaces made = make_surfaces(32);
  return made;
}

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(BenchScene, HasTheRequestedTriangles) {
  for (const SceneSize size :
       {SceneSize{1'000}, {5'000}, {223'000}, {550'000}, {223'000, 1'000}, {9'000, 3, 1}}) {
    const BenchScene made = make_bench_scene(size, surfaces(), kAspect);
    uint64_t drawn = 0;
    for (const scene::Node& node : made.scene.nodes) {
      if (node.mesh != scene::kNone)
        drawn += made.scene.primitives[made.scene.meshes[node.mesh].first_primitive].index_count / 3;
    }
    EXPECT_EQ(drawn, made.triangles);
    const auto wanted = static_cast<double>(size.triangles);
    EXPECT_NEAR(static_cast<double>(drawn), wanted, 0.01 * wanted) << size.triangles << " " << size.bodies;
    EXPECT_EQ(made.bodies.size(), size.bodies ? size.bodies : bodies_for(size.triangles));
    EXPECT_EQ(made.scene.lights.size(), size.lights);
  }
  EXPECT_EQ(bodies_for(223'000), 200u);
  EXPECT_EQ(bodies_for(28'000'000), 1001u);
}

TEST(BenchScene, SharesHalfOfItsBodies) {
  const BenchScene made = make_bench_scene({223'000, 200}, surfaces(), kAspect);
  std::vector<uint32_t> uses(made.scene.meshes.size(), 0);
  for (const scene::Node& node : made.scene.nodes) {
    if (node.mesh != scene::kNone) ++uses[node.mesh];
  }
  uint32_t unique = 0, shared = 0;
  for (size_t m = 1; m < uses.size(); ++m) (uses[m] == 1 ? unique : shared) += uses[m];
  EXPECT_EQ(unique, 100u);
  EXPECT_EQ(shared, 100u);
  EXPECT_EQ(made.unique_triangles, made.scene.indices.size() / 3);
  EXPECT_LT(made.unique_triangles, 2 * made.triangles / 3);
}

TEST(BenchScene, SceneIsDeterministic) {
  const BenchScene a = make_bench_scene({50'000}, surfaces(), kAspect);
  const BenchScene b = make_bench_scene({50'000}, make_surfaces(32), kAspect);
  EXPECT_TRUE(same_bytes(a.scene.positions, b.scene.positions));
  EXPECT_TRUE(same_bytes(a.scene.frames, b.scene.frames));
  EXPECT_TRUE(same_bytes(a.scene.tangents, b.scene.tangents));
  EXPECT_TRUE(same_bytes(a.scene.uvs, b.scene.uvs));
  EXPECT_TRUE(same_bytes(a.scene.indices, b.scene.indices));
  ASSERT_EQ(a.scene.images.size(), b.scene.images.size());
  for (size_t i = 0; i < a.scene.images.size(); ++i)
    EXPECT_TRUE(a.scene.images[i].rgba8 == b.scene.images[i].rgba8) << a.scene.images[i].name;
  for (size_t n = 0; n < a.scene.nodes.size(); ++n) {
    EXPECT_EQ(a.scene.nodes[n].world_from_node, b.scene.nodes[n].world_from_node);
    EXPECT_EQ(a.scene.nodes[n].mesh, b.scene.nodes[n].mesh);
  }
  std::vector<wire::Affine3x4> at_a, at_b;
  pose_bodies(a.bodies, 77, at_a);
  pose_bodies(b.bodies, 77, at_b);
  EXPECT_TRUE(same_bytes(at_a, at_b));
}

TEST(BenchScene, VerticesStayInView) {
  for (const float aspect : {kAspect, 4.0f / 3, 0.5f}) {
    const BenchScene made = make_bench_scene({20'000}, surfaces(), aspect);
    const scene::Scene& scene = made.scene;
    const scene::Node& camera = scene.nodes[scene::camera_nodes(scene).at(0)];
    const passes::View view = passes::make_view(scene.cameras[camera.camera], camera.world_from_node, aspect);
    float widest = 0;
    std::vector<wire::Affine3x4> poses;
    for (const uint64_t step : {0u, 13u, 40u, 63u, 100u, 1000u}) {
      pose_bodies(made.bodies, step, poses);
      for (size_t b = 0; b < made.bodies.size(); ++b) {
        const scene::Node& node = scene.nodes[1 + b];
        ASSERT_EQ(node.name, made.body_names[b]);
        const scene::Primitive& primitive = scene.primitives[scene.meshes[node.mesh].first_primitive];
        const auto& m = poses[b].m;
        for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
          const glm::vec3 p = scene.positions[primitive.first_vertex + v];
          const glm::vec3 world(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                                m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                                m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
          const glm::vec4 clip = view.clip_from_world * glm::vec4(world, 1);
          ASSERT_GT(clip.w, 0) << node.name;
          ASSERT_LE(std::max(std::abs(clip.x), std::abs(clip.y)), clip.w) << node.name << " at step " << step;
          ASSERT_LE(clip.z, clip.w) << node.name << " before the near plane";
          widest = std::max(widest, std::max(std::abs(clip.x), std::abs(clip.y)) / clip.w);
        }
      }
    }
    EXPECT_GT(widest, 0.85f) << "the bodies leave the edges of the image empty";
  }
}

// Rodrigues' formula, independent of the matrix functions that the scene uses.
glm::dmat3 rotation_about(const glm::dvec3& axis, double angle_rad) {
  const glm::dmat3 cross(0, axis.z, -axis.y, -axis.z, 0, axis.x, axis.y, -axis.x, 0);
  return glm::dmat3(1) + std::sin(angle_rad) * cross + (1 - std::cos(angle_rad)) * cross * cross;
}

TEST(BenchScene, BodiesTurnAndOscillate) {
  const BenchScene made = make_bench_scene({5'000}, surfaces(), kAspect);
  std::vector<wire::Affine3x4> poses;
  for (const uint64_t step : {0u, 1u, 4u, 5u, 63u, 400u}) {
    pose_bodies(made.bodies, step, poses);
    ASSERT_EQ(poses.size(), made.bodies.size());
    for (size_t b = 0; b < poses.size(); ++b) {
      const Body& body = made.bodies[b];
      const double steps = static_cast<double>(step), scale = static_cast<double>(body.scale);
      const glm::dvec3 axis(body.axis);
      ASSERT_NEAR(glm::length(axis), 1, 1e-5);
      const glm::dmat3 turn = rotation_about(axis, static_cast<double>(body.angle_rad) + 0.03 * steps);
      const double rise = 0.1 * scale * (1 + std::sin(static_cast<double>(body.phase_rad) + 0.05 * steps));
      for (int row = 0; row < 3; ++row) {
        const auto at = [&](int column) {
          return static_cast<double>(poses[b].m[static_cast<size_t>(4 * row + column)]);
        };
        for (int column = 0; column < 3; ++column)
          EXPECT_NEAR(at(column), scale * turn[column][row], 1e-4) << "body " << b << ", step " << step;
        EXPECT_NEAR(at(3), static_cast<double>(body.home_m[row]) + (row == 1 ? rise : 0), 1e-4)
            << "body " << b << ", step " << step;
      }
    }
  }
}

TEST(BenchScene, BodiesRestAtStepZero) {
  const BenchScene made = make_bench_scene({5'000}, surfaces(), kAspect);
  std::vector<wire::Affine3x4> poses;
  pose_bodies(made.bodies, 0, poses);
  for (size_t b = 0; b < poses.size(); ++b) {
    const glm::mat4& rest = made.scene.nodes[1 + b].world_from_node;
    for (int i = 0; i < 12; ++i)
      EXPECT_EQ(rest[i % 4][i / 4], poses[b].m[static_cast<size_t>(i)]) << made.body_names[b];
  }
}

// Shadow maps treat closed meshes specially.
TEST(BenchScene, MeshesAreClosed) {
  const BenchScene made = make_bench_scene({9'000, 12}, surfaces(), kAspect);
  for (size_t m = 1; m < made.scene.meshes.size(); ++m)
    EXPECT_EQ(scene::classify_caster(made.scene, made.scene.meshes[m]).shape, scene::CasterShape::closed)
        << m;
  EXPECT_EQ(scene::classify_caster(made.scene, made.scene.meshes[0]).shape, scene::CasterShape::planar);
  for (size_t i = 0; i < made.scene.indices.size() / 3; ++i) {
    const scene::Primitive* primitive = nullptr;
    for (const scene::Primitive& candidate : made.scene.primitives) {
      if (3 * i >= candidate.first_index && 3 * i < candidate.first_index + candidate.index_count)
        primitive = &candidate;
    }
    glm::vec3 corner[3], normal(0);
    for (size_t c = 0; c < 3; ++c) {
      const size_t v = primitive->first_vertex + made.scene.indices[3 * i + c];
      corner[c] = made.scene.positions[v];
      const glm::vec3 own = scene::normal_of(made.scene.frames[v]);
      const glm::vec3 tangent(scene::tangent_of(made.scene, static_cast<uint32_t>(v)));
      normal += own;
      EXPECT_NEAR(glm::length(own), 1, 1e-4f);
      EXPECT_NEAR(glm::length(tangent), 1, 1e-4f);
      EXPECT_NEAR(glm::dot(tangent, own), 0, 1e-4f);
    }
    const glm::vec3 flat = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    ASSERT_GT(glm::dot(glm::normalize(flat), glm::normalize(normal)), 0.7f) << "triangle " << i;
  }
}

}  // namespace
}  // namespace fire3dv::bench
