// The scene's animations, evaluated: where nodes are that no stream moves, and what morph targets weigh.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/scene.h"

namespace fire3dv::state {

// Of each node, and laid out as Scene::morph_weights.
struct RestPose {
  std::vector<glm::mat4> parent_from_node, world_from_node;
  std::vector<float> morph_weights;
};
RestPose rest_pose(const scene::Scene& scene);

// A channel's value at a time, as glTF defines it; before the first key and after the last one theirs.
// `value` takes channel.width floats; rotations are normalised.
void sample(const scene::Scene& scene, const scene::AnimationChannel& channel, double time_s,
            std::span<float> value);

// What an argument of --animate means: an animation's name, its index, or "all": those that move nothing that
// an earlier one moves, since clips of one figure exclude each other. The error lists what there is.
Result<std::vector<uint32_t>> choose_animations(const scene::Scene& scene, const std::string& argument);

// "Walk" in quotes, or its index where it has no name.
std::string animation_title(const scene::Scene& scene, uint32_t animation);

// Plays animations in loops, each from 0 to its last key.
class AnimationPlayer {
 public:
  AnimationPlayer(const scene::Scene& scene, const std::vector<uint32_t>& animations);

  // Valid until the next call. Depends on the time alone, not on what was asked before.
  const RestPose& at(double time_s);

 private:
  struct Playing {
    uint32_t channel;
    float duration_s;
    uint32_t parts = scene::kNone;  // kNone: weights
  };
  struct Parts {
    uint32_t node;
    glm::vec3 translation, scale;
    glm::quat rotation;
  };
  void apply(const Playing& playing, double time_s);

  const scene::Scene& scene_;
  std::vector<Playing> playing_;
  std::vector<Parts> parts_;     // of the nodes whose transform is animated
  std::vector<uint32_t> moved_;  // they and all below them, parents first
  RestPose pose_;
  std::vector<float> value_;
};

}  // namespace fire3dv::state
