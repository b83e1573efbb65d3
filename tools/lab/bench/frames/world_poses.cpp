#include "tools/lab/bench/frames/world_poses.h"

#include <string>

#include <glm/gtc/matrix_transform.hpp>

namespace fire3dv::bench {
namespace {

constexpr uint64_t kEpoch = 1;
constexpr float kLargestTurnRad = 0.4f;

// SplitMix64, as a number from -1 to 1.
float random_number(uint64_t seed) {
  seed += 0x9e3779b97f4a7c15;
  seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9;
  seed = (seed ^ (seed >> 27)) * 0x94d049bb133111eb;
  seed ^= seed >> 31;
  return static_cast<float>(seed >> 40) / static_cast<float>(1u << 23) - 1;
}

wire::Affine3x4 affine_of(const glm::mat4& matrix) {
  wire::Affine3x4 affine;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      affine.m[static_cast<size_t>(row * 4 + column)] = matrix[column][row];
  }
  return affine;
}

}  // namespace

WorldPoses::WorldPoses(const scene::Scene& scene, uint32_t worlds) {
  find_bodies(scene);
  wire::StreamDescription description;
  description.adapter_name = "bench";
  description.epoch = kEpoch;
  for (const Body& body : bodies_) names_.push_back(scene.nodes[body.node].path);
  description.node_names = names_;
  poses_.resize(bodies_.size() * worlds);
  for (uint32_t world = 0; world < worlds; ++world) {
    state::PoseState& state = states_.emplace_back(scene);
    worlds_.push_back(&state);
    if (!bodies_.empty()) streams_.push_back(state.add_stream(description));
  }
}

void WorldPoses::find_bodies(const scene::Scene& scene) {
  std::vector<uint32_t> body_of_node(scene.nodes.size(), scene::kNone);
  for (uint32_t i = 0; i < scene.nodes.size(); ++i) {
    const scene::Node& node = scene.nodes[i];
    const uint32_t above = node.parent == scene::kNone ? scene::kNone : body_of_node[node.parent];
    body_of_node[i] = above;
    if (node.mesh == scene::kNone) continue;
    const glm::mat4 world_from_parent =
        above == scene::kNone ? glm::mat4(1) : scene.nodes[bodies_[above].node].world_from_node;
    body_of_node[i] = static_cast<uint32_t>(bodies_.size());
    bodies_.push_back({i, above, glm::inverse(world_from_parent) * node.world_from_node});
  }
}

void WorldPoses::simulate(uint32_t step) {
  std::vector<glm::mat4> world_from_body(bodies_.size());
  for (size_t world = 0; world < worlds_.size(); ++world) {
    for (size_t b = 0; b < bodies_.size(); ++b) {
      const Body& body = bodies_[b];
      const uint64_t seed = (uint64_t{step} << 40) + (uint64_t{world} << 16) + b;
      const glm::mat4 at_rest = body.parent == scene::kNone
                                    ? body.parent_from_body
                                    : world_from_body[body.parent] * body.parent_from_body;
      world_from_body[b] = glm::rotate(at_rest, kLargestTurnRad * random_number(seed), glm::vec3(0, 0, 1));
      poses_[world * bodies_.size() + b] = affine_of(world_from_body[b]);
    }
  }
}

Result<void> WorldPoses::publish() {
  if (bodies_.empty()) return {};
  ++sequence_;
  for (size_t world = 0; world < worlds_.size(); ++world) {
    wire::PoseFrameView frame;
    frame.header.epoch = kEpoch;
    frame.header.sequence = sequence_;
    frame.node_count = static_cast<uint32_t>(bodies_.size());
    frame.poses = std::span<const wire::Affine3x4>(poses_).subspan(world * bodies_.size(), bodies_.size());
    if (!states_[world].push(streams_[world], frame))
      return Error{"world " + std::to_string(world) + " does not show the published poses"};
  }
  return {};
}

}  // namespace fire3dv::bench
