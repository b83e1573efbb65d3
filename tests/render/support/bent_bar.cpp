// Geometry of the bent bar: one mesh for the GPU, and its shape computed on the CPU.
#include "tests/render/support/bent_bar.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/model/bounds.h"

namespace fire3dv::test {
namespace {

constexpr float kHalfWidth = 0.2f, kLength = 2, kTipHeight = 1;
constexpr uint32_t kRings = 12;

struct Shape {
  std::vector<glm::vec3> positions;
  std::vector<scene::VertexAttributes> attributes;
  std::vector<uint32_t> indices;
};

// The four sides and both ends of the section of the bar between two heights.
Shape bar_piece(float low, float high) {
  Shape shape;
  const auto add_quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    for (const uint32_t i : {a, b, c, a, c, d}) shape.indices.push_back(i);
  };
  const auto add_vertex = [&](glm::vec3 position, glm::vec3 normal, glm::vec3 tangent, glm::vec2 uv) {
    shape.positions.push_back(position);
    shape.attributes.push_back({.tangent = glm::vec4(tangent, 1), .uv0 = uv, .uv1 = uv, .normal = normal});
  };
  for (int side = 0; side < 4; ++side) {
    const float angle = static_cast<float>(side) * 1.5707963f;
    const glm::vec3 normal(std::sin(angle), 0, std::cos(angle)), along(std::cos(angle), 0, -std::sin(angle));
    const auto first = static_cast<uint32_t>(shape.positions.size());
    for (uint32_t ring = 0; ring <= kRings; ++ring) {
      const float v = static_cast<float>(ring) / static_cast<float>(kRings);
      for (const float u : {-1.0f, 1.0f}) {
        add_vertex(kHalfWidth * (normal + u * along) + glm::vec3(0, low + v * (high - low), 0), normal, along,
                   {0.5f + 0.5f * u, 2 * v});
      }
    }
    for (uint32_t ring = 0; ring < kRings; ++ring) {
      const uint32_t a = first + 2 * ring;
      add_quad(a, a + 1, a + 3, a + 2);
    }
  }
  for (const float end : {-1.0f, 1.0f}) {
    const auto first = static_cast<uint32_t>(shape.positions.size());
    for (const glm::vec2 corner : {glm::vec2(-1, 1), glm::vec2(1, 1), glm::vec2(1, -1), glm::vec2(-1, -1)}) {
      add_vertex({end * corner.x * kHalfWidth, end < 0 ? low : high, corner.y * kHalfWidth}, {0, end, 0},
                 {end, 0, 0}, 0.5f * corner + 0.5f);
    }
    add_quad(first, first + 1, first + 2, first + 3);
  }
  return shape;
}

std::vector<Shape> bar() {
  return {bar_piece(0, kTipHeight), bar_piece(kTipHeight, kLength)};
}

float tip_weight(const glm::vec3& position) {
  return glm::smoothstep(0.6f, 1.4f, position.y);
}

// Displacement away from the axis, largest halfway up; normals tilt upwards.
scene::MorphDelta bulge_of(const glm::vec3& position) {
  const float much = 0.5f * std::sin(3.1415927f * position.y / kLength);
  return {glm::vec3(much * position.x, 0, much * position.z), glm::vec3(0, 0.5f, 0), glm::vec3(0)};
}

void deform(Shape& shape, const BarPose& pose, bool with_skin) {
  for (size_t i = 0; i < shape.positions.size(); ++i) {
    const scene::MorphDelta delta = bulge_of(shape.positions[i]);
    const float weight = tip_weight(shape.positions[i]);
    scene::VertexAttributes& attributes = shape.attributes[i];
    glm::vec3 position = shape.positions[i] + pose.bulge * delta.position;
    glm::vec3 normal = glm::normalize(attributes.normal + pose.bulge * delta.normal);
    glm::vec3 tangent(attributes.tangent);
    if (with_skin) {
      const glm::mat4 by_tip =
          pose.world_from_root * pose.root_from_tip * glm::inverse(at({0, kTipHeight, 0}));
      const glm::mat4 world = (1 - weight) * pose.world_from_root + weight * by_tip;
      position = glm::vec3(world * glm::vec4(position, 1));
      normal = glm::normalize(glm::transpose(glm::inverse(glm::mat3(world))) * normal);
      tangent = glm::mat3(world) * tangent;
    }
    shape.positions[i] = position;
    attributes.normal = normal;
    attributes.tangent =
        glm::vec4(glm::normalize(tangent - normal * glm::dot(normal, tangent)), attributes.tangent.w);
  }
}

// Adds one mesh of both pieces and returns its index.
uint32_t add_bar(SceneBuilder& builder, const std::vector<Shape>& pieces) {
  scene::Material masked = matte({0.8f, 0.5f, 0.2f});
  masked.alpha_mode = scene::AlphaMode::mask;
  masked.base_color_texture.texture = builder.texture(16, 16, true, [](float u, float v) {
    return glm::vec4(1, 1, 1, std::hypot(u - 0.5f, v - 0.5f) < 0.3f ? 0 : 1);
  });
  masked.normal_texture.texture = builder.texture(16, 16, false, [](float u, float) {
    return glm::vec4(0.5f + 0.3f * std::sin(6.2831853f * u), 0.5f, 0.9f, 1);
  });
  const uint32_t first = builder.mesh(builder.material(matte({0.3f, 0.6f, 0.8f})), pieces[0].positions,
                                      pieces[0].attributes, pieces[0].indices);
  builder.mesh(builder.material(masked), pieces[1].positions, pieces[1].attributes, pieces[1].indices);
  return first;
}

void join_pieces(scene::Scene& scene, uint32_t first_mesh) {
  scene.meshes[first_mesh].primitive_count = 2;
}

void add_surroundings(SceneBuilder& builder) {
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.7f, 0.7f, 0.7f})), 20), glm::mat4(1));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.7f, -1, -0.3f}));
  builder.camera_node("camera", {1, 3, 6}, {0, 0.8f, 0});
}

void add_target(scene::Scene& scene, uint32_t mesh) {
  scene.meshes[mesh].morph_target_count = 1;
  for (uint32_t p = scene.meshes[mesh].first_primitive; p < scene.meshes[mesh].first_primitive + 2; ++p) {
    scene::Primitive& primitive = scene.primitives[p];
    primitive.morph_target_count = 1;
    primitive.first_morph_delta = static_cast<uint32_t>(scene.morph_deltas.size());
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      scene.morph_deltas.push_back(bulge_of(scene.positions[primitive.first_vertex + v]));
    }
  }
}

void add_weight(scene::Scene& scene, uint32_t node, float weight) {
  scene.nodes[node].first_morph_weight = static_cast<uint32_t>(scene.morph_weights.size());
  scene.nodes[node].morph_weight_count = 1;
  scene.morph_weights.push_back(weight);
}

void add_influences(scene::Scene& scene, uint32_t mesh) {
  for (uint32_t p = scene.meshes[mesh].first_primitive; p < scene.meshes[mesh].first_primitive + 2; ++p) {
    scene::Primitive& primitive = scene.primitives[p];
    primitive.first_influence = static_cast<uint32_t>(scene.influences.size());
    primitive.influence_sets = 1;
    primitive.joint_limit = 2;
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const float weight = tip_weight(scene.positions[primitive.first_vertex + v]);
      scene.influences.push_back({{1, 0, 0, 0}, {weight, 1 - weight, 0, 0}});
    }
  }
}

const glm::mat4 kBeside = at({1.6f, 0, -0.5f});
const glm::mat4 kMirroring = at({0, 0.1f, 0}) * glm::scale(glm::mat4(1), glm::vec3(-1.2f, 1, 1));

}  // namespace

scene::Scene skinned_bar(const BarPose& pose) {
  SceneBuilder builder;
  add_surroundings(builder);
  const uint32_t mesh = add_bar(builder, bar());
  // glTF ignores the transform of a skinned node.
  const uint32_t node = builder.mesh_node("bar", mesh, at({3, 1, 2}) * kMirroring);
  builder.mesh_node("beside", mesh, kBeside);
  const uint32_t root = builder.mesh_node("root", scene::kNone, pose.world_from_root);
  const uint32_t tip = builder.mesh_node("tip", scene::kNone, pose.root_from_tip, root);
  scene::Scene scene = builder.build();
  join_pieces(scene, mesh);
  add_target(scene, mesh);
  add_weight(scene, node, pose.bulge);
  add_influences(scene, mesh);
  scene.joints = {{root, glm::mat4(1)}, {tip, glm::inverse(at({0, kTipHeight, 0}))}};
  scene.skins = {{"bones", 0, 2}};
  scene.nodes[node].skin = 0;
  scene::bound_deformed_primitives(scene);
  scene::find_world_bounds(scene);
  return scene;
}

scene::Scene computed_bar(const BarPose& pose) {
  SceneBuilder builder;
  add_surroundings(builder);
  std::vector<Shape> pieces = bar();
  const uint32_t as_modelled = add_bar(builder, pieces);
  for (Shape& piece : pieces) deform(piece, pose, true);
  if (glm::determinant(glm::mat3(pose.world_from_root)) < 0) {
    for (Shape& piece : pieces) {
      for (size_t i = 0; i < piece.indices.size(); i += 3) std::swap(piece.indices[i], piece.indices[i + 1]);
    }
  }
  const uint32_t bent = add_bar(builder, pieces);
  builder.mesh_node("bar", bent, glm::mat4(1));
  builder.mesh_node("beside", as_modelled, kBeside);
  scene::Scene scene = builder.build();
  join_pieces(scene, as_modelled);
  join_pieces(scene, bent);
  scene::find_world_bounds(scene);
  return scene;
}

state::RestPose moved(const scene::Scene& skinned, const BarPose& pose) {
  state::RestPose rest = state::rest_pose(skinned);
  const uint32_t root = skinned.joints[0].node, tip = skinned.joints[1].node;
  rest.parent_from_node[root] = rest.world_from_node[root] = pose.world_from_root;
  rest.parent_from_node[tip] = pose.root_from_tip;
  rest.world_from_node[tip] = pose.world_from_root * pose.root_from_tip;
  rest.morph_weights = {pose.bulge};
  return rest;
}

scene::Scene morphed_bar(float bulge) {
  SceneBuilder builder;
  add_surroundings(builder);
  const uint32_t mesh = add_bar(builder, bar());
  const uint32_t node = builder.mesh_node("bar", mesh, kMirroring);
  scene::Scene scene = builder.build();
  join_pieces(scene, mesh);
  add_target(scene, mesh);
  add_weight(scene, node, bulge);
  scene::bound_deformed_primitives(scene);
  scene::find_world_bounds(scene);
  return scene;
}

scene::Scene computed_morphed_bar(float bulge) {
  SceneBuilder builder;
  add_surroundings(builder);
  std::vector<Shape> pieces = bar();
  for (Shape& piece : pieces) deform(piece, {glm::mat4(1), glm::mat4(1), bulge}, false);
  const uint32_t mesh = add_bar(builder, pieces);
  builder.mesh_node("bar", mesh, kMirroring);
  scene::Scene scene = builder.build();
  join_pieces(scene, mesh);
  scene::find_world_bounds(scene);
  return scene;
}

}  // namespace fire3dv::test
