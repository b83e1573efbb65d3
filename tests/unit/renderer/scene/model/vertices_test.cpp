// Test of packed vertices: precision of normals and tangents, and optional attribute arrays.
#include "renderer/scene/model/vertices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace fire3dv::scene {
namespace {

double degrees_between(const glm::vec3& a, const glm::vec3& b) {
  const glm::dvec3 x(a), y(b);
  return glm::degrees(std::atan2(glm::length(glm::cross(x, y)), glm::dot(x, y)));
}

glm::vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
}

// Packs and unpacks a single vertex.
VertexAttributes packed_and_back(const glm::vec3& normal, const glm::vec4& tangent) {
  Scene scene;
  append_attributes(scene, std::vector{VertexAttributes{.tangent = tangent, .normal = normal}});
  return attributes_of(scene, 0);
}

TEST(PackedVertices, DirectionsComeBack) {
  std::mt19937 random(1);
  double normals = 0, tangents = 0;
  for (int i = 0; i < 100'000; ++i) {
    const glm::vec3 normal = random_direction(random), tangent = random_direction(random);
    const float sign = i % 2 ? 1 : -1;
    const VertexAttributes back = packed_and_back(normal * 3.0f, glm::vec4(tangent * 0.2f, sign));
    normals = std::max(normals, degrees_between(back.normal, normal));
    tangents = std::max(tangents, degrees_between(glm::vec3(back.tangent), tangent));
    ASSERT_EQ(back.tangent.w, sign);
    ASSERT_NEAR(glm::length(back.normal), 1, 1e-4f);
    ASSERT_NEAR(glm::length(glm::vec3(back.tangent)), 1, 1e-4f);
  }
  EXPECT_LT(normals, 0.002);
  EXPECT_LT(tangents, 0.003);
}

TEST(PackedVertices, AxesAreExact) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0f, -1.0f}) {
      glm::vec3 direction(0);
      direction[axis] = sign;
      for (const float w : {1.0f, -1.0f}) {
        const VertexAttributes back = packed_and_back(direction, glm::vec4(direction, w));
        EXPECT_EQ(back.normal, direction);
        EXPECT_EQ(back.tangent, glm::vec4(direction, w));
      }
    }
  }
}

TEST(PackedVertices, ZeroVectorsGetADirection) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  for (const glm::vec3& none : {glm::vec3(0), glm::vec3(INFINITY), glm::vec3(NAN, 0, 0)}) {
    const VertexAttributes back = packed_and_back(none, glm::vec4(none, 1));
    EXPECT_EQ(back.normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(back.tangent, glm::vec4(1, 0, 0, 1));
  }
  EXPECT_EQ(packed_and_back({0, -kLargest, 0}, {0, 0, kLargest, 1}).normal, glm::vec3(0, -1, 0));
  EXPECT_EQ(packed_and_back({0, -kLargest, 0}, {0, 0, kLargest, 1}).tangent, glm::vec4(0, 0, 1, 1));
}

TEST(PackedVertices, TangentsAreStoredOnDemand) {
  Scene scene;
  VertexAttributes plain, other;
  other.tangent = {0, -1, 0, -1};
  append_attributes(scene, std::vector(2, plain));
  EXPECT_TRUE(scene.tangents.empty());
  append_attributes(scene, std::vector{plain, other});
  append_attributes(scene, std::vector{plain});
  ASSERT_EQ(scene.tangents.size(), 5u);
  for (const uint32_t v : {0u, 1u, 2u, 4u}) EXPECT_EQ(tangent_of(scene, v), plain.tangent);
  EXPECT_EQ(tangent_of(scene, 3), other.tangent);
}

TEST(PackedVertices, ExtrasAreStoredOnDemand) {
  Scene scene;
  VertexAttributes plain;
  plain.uv0 = {0.25f, -3};
  append_attributes(scene, std::vector(2, plain));
  EXPECT_TRUE(scene.extras.empty());
  EXPECT_FALSE(has_color(scene, 1));
  VertexAttributes second = plain, colored = plain;
  second.uv1 = {7, 0.5f};
  colored.color = {0, 51 / 255.0f, 1, 0.5f};
  append_attributes(scene, std::vector{plain, second, colored});
  append_attributes(scene, std::vector{plain});
  ASSERT_EQ(scene.frames.size(), 6u);
  ASSERT_EQ(scene.uvs.size(), 6u);
  ASSERT_EQ(scene.extras.size(), 6u);
  for (const uint32_t v : {0u, 1u, 2u, 5u}) {
    EXPECT_EQ(attributes_of(scene, v).uv0, plain.uv0);
    EXPECT_EQ(attributes_of(scene, v).uv1, glm::vec2(0));
    EXPECT_EQ(attributes_of(scene, v).color, glm::vec4(1));
  }
  EXPECT_EQ(attributes_of(scene, 3).uv1, second.uv1);
  EXPECT_EQ(attributes_of(scene, 3).color, glm::vec4(1));
  EXPECT_FALSE(has_color(scene, 3));
  EXPECT_TRUE(has_color(scene, 4));
  const glm::vec4 color = attributes_of(scene, 4).color;
  EXPECT_EQ(glm::vec3(color), glm::vec3(colored.color)) << "numbers of 8 bits are exact";
  EXPECT_NEAR(color.a, 0.5f, 1e-5f);
}

}  // namespace
}  // namespace fire3dv::scene
