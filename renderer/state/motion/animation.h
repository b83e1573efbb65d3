// Animation player of a scene: transforms of animated nodes and morph target weights at a time. It evaluates
// channels as glTF defines them; times are in seconds. Not thread-safe.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::state {

// Rest pose of every node, and morph weights in the layout of Scene::morph_weights.
struct RestPose {
  std::vector<glm::mat4> parent_from_node, world_from_node;
  std::vector<float> morph_weights;
};
RestPose rest_pose(const scene::Scene& scene);

// Evaluates a channel as glTF defines it. Times outside the keys are clamped to the first and last key.
// `value` has room for channel.width floats; rotations are normalised.
void sample(const scene::Scene& scene, const scene::AnimationChannel& channel, double time_s,
            std::span<float> value);

// Parses the argument of --animate: an animation's name, its index, or "all". "all" leaves out animations
// whose nodes an earlier animation moves, since clips of one figure exclude each other. The error lists the
// choices.
Result<std::vector<uint32_t>> choose_animations(const scene::Scene& scene, const std::string& argument);

// The animation's name in quotes, or its index if it has no name.
std::string animation_title(const scene::Scene& scene, uint32_t animation);

// Plays animations in loops from time 0 to their last key.
class AnimationPlayer {
 public:
  AnimationPlayer(const scene::Scene& scene, const std::vector<uint32_t>& animations);

  double duration_s() const;  // of the longest one
  // The result is a pure function of the time. It is valid until the next call.
  const RestPose& at(double time_s);

 private:
  struct Playing {
    uint32_t channel;
    float duration_s;
    uint32_t parts = scene::kNone;  // kNone: morph weights
  };
  struct Parts {
    uint32_t node;
    glm::vec3 translation, scale;
    glm::quat rotation;
  };
  void apply(const Playing& playing, double time_s);

  const scene::Scene& scene_;
  std::vector<Playing> playing_;
  std::vector<Parts> parts_;     // of nodes with an animated transform
  std::vector<uint32_t> moved_;  // these nodes and their descendants, parents first
  RestPose pose_;
  std::vector<float> value_;
};

}  // namespace fire3dv::state
