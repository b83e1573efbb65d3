#include "renderer/scene/packed_vertices.h"

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

TEST(PackedVertices, DirectionsComeBack) {
  std::mt19937 random(1);
  double normals = 0, tangents = 0;
  for (int i = 0; i < 100'000; ++i) {
    const glm::vec3 normal = random_direction(random);
    const glm::vec3 tangent = glm::normalize(glm::cross(normal, random_direction(random)));
    const TangentFrame frame = packed_frame(normal * 3.0f, glm::vec4(tangent * 0.2f, i % 2 ? 1 : -1));
    normals = std::max(normals, degrees_between(normal_of(frame), normal));
    tangents = std::max(tangents, degrees_between(glm::vec3(tangent_of(frame)), tangent));
    ASSERT_EQ(tangent_of(frame).w, i % 2 ? 1 : -1);
    ASSERT_NEAR(glm::length(normal_of(frame)), 1, 1e-4f);
    ASSERT_NEAR(glm::length(glm::vec3(tangent_of(frame))), 1, 1e-6f);
    ASSERT_NEAR(glm::dot(glm::vec3(tangent_of(frame)), normal_of(frame)), 0, 1e-4f);
  }
  EXPECT_LT(normals, 0.002);
  EXPECT_LT(tangents, 0.01);
}

TEST(PackedVertices, AxesAreExact) {
  for (int n = 0; n < 3; ++n) {
    for (int t = 0; t < 3; ++t) {
      for (const float sign : {1.0f, -1.0f}) {
        if (n == t) continue;
        glm::vec3 normal(0);
        glm::vec4 tangent(0, 0, 0, -1);
        normal[n] = sign;
        tangent[t] = sign;
        const TangentFrame frame = packed_frame(normal, tangent);
        EXPECT_EQ(normal_of(frame), normal);
        EXPECT_EQ(tangent_of(frame), tangent);
      }
    }
  }
}

TEST(PackedVertices, OfATangentThePartThatIsPerpendicularIsKept) {
  const glm::vec4 slanted(0.6f, 0, 5, 1);
  EXPECT_EQ(tangent_of(packed_frame({0, 0, 1}, slanted)), glm::vec4(1, 0, 0, 1));
}

TEST(PackedVertices, WhatHasNoDirectionGetsOne) {
  constexpr float kLargest = std::numeric_limits<float>::max(), kInfinite = INFINITY;
  for (const glm::vec3& normal : {glm::vec3(0), glm::vec3(kInfinite), glm::vec3(NAN, 0, 0)})
    EXPECT_EQ(normal_of(packed_frame(normal, {1, 0, 0, 1})), glm::vec3(0, 0, 1));
  EXPECT_EQ(normal_of(packed_frame({0, -kLargest, 0}, {1, 0, 0, 1})), glm::vec3(0, -1, 0));
  for (const glm::vec3& tangent : {glm::vec3(0), glm::vec3(0, 3, 0), glm::vec3(kLargest), glm::vec3(NAN)}) {
    const TangentFrame frame = packed_frame({0, 1, 0}, glm::vec4(tangent, 1));
    EXPECT_NEAR(glm::length(glm::vec3(tangent_of(frame))), 1, 1e-6f);
    EXPECT_EQ(glm::dot(glm::vec3(tangent_of(frame)), normal_of(frame)), 0);
  }
}

TEST(PackedVertices, ExtrasAreKeptOnceAVertexHasSome) {
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
